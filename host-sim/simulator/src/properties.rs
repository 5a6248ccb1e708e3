//! What holds of any bytes that reach a device or its tools, as functions that fail by an
//! assertion.
//!
//! The tests with random input, the fuzzer's targets (`fuzz/`) and the seeds that it keeps call the
//! same ones, so that what one of them finds the others repeat.

pub mod file;
pub mod frame;
pub mod record;
pub mod session;
