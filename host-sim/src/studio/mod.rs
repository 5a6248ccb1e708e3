//! `stiction studio`: a page that shows a device live, and commands it.
//!
//! ```text
//! page --- WebSocket --> socket.rs --- bounded queue of requests --> worker.rs --- Client --
//! device
//!      <---------------- socket.rs <-- news.rs: bounded ring -------/  (a thread of its own)
//!      --- the last prediction of each page --> forecaster.rs: a simulated twin (another thread)
//! ```
//!
//! The page computes no control: it shows the values of the device, and those of a simulated twin
//! that predicts the device's moves.
//!
//! Guarantees:
//! - A page without the [token](guard::Token), or of another origin, cannot connect, and sends
//!   nothing to the device.
//! - One page at a time commands the device, and every page may stop it ([`control`]).
//! - If another client has the motor driven, the studio is a guest: it shows the state, stops, and
//!   takes over if a page requests it.
//! - While the output is on, the studio sends no automatic request to its own device. A keep-alive
//!   of the device follows a keep-alive of the page that commands (`worker.rs`). If that page is
//!   gone, the device receives nothing, and its link timeout turns the output off.
//! - A prediction or a tuning sends nothing to the device, does not delay it, and is no keep-alive.
//! - A page that reads too slowly loses samples; their numbers show which. Such a page then
//!   receives the last event of each kind again. It never delays the device or another page.
//!
//! Limits: the connection is not encrypted, so other machines on a network that the studio listens
//! on can read the token. A request leaves up to 10 ms late, since one thread waits for samples and
//! for requests. `save` blocks both while the device writes.
//!
//! | file | contents |
//! |---|---|
//! | `request.rs` | requests of a page |
//! | `news.rs` | messages to all pages: events as JSON, samples as binary frames |
//! | `control.rs` | arbiter of the page that commands |
//! | `desk.rs` | state shared by connections and threads: requests, answers, parameters in use |
//! | `worker.rs` | the thread of the device |
//! | `orders.rs`, `publish.rs` | execution of a page's requests, and the events that it publishes |
//! | `selftest.rs` | the moves of a self-test, each after a keep-alive of its page |
//! | `gear.rs`, `pending_gear.rs` | the moves for the gear between two encoders, after an identification |
//! | `form.rs` | the parameters as a form |
//! | `forecaster.rs`, `prediction.rs` | the thread of the predictions, and a prediction |
//! | `cloud.rs` | predictions on joints around the one in use |
//! | `machine_in_use.rs` | the device's parameters with a joint, of the file or identified |
//! | `knobs.rs` | sliders for the machine in use |
//! | `tuner.rs`, `spare_cores.rs` | tuning on a thread of its own, which leaves a core free |
//! | `guard.rs`, `listener.rs` | token, origin and host; the number of connections |
//! | `refusals.rs` | reports of refusals at the terminal |
//! | `socket.rs`, `server.rs` | connection of a page; the HTTP server |
//! | `assets.rs` | files of the page |
//! | `playground.rs` | all of this except the server, for a page that contains it |

mod cloud;
pub mod control;
mod desk;
mod forecaster;
mod form;
mod gear;
mod knobs;
mod machine_in_use;
mod news;
mod orders;
mod pending_gear;
mod playground;
mod prediction;
mod publish;
mod request;
mod selftest;
mod spare_cores;
mod tuner;
mod worker;

// The server, which the playground does not need.
#[cfg(feature = "studio")]
pub mod assets;
#[cfg(feature = "studio")]
pub mod guard;
#[cfg(feature = "studio")]
mod listener;
#[cfg(feature = "studio")]
mod refusals;
#[cfg(feature = "studio")]
mod server;
#[cfg(feature = "studio")]
mod socket;

pub use news::StudioMessage;
pub use playground::Playground;
#[cfg(feature = "studio")]
pub use server::{Server, StudioOptions};
