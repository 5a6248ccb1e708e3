//! An image and a simulated device of the same run, tick by tick from arming on.

use emulator::board_under_test::{BoardUnderTest, PlantInLockstep};
use emulator::setup::BoardSetup;
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::RunPlan;
use stiction::parameters::ROOM;
use stiction::servo::Boot;
use stiction::{Parameters, Tick};

use crate::common::firmware;

/// Status of an armed servo: bits 0 to 7.
pub const ARMED: u32 = 2;

/// Largest number of ticks until the servo is armed.
const LONGEST: u32 = 2000;

pub const fn is_armed(tick: &Tick) -> bool {
    tick.status & 0xFF == ARMED
}

/// Returns a board with these parameters and the joint of a run, at power-on.
pub fn board(plan: &RunPlan, parameters: &Parameters) -> BoardUnderTest {
    let mut room = [0; ROOM];
    let record = parameters.encode(1, &mut room).unwrap().to_vec();
    let setup = BoardSetup::new(&plan.label, &firmware(), record);
    BoardUnderTest::power_on(setup, PlantInLockstep::of(plan).unwrap()).unwrap()
}

/// Returns a simulated device with these parameters and the joint of a run, at power-on.
pub fn device(plan: &RunPlan, parameters: &Parameters) -> SimulatedDevice {
    SimulatedDevice::running(plan, parameters, Boot::at_zero()).unwrap()
}

/// Returns the next tick of both.
pub fn ticks(board: &mut BoardUnderTest, device: &mut SimulatedDevice) -> (Tick, Tick) {
    board.samples(1).unwrap();
    (board.act(|halted| halted.last_tick()).unwrap().unwrap(), device.tick().tick)
}

/// Returns the first armed tick of both, which boot for different times.
pub fn armed(board: &mut BoardUnderTest, device: &mut SimulatedDevice) -> (Tick, Tick) {
    let there = (0..LONGEST).map(|_| {
        board.samples(1).unwrap();
        board.act(|halted| halted.last_tick()).unwrap().unwrap()
    });
    let there = { there }.find(is_armed).unwrap();
    let here = (0..LONGEST).map(|_| device.tick().tick).find(is_armed).unwrap();
    (there, here)
}
