//! Runs whole sessions, whose script is read from any bytes.
#![cfg_attr(feature = "fuzzing", no_main)]

use std::sync::LazyLock;

use simulator::device::machine_file;
use stiction::Parameters;

/// A machine of the thesis.
static MACHINE: LazyLock<Parameters> = LazyLock::new(|| {
    let builtin = simulator::experiment::find("step-response");
    let toml = builtin.map(|builtin| builtin.toml).unwrap_or_default();
    machine_file::read("step-response", toml).expect("a built-in machine is valid")
});

libfuzzer_sys::fuzz_target!(|script: &[u8]| {
    simulator::properties::session::holds(&MACHINE, script);
});

/// Without the fuzzer the target is compiled, so that the lints see it, and does nothing.
#[cfg(not(feature = "fuzzing"))]
const fn main() {}
