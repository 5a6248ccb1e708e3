//! What a run leaves behind: a table for people, JSON, CSV that can be read back; and the guard that
//! every output file passes, which is written whole or not at all.

mod cell;
pub mod columns;
pub mod csv;
mod file;
mod guard;
pub mod json;
pub mod series;
pub mod sides;
pub mod table;

pub use cell::Cell;
pub use guard::{OutputDirectory, OutputFile, OverwriteGuard};
