//! Decodes a record of parameters from any bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    simulator::properties::record::holds(bytes);
});
