//! Reads a machine's file from any text.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    simulator::properties::file::holds(text);
});
