//! `stiction studio`: a page that shows a device live, and drives it.
//!
//! ```text
//! page --- WebSocket --> socket.rs --- bounded queue of orders --> worker.rs --- Client -- device
//!      <---------------- socket.rs <-- news.rs: bounded ring -----/  (a thread of its own)
//!      --- wishes, the last one of each page --> forecaster.rs: a simulated twin (another thread)
//! ```
//!
//! The page computes nothing of control: it gets the numbers of the device, and of a simulated twin
//! that predicts what the device would do.
//!
//! Guarantees:
//! - A page without the [token](guard::Token), or of another origin, gets no connection, and
//!   nothing of it reaches the device.
//! - One page at a time commands the device, and every page may stop it ([`control`]).
//! - While the output is on, the studio asks the device nothing of its own accord. Each sign of
//!   life is a word of the page that commands (`worker.rs`). If that page is gone, the device hears
//!   nothing, and its link timeout turns the output off.
//! - A prediction or a tuning asks the device nothing, delays nobody who does, and is no sign of
//!   life.
//! - A page that reads too slowly loses samples, and can tell which by their numbers. It is told
//!   again what stands. It never delays the device or another page.
//!
//! Does badly: the connection is not encrypted, so whoever reads a network that the studio was told
//! to listen on reads the token, too. A request takes up to 10 ms to leave, since one thread waits
//! for samples and for orders. `save` stops both for as long as the device takes.
//!
//! | file | what it does |
//! |---|---|
//! | `request.rs` | what a page may ask for |
//! | `news.rs` | what all pages are told: events as JSON, samples as binary frames |
//! | `control.rs` | which page commands |
//! | `desk.rs` | what connections and threads share: orders, answers, what the device runs |
//! | `worker.rs` | the thread that talks to the device |
//! | `orders.rs`, `told.rs` | what it does for a page, and what it tells all |
//! | `selftest.rs` | the moves of a self-test, each on a word of the page that has begun it |
//! | `form.rs` | the parameters as a form |
//! | `forecaster.rs`, `prediction.rs` | the thread that predicts, and how |
//! | `cloud.rs` | the same on joints that are drawn around the one in use |
//! | `machine_in_use.rs` | the device's parameters with a joint, of the file or identified |
//! | `knobs.rs` | what of it can be turned |
//! | `wording.rs` | refusals of commands in the words of a page |
//! | `tuner.rs`, `spare_cores.rs` | tunes gains on a thread of its own, which leaves a core free |
//! | `guard.rs`, `listener.rs` | token, origin and host; the number of connections |
//! | `refusals.rs` | what is told at the terminal of what was refused |
//! | `socket.rs`, `server.rs` | one page's connection; the HTTP around it |
//! | `assets.rs` | the page itself, as it was built in |
//! | `playground.rs` | all of this but the server, for a page that has it in itself |

mod cloud;
pub mod control;
mod desk;
mod forecaster;
mod form;
mod knobs;
mod machine_in_use;
mod news;
mod orders;
mod playground;
mod prediction;
mod request;
mod selftest;
mod spare_cores;
mod told;
mod tuner;
mod wording;
mod worker;

// The server, which a page that runs all of the above by itself does without.
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

pub use news::News;
pub use playground::Playground;
#[cfg(feature = "studio")]
pub use server::{Server, Wanted};
