//! Files that a user writes: reading, checking and error messages.
//!
//! A [`document`] is opened, keys are set in it, and an error names its key by the path. The file
//! of a [`machine`] can describe its joint in SI ([`data_sheet`]); that of a friction experiment is
//! a [`setup`]. [`written`] reads and writes a table by the core's declarations, and [`keys`] lists
//! all keys.

pub mod data_sheet;
pub mod document;
pub mod encoder;
pub mod error;
pub mod file_text;
pub mod goal;
pub mod hardware;
pub mod keys;
pub mod lines;
pub mod machine;
pub mod missing_part;
pub mod setup;
pub mod typed_number;
pub mod written;

pub use error::Error;
