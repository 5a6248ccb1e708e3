//! What a run leaves behind: a table for people, JSON, CSV that can be read back; and files that
//! are written whole or not at all.

mod cell;
pub mod columns;
pub mod csv;
mod file;
pub mod json;
pub mod series;
pub mod table;

pub use cell::Cell;
pub use file::{prepare_directory, write_whole};
