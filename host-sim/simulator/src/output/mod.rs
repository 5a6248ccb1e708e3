//! Output of a run: a text table, JSON, and CSV that can be read back. Every output file passes a
//! guard, and is written completely or not at all.

mod arrays;
mod cell;
pub mod columns;
pub mod csv;
mod file;
pub mod grid;
mod guard;
pub mod json;
pub mod series;
pub mod sides;
pub mod table;

pub use arrays::arrays;
pub use cell::Cell;
pub use guard::{OutputDirectory, OutputFile, OverwriteGuard};
