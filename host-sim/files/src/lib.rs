//! What a person writes in a file, and is told of it.
//!
//! A [`document`] is opened, keys are set in it, and what is wrong with it is said by its path. That
//! of a [`machine`] may have its joint in SI ([`data_sheet`]); that of a friction experiment is a
//! [`setup`]. [`written`] reads and writes a table by the core's declarations, and [`keys`] lists all
//! of them.

pub mod data_sheet;
pub mod document;
pub mod encoder;
pub mod error;
pub mod goal;
pub mod hardware;
pub mod keys;
pub mod lines;
pub mod machine;
pub mod setup;
pub mod typed_number;
pub mod written;

pub use dynamics::{friction, joint, mechanism, solver};
pub use error::Error;
