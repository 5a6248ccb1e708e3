//! Decodes a record of parameters from any bytes.
#![cfg_attr(feature = "fuzzing", no_main)]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    simulator::properties::record::holds(bytes);
});

/// Without the fuzzer the target is compiled, so that the lints see it, and does nothing.
#[cfg(not(feature = "fuzzing"))]
const fn main() {}
