//! What the matrix needs of a device under test, and the situations that it brings it into.

use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::parameters;
use simulator::device::simulated::{MotorWires, ShuntState};
use simulator::device::wire::Wire;
use simulator::experiment::RunPlan;
use stiction::control::reference::Corner;
use stiction::link::FaultReport;
use stiction::units::position::Position;
use stiction::{Fault, Motion, Tick};

use crate::experiment;

/// Motion of the joint when the fault comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// The joint is on target after a step, under the effort that it rests with.
    Rest,
    /// The joint follows a line of 5 deg/s.
    Moving,
    /// The output is at its full scale, on the way to a far target.
    Saturated,
}

/// All situations, in the order of a row's bounds.
pub const SITUATIONS: [Situation; 3] = [Situation::Rest, Situation::Moving, Situation::Saturated];

/// Outputs of one tick.
#[derive(Clone, Copy, Debug)]
pub struct BenchSample {
    /// Whether the bridge is on.
    pub is_on: bool,
    /// Output code.
    pub code: i16,
}

/// A device under test with a joint, a client, and faults that can be injected.
pub trait Bench {
    /// Wire of the client.
    type Wire: Wire;
    /// Keys of the bench in addition to those of a row.
    const SET: &'static [&'static str];
    /// 1 if the bench reads an input up to one tick after its change, otherwise 0.
    const LATE: u32;

    /// Returns the client.
    fn client(&mut self) -> &mut Client<Self::Wire>;
    /// Runs ticks with a silent client, and returns the last one's outputs.
    fn ticks(&mut self, count: u32) -> BenchSample;
    /// Keeps the client's dead-man alive. Called once a tick with the tick's number.
    fn heard(&mut self, tick: u32);
    /// Returns the signals of the last tick.
    fn last_tick(&mut self) -> Tick;
    /// Changes the encoder's wires.
    fn rewire(&mut self, wires: Wires);
    /// Adds counts of noise within one tick.
    fn jump(&mut self, counts: i32);
    /// Sets the supply, as a fraction of the converter's full scale.
    fn supply(&mut self, of_full_scale: f64);
    /// Sets the friction in addition to that of the joint, V.
    fn brake(&mut self, volts: f64);
    /// Changes the motor's wires and the state of the sensor of its current, if there is one.
    fn motor(&mut self, wires: MotorWires, sensor: ShuntState);
    /// Returns the true position, deg.
    fn position_deg(&mut self) -> f64;
    /// Sets position, deg, and velocity, deg/s, of the joint.
    fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64);
    /// Asserts that the bridge went off in the tick of the detection and has not been on since.
    fn assert_off_since_detection(&mut self, name: &str, law: &str);
    /// Asserts that the fault is kept for the time after a reset, where the bench can reset.
    fn assert_kept(&mut self, name: &str, report: &FaultReport);
    /// Asserts that a reset reports the fault again and drives nothing, where the bench can reset.
    fn assert_kept_across_a_reset(&mut self, name: &str, fault: Fault);
    /// Prints a row's slowest detection and its bound, ticks, for `tests/evidence/reliability.md`.
    fn report(fault: Fault, what: &str, situation: Situation, cases: usize, ticks: [u32; 2]);
}

/// Gains by which a law is [saturated](Situation::Saturated) as the others are on the way to a far
/// target. The profile within `robust` demands a quarter of the full scale otherwise, and the
/// friction: here it is the whole, 5 V of 27 deg/s^2 each.
pub fn harder(law: &str, situation: Situation) -> &'static [&'static str] {
    match (law, situation) {
        ("robust", Situation::Saturated) => &["controller.robust.acceleration_deg_per_s2=135"],
        _ => &[],
    }
}

/// Plans the thesis's loop of 20 ms under a law, with keys set.
pub fn plan<B: Bench>(law: &str, set: &[&str]) -> RunPlan {
    let set = [&["reference.steps_deg=[5.0]"], B::SET, set].concat();
    experiment("step-response", &[law], &set).runs.remove(0)
}

/// Removes every injected fault, puts the joint at zero, at rest, and sends the parameters of a law
/// with keys set.
pub fn start_over<B: Bench>(bench: &mut B, law: &str, set: &[&str]) {
    bench.client().stop().unwrap();
    bench.rewire(Wires::Sound);
    bench.supply(0.5);
    bench.brake(0.0);
    bench.motor(MotorWires::Sound, ShuntState::Sound);
    bench.push(0.0, 0.0);
    bench.client().set_parameters(&parameters(&plan::<B>(law, set)).unwrap()).unwrap();
    bench.ticks(10);
    // Some rows have another encoder, which ends the reference.
    if !bench.client().status().unwrap().is_referenced {
        bench.client().set_reference(0.0).unwrap();
    }
}

/// Runs ticks with a client that is alive.
pub fn pass<B: Bench>(bench: &mut B, ticks: u32) -> BenchSample {
    (0..ticks).for_each(|tick| {
        bench.heard(tick);
        bench.ticks(1);
    });
    bench.ticks(1)
}

/// Brings the joint into a situation, after a first move.
pub fn bring<B: Bench>(bench: &mut B, situation: Situation) {
    bench.client().arm().unwrap();
    bench.client().step_to(1.0).unwrap();
    pass(bench, 100);
    let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
    match situation {
        Situation::Rest => {}
        Situation::Moving => {
            // From 1 deg, 413 counts, to 20 deg further in 4 s.
            let corners = [corner(25, 413), corner(225, 413 + 8_264)].into_iter().collect();
            bench.client().move_along(Motion::Trajectory { corners, half_blend: 0.25 }).unwrap();
            pass(bench, 100);
            let velocity = bench.last_tick().velocity;
            assert!((velocity - 5.0).abs() < 1.5, "{velocity}");
        }
        Situation::Saturated => {
            bench.client().step_to(20.0).unwrap();
            let sample = pass(bench, 4);
            assert_eq!(sample.code.abs(), 1024);
        }
    }
    assert!(bench.ticks(1).is_on, "{situation:?}");
    bench.client().status().unwrap();
}
