//! What a run leaves behind: a table for people, JSON, CSV; and files that are written whole or not at all.

pub mod csv;
mod file;
pub mod json;
pub mod table;

pub use file::{prepare_directory, write_whole};
