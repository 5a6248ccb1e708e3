//! The image under test, and plans to run on it.

use std::path::PathBuf;

use experiments::experiment;
use host_sim::emulator::Emulation;
use host_sim::experiment::RunPlan;

/// Set by `cargo xtask test`.
const IMAGE: &str = "STICTION_IMAGE";

/// The image's path. A test that cannot find it fails: one that is skipped looks like one that has
/// passed.
pub fn image() -> PathBuf {
    match std::env::var_os(IMAGE) {
        Some(path) => path.into(),
        None => panic!(
            "{IMAGE} does not name a flash image: run `cargo xtask test`, or `cargo xtask \
             firmware` \
             and then this with {IMAGE}=<the file that it leaves>"
        ),
    }
}

pub fn emulation() -> Emulation {
    Emulation::new(Some(&image())).unwrap()
}

/// The runs of an experiment with keys set as on the command line.
pub fn plans(name: &str, controllers: &[&str], set: &[&str]) -> Vec<RunPlan> {
    experiment(name, controllers, set).runs
}
