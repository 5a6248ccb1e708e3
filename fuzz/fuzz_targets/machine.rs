//! Reads a machine's file from any text.
#![cfg_attr(feature = "fuzzing", no_main)]

libfuzzer_sys::fuzz_target!(|text: &str| {
    simulator::properties::file::holds(text);
});

/// Without the fuzzer the target is compiled, so that the lints see it, and does nothing.
#[cfg(not(feature = "fuzzing"))]
const fn main() {}
