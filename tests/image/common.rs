//! The image under test, and plans to run on it.

use experiments::experiment;
pub use experiments::flash_image::{emulation, firmware, image};
use simulator::experiment::RunPlan;

/// The runs of an experiment with keys set as on the command line.
pub fn plans(name: &str, controllers: &[&str], set: &[&str]) -> Vec<RunPlan> {
    experiment(name, controllers, set).runs
}
