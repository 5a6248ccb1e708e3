//! Reads a machine's file from any text.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    host_sim::properties::file::holds(text);
});
