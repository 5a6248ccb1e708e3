//! Properties for any bytes that reach a device or its tools, as functions with assertions.
//!
//! The tests with random input, the fuzz targets (`fuzz/`) and their stored seeds call the same
//! functions, so that each can repeat a failure of the others.

pub mod file;
pub mod frame;
pub mod record;
pub mod session;
