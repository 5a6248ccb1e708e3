//! Looks for frames in any bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    simulator::properties::frame::holds(bytes);
});
