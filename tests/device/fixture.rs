//! The thesis's machine and its parameters, for tests of devices.

use simulator::device;
use simulator::experiment::RunPlan;
use simulator::flash::{SECTOR, SimulatedFlash};
use stiction::Parameters;
use stiction::parameters::store::Store;

/// The slots of a flash of two sectors.
pub const SLOTS: [u32; 2] = [0, SECTOR];

/// Plans all runs of an experiment, with keys set.
pub fn plans(name: &str, set: &[&str]) -> Vec<RunPlan> {
    experiments::experiment(name, &[], set).runs
}

/// The parameters that a device needs for a run.
pub fn parameters(plan: &RunPlan) -> Parameters {
    device::parameters(plan).unwrap()
}

/// The parameters of SRNF on the thesis's robot, with keys set.
pub fn srnf(set: &[&str]) -> Parameters {
    let set = [&["loop.controller=srnf", "reference.steps_deg=[5.0]"], set].concat();
    parameters(&plans("step-response", &set)[0])
}

/// A store in an erased flash.
pub fn blank() -> Store<SimulatedFlash> {
    Store::new(SimulatedFlash::new(2), SLOTS)
}

/// A store that holds parameters.
pub fn stored(parameters: &Parameters) -> Store<SimulatedFlash> {
    let mut store = blank();
    store.save(parameters).unwrap();
    store
}
