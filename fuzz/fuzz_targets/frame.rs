//! Looks for frames in any bytes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    host_sim::properties::frame::holds(bytes);
});
