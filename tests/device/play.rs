//! Play between the motor and an encoder on the load: how much of it trips nothing.

use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::experiment::RunPlan;
use stiction::servo::State;
use stiction::units::position::Position;
use stiction::{Course, Fault, Motion};

use crate::dead_encoder::step;
use crate::fixture::plans;
use experiments::axis_with_play::{COUNT_DEG, axis_with_play};
use experiments::controllers;

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

fn device(law: &str, play_deg: f64, stated_deg: f64) -> SimulatedDevice {
    let law = format!("loop.controller={law}");
    let stated = format!("limits.play_deg={stated_deg}");
    let set = [&*law, "reference.steps_deg=[5.0]", &*stated];
    let plan = plans("step-response", &set).swap_remove(0);
    let substitute = Some(axis_with_play(play_deg));
    let mut device = SimulatedDevice::new(&RunPlan { substitute, ..plan }).unwrap();
    device.ticks(50);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    device
}

/// Steps and moves, deg.
const TASKS: [(Task, f64); 4] =
    [(Task::Step, 0.5), (Task::Step, 5.0), (Task::Move, 20.0), (Task::Move, 1.0)];

#[derive(Clone, Copy, Debug)]
enum Task {
    Step,
    Move,
}

fn begin(device: &mut SimulatedDevice, (task, to_deg): (Task, f64)) {
    if matches!(task, Task::Step) {
        return step(device, to_deg);
    }
    let parameters = device.device.parameters().unwrap();
    let motion = Motion::Profiled(Position::from_counts((to_deg / COUNT_DEG) as i32));
    let course = motion.course(&parameters.controller, &parameters.profile).unwrap();
    let Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
    device.device.servo().go_to(profile).unwrap();
}

/// Runs a minute, or until a fault; returns the fault.
fn a_minute(device: &mut SimulatedDevice) -> Option<Fault> {
    let state = (0..MINUTE)
        .map(|_| {
            device.device.servo().heard();
            device.tick().state
        })
        .find(|state| *state != State::Armed)?;
    let State::Faulted(fault) = state else { unreachable!("{state:?}") };
    Some(fault)
}

/// A loop that hunts through its play is a fault of its own: oscillation, heat, and under `robust`,
/// whose file has the encoder on the motor, the following error.
#[test]
fn the_play_that_the_file_states_is_no_stall_under_any_law_and_unstated_it_is() {
    let mut unstated = 0;
    for law in controllers() {
        for task in TASKS {
            for play_deg in [0.2, 1.0, 3.0] {
                let mut device = device(law, play_deg, play_deg);
                begin(&mut device, task);
                let fault = a_minute(&mut device);
                let is_allowed = match fault {
                    Some(Fault::FollowingError) => law == "robust",
                    Some(fault) => matches!(fault, Fault::Oscillation | Fault::Overheat),
                    None => true,
                };
                assert!(is_allowed, "{law}, {play_deg} deg, {task:?}: {fault:?}");
            }
            let mut device = device(law, 1.0, 0.0);
            begin(&mut device, task);
            unstated += u32::from(a_minute(&mut device) == Some(Fault::Stall));
        }
    }
    assert!(unstated > 8, "{unstated}");
}

/// The joint crosses the play and goes on until the stall, coasting included.
#[test]
fn an_encoder_that_is_dead_behind_play_leads_farther_by_what_the_play_takes_and_stays_bounded() {
    for (play_deg, bound_deg) in [(0.0, 3.0), (0.2, 7.0), (1.0, 20.0), (3.0, 45.0)] {
        let mut furthest = 0.0f64;
        for law in controllers() {
            for to_deg in [0.05, 0.3, 0.41, 0.6, 1.0, 5.0, 40.0] {
                let mut device = device(law, play_deg, play_deg);
                device.wires = Wires::Cut;
                step(&mut device, to_deg);
                let fault = a_minute(&mut device);
                assert!(fault.is_none_or(|fault| fault == Fault::Stall), "{law}: {fault:?}");
                let at_s = (0..5).map(|_| {
                    device.ticks(50);
                    device.position_deg().abs()
                });
                furthest = at_s.fold(furthest, f64::max);
                assert!(furthest < bound_deg, "{law}, {play_deg} deg, {to_deg} deg: {furthest}");
            }
        }
        reliability!("dead-behind-play", play_deg, furthest_deg = format!("{furthest:.1}"));
    }
}
