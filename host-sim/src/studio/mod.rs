//! `stiction studio`: a page that shows a device live, and drives it.
//!
//! ```text
//! page --- WebSocket --> socket.rs --- bounded queue of orders --> worker.rs --- Client -- device
//!      <---------------- socket.rs <-- news.rs: bounded ring -----/  (a thread of its own)
//! ```
//!
//! The server computes nothing of control, and the page neither: both get numbers of the device.
//!
//! Guarantees:
//! - A page without the [token](guard::Token), or of another origin, gets no connection, and
//!   nothing of it reaches the device.
//! - One page at a time commands the device, and every page may stop it ([`control`]).
//! - While the output is on, the studio asks the device nothing of its own accord. Each sign of
//!   life is a word of the page that commands (`worker.rs`). If that page is gone, the device hears
//!   nothing, and its link timeout turns the output off.
//! - A page that reads too slowly loses samples, and can tell which by their numbers. It never
//!   delays the device or another page.
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
//! | `worker.rs`, `orders.rs` | the thread that talks to the device, and what it does for a page |
//! | `form.rs` | the parameters as a form |
//! | `guard.rs`, `listener.rs` | token, origin and host; the number of connections |
//! | `socket.rs`, `server.rs` | one page's connection; the HTTP around it |
//! | `assets.rs` | the page itself, as it was built in |

pub mod assets;
pub mod control;
mod form;
pub mod guard;
mod listener;
mod news;
mod orders;
mod request;
mod server;
mod socket;
mod worker;

pub use server::{Server, Wanted};
