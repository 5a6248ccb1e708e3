//! Prediction of a move: the simulated twin of the machine in use makes the same move, tick by
//! tick.
//!
//! The twin is the core of the device, with soft start, profile and monitors, around the joint of a
//! file. It is armed, completes its soft start, and makes the move. Guarantee: the same request
//! gives the same numbers. Limits: the twin has only the properties that the joint's file
//! describes.
//! Its law starts anew with each move, so it lacks the state that the device's law has from earlier
//! moves.
//!
//! The twin simulates its load, so a prediction has both sides of the gear: the encoder's, which
//! the device measures, and the load's. The file's `[goal]` judges each. If motor and load have an
//! encoder each, the loop has that of the load, and the prediction has the twist of the gear.

use serde_json::{Value, json};
use stiction::parameters::DeviceConfig;
use stiction::servo::{Boot, Refusal};
use stiction::{Course, Motion, Parameters};

use super::machine_in_use::{MachineInUse, motion};
use super::request::{PredictionRequest, RequestedMotion};
use dynamics::joint::{DiscSide, Train};
use files::error::Error;
use files::goal::PositionGoal;
use simulator::device::moved::longest_s;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::words;
use simulator::experiment::{RunPlan, for_a_device};
use simulator::settling::Settling;

/// Longest predicted move, s, and largest number of its ticks.
const LONGEST: [f64; 2] = [60.0, 100_000.0];

/// Least time for which a joint is watched after its set point rests, s.
const SETTLES_S: f64 = 2.0;

/// Number of further attempts to arm a joint that still moves, 0.1 s apart.
const FALLS: usize = 3;

/// Least time for which a step is watched, s.
const STEP_S: f64 = 5.0;

/// Change of the set point at which it counts as started, counts; the page uses the same value for
/// the measured curve.
const SETS_OUT_COUNTS: f64 = 1e-3;

/// Largest number of points of a curve.
const POINTS: usize = 600;

/// A move of the twin, with a value for each tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PredictedMove {
    /// Time of a tick, s.
    pub tick_s: f64,
    /// Tick in which the set point starts to move.
    pub begin: usize,
    /// theta_d, deg.
    pub reference: Vec<f32>,
    /// theta_a, deg.
    pub position: Vec<f32>,
    /// theta_e, counts.
    pub error: Vec<f32>,
    /// Position of the load, deg; empty if the encoder measures the load.
    pub position_at_load: Vec<f32>,
    /// Reference minus position of the load, counts; empty if the encoder measures the load.
    pub error_at_load: Vec<f32>,
    /// Position at the motor's encoder less that of the load, deg, counted from the start; empty
    /// unless motor and load have an encoder each.
    pub motor_less_load: Vec<f32>,
    /// Effort after the drive's limits, V.
    pub effort: Vec<f32>,
    /// Time from which the encoder's side stays within the goal's tolerance (default: 2 counts), s
    /// after the start of the set point.
    pub settled_s: Option<f64>,
    /// Time from which the load stays within the same tolerance, s after the start of the set
    /// point.
    pub settled_at_load_s: Option<f64>,
    /// Whether the move meets the goal at the encoder, and at the load.
    pub success: [bool; 2],
    /// The fault that ended the move.
    pub fault: Option<&'static str>,
}

impl PredictedMove {
    /// Runs a move on the joint of a plan.
    ///
    /// # Errors
    /// Returns why the device would refuse to arm or to move, or which value is invalid.
    pub fn of(
        parameters: &Parameters,
        joint: &RunPlan,
        way: &RequestedMotion,
    ) -> Result<Self, Error> {
        let refused = |refusal: Refusal| {
            let falls = joint.substitute.is_some() && refusal == Refusal::Moving;
            Error::Refused(if falls {
                "the load moves this joint without effort where the move starts, so the joint \
                 cannot be armed there"
                    .into()
            } else {
                format!("the device would refuse this move: {}", words::refused(&refusal.into()))
            })
        };
        let motion = motion(joint, way)?;
        let course = motion.course(&parameters.controller, &parameters.profile);
        let course = course.map_err(|error| joint.explain(&error))?;
        // A twin with autostart would not wait for the move, and a test at arming would be drawn.
        let device = DeviceConfig { autostart: false, arming_test: 0.0, ..parameters.device };
        let by_hand = Parameters { device, ..parameters.clone() };
        let mut twin = SimulatedDevice::running(joint, &by_hand, Boot::at_zero())?;
        let tick_s = twin.sample_time_s();
        twin.ticks((0.1 / tick_s).ceil() as u32 + 1);
        let mut armed = twin.device.servo().arm_for_link(None);
        for _ in 0..FALLS {
            // A load that falls through the slack of its gear at power-on comes to rest soon.
            if armed != Err(Refusal::Moving) {
                break;
            }
            twin.ticks((0.1 / tick_s).ceil() as u32);
            armed = twin.device.servo().arm_for_link(None);
        }
        armed.map_err(refused)?;
        let device = &parameters.device;
        let waits = device.reset_pulse + device.wake_up + device.soft_start;
        for _ in 0..=parameters.ticks_at_least(waits) {
            twin.device.servo().heard();
            twin.tick();
        }
        match course {
            Course::Follow(reference) => twin.device.servo().follow(reference),
            Course::Profile(profile) => twin.device.servo().go_to(profile),
            // No request is one of these.
            Course::Ramp(_) | Course::Jog(_) | Course::Identification(_) | Course::Winding(_) => {
                Ok(())
            }
        }
        .map_err(refused)?;
        let resolution = f64::from(parameters.controller.encoder.resolution);
        let time_s = time_s(parameters, &joint.machine.goal, way);
        let mut all = Self { tick_s, ..Self::default() };
        let is_two_sided = joint.substitute.as_ref().is_some_and(|joint| {
            joint.side == DiscSide::Motor && matches!(joint.joint.train, Train::Flexible { .. })
        });
        let motor_count_deg = parameters.controller.motor.count().map(f64::from);
        let mut first_twist_deg = None;
        for _ in 0..(time_s / tick_s).min(LONGEST[1]) as u32 {
            twin.device.servo().heard();
            let load_deg = twin.load_deg();
            let tick = twin.tick().tick;
            if let Some(latched) = twin.device.servo().latched() {
                all.fault = Some(latched.fault.describe());
                break;
            }
            let reference = f64::from(tick.reference_counts) + f64::from(tick.reference_fraction);
            all.reference.push((reference * resolution) as f32);
            all.position.push((f64::from(tick.counts) * resolution) as f32);
            all.error.push((f64::from(tick.error) / resolution) as f32);
            all.effort.push(tick.v_applied);
            if let Some(count_deg) = motor_count_deg {
                let twist_deg = f64::from(tick.motor_counts) * count_deg - load_deg;
                let first_deg = *first_twist_deg.get_or_insert(twist_deg);
                all.motor_less_load.push((twist_deg - first_deg) as f32);
            }
            if is_two_sided {
                let ahead_deg = twin.load_ahead_deg();
                let position_deg = f64::from(tick.counts) * resolution + ahead_deg;
                all.position_at_load.push(position_deg as f32);
                let error_deg = f64::from(tick.error) - ahead_deg;
                all.error_at_load.push((error_deg / resolution) as f32);
            }
        }
        // A step jumps in the first tick.
        let least = (SETS_OUT_COUNTS * resolution) as f32;
        let moves = all.reference.iter().position(|deg| deg.abs() > least).unwrap_or(0);
        all.begin = moves;
        let goal = &joint.machine.goal;
        let tolerance_counts = goal.tolerance_counts(resolution);
        let settled_s = |error: &[f32]| {
            let is_off = |error: &f32| f64::from(error.abs()) > tolerance_counts;
            let last = error.iter().rposition(is_off).map_or(0, |last| last + 1);
            let settles = all.fault.is_none() && last < error.len();
            settles.then(|| (last.saturating_sub(moves)) as f64 * tick_s)
        };
        // The set point rests from the tick of its last change on.
        let changes = all.reference.windows(2).rposition(|pair| pair[0] != pair[1]);
        let rests = changes.map_or(moves, |before| before + 1);
        let success = |error: &[f32]| {
            let mut settling = Settling::new(goal, resolution);
            for (tick, counts) in error.iter().enumerate().skip(rests) {
                settling.see(tick as f64 * tick_s, f64::from(*counts));
            }
            all.fault.is_none() && settling.is_success(rests as f64 * tick_s)
        };
        let (encoder, load) = (&all.error[..], all.of_load());
        let settled = [settled_s(encoder), settled_s(load)];
        let success = [success(encoder), success(load)];
        [all.settled_s, all.settled_at_load_s] = settled;
        all.success = success;
        Ok(all)
    }

    /// Returns the errors at the load, counts: those at the encoder if it measures the load.
    fn of_load(&self) -> &[f32] {
        if self.error_at_load.is_empty() { &self.error } else { &self.error_at_load }
    }

    /// Returns the error at the end, counts.
    pub fn rest_counts(&self) -> f64 {
        at_the_end(&self.error)
    }

    /// Returns a key that sorts moves from good to bad: by fault, then by settling time, then by
    /// rest error.
    pub(super) fn badness(&self) -> (f64, f64) {
        let late = self.settled_s.unwrap_or(f64::INFINITY);
        (if self.fault.is_some() { f64::MAX } else { late.min(1e9) }, self.rest_counts())
    }

    pub(super) fn json(&self, points: usize, from: f64) -> Value {
        let thinned = Thinned::of(self.error.len(), points);
        let thin = |all: &[f32], shift: f64| -> Vec<f64> {
            // A pixel shows fewer than six digits.
            let round = |value: f32| ((f64::from(value) + shift) * 1e5).round() / 1e5;
            thinned.values(all).into_iter().map(round).collect()
        };
        let rounded = |counts: f64| (counts * 100.0).round() / 100.0;
        let mut curve = json!({
            "begin_s": -(self.begin as f64) * self.tick_s,
            "tick_s": thinned.ticks() * self.tick_s,
            "reference_deg": thin(&self.reference, from),
            "position_deg": thin(&self.position, from),
            "error_counts": thin(&self.error, 0.0),
            "effort_v": thin(&self.effort, 0.0),
            "settled_s": self.settled_s,
            "rest_counts": rounded(self.rest_counts()),
            "settled_at_encoder_s": self.settled_s,
            "settled_at_load_s": self.settled_at_load_s,
            "rest_at_encoder_counts": rounded(self.rest_counts()),
            "rest_at_load_counts": rounded(at_the_end(self.of_load())),
            "success_at_encoder": self.success[0],
            "success_at_load": self.success[1],
            "fault": self.fault,
        });
        if !self.motor_less_load.is_empty() {
            curve["motor_less_load_deg"] = thin(&self.motor_less_load, 0.0).into();
        }
        if !self.error_at_load.is_empty() {
            curve["position_at_load_deg"] = thin(&self.position_at_load, from).into();
            curve["error_at_load_counts"] = thin(&self.error_at_load, 0.0).into();
        }
        curve
    }
}

/// Returns the size of the last error, counts.
fn at_the_end(error: &[f32]) -> f64 {
    error.last().map_or(0.0, |error| f64::from(error.abs()))
}

/// A thinned curve: the least and the largest value of each piece, in their order, half a piece
/// apart, so that no peak is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Thinned {
    /// Number of values in a piece; 1 leaves the curve as it is.
    piece: usize,
}

impl Thinned {
    /// Returns the thinning of a number of values to at most a number of points.
    fn of(values: usize, points: usize) -> Self {
        let piece = if values <= points { 1 } else { (2 * values).div_ceil(points.max(1)) };
        Self { piece: piece.max(1) }
    }

    /// Returns the number of ticks from a point to the next.
    fn ticks(self) -> f64 {
        if self.piece == 1 { 1.0 } else { self.piece as f64 / 2.0 }
    }

    fn values(self, all: &[f32]) -> Vec<f32> {
        if self.piece == 1 {
            return all.to_vec();
        }
        let ends = |piece: &[f32]| {
            let numbered = || piece.iter().copied().enumerate();
            let by_value = |a: &(usize, f32), b: &(usize, f32)| a.1.total_cmp(&b.1);
            let low = numbered().min_by(by_value).unwrap_or_default();
            let high = numbered().max_by(by_value).unwrap_or_default();
            if low.0 <= high.0 { [low.1, high.1] } else { [high.1, low.1] }
        };
        all.chunks(self.piece).flat_map(ends).collect()
    }
}

/// Returns the time for which a move is simulated and watched, s.
fn time_s(parameters: &Parameters, goal: &PositionGoal, way: &RequestedMotion) -> f64 {
    let time_s = match way {
        RequestedMotion::Move(deg) => {
            longest_s(&parameters.profile, *deg) + goal.watched_s(SETTLES_S)
        }
        RequestedMotion::Step(_) => goal.watched_s(STEP_S),
        RequestedMotion::Trajectory(motion) => {
            let last_s = motion.corner_times_s.last().copied().unwrap_or(0.0);
            last_s + motion.half_blend_s + goal.watched_s(SETTLES_S)
        }
    };
    time_s.clamp(0.0, LONGEST[0])
}

/// Returns the keys that a request sets, `table.key=value` each: those of `law`, or, without a law,
/// those of the joint.
pub(super) fn set(
    machine: &MachineInUse,
    wish: &PredictionRequest,
    law: Option<&str>,
) -> Vec<String> {
    let own = |path: &str| match law {
        Some(law) => path
            .strip_prefix("controller.")
            .is_some_and(|rest| rest.split_once('.').is_some_and(|(name, _)| name == law)),
        None => !path.starts_with("controller."),
    };
    let written = |(path, value): (&String, &f64)| match path.as_str() {
        super::knobs::INERTIA => {
            let gain = machine.document.get(super::knobs::GAIN).and_then(toml::Value::as_float);
            format!("{}={:?}", super::knobs::GAIN, gain.unwrap_or_default() / value)
        }
        super::knobs::DELAY => format!("{path}={}", *value as i64),
        _ => format!("{path}={value:?}"),
    };
    wish.values.iter().filter(|(path, _)| own(path)).map(written).collect()
}

/// Predicts the move under each requested law.
pub fn laws(machine: &MachineInUse, wish: &PredictionRequest) -> Value {
    let joint = set(machine, wish, None);
    let under = |law: &String| -> Result<Value, Error> {
        let mut all = joint.clone();
        all.extend(set(machine, wish, Some(law)));
        let plan = machine.plan_from(wish.from_deg, law, &all)?;
        Ok(PredictedMove::of(&for_a_device(&plan)?, &plan, &wish.way)?.json(POINTS, wish.from_deg))
    };
    let curves = wish.laws.iter().map(|law| {
        let mut curve = under(law).unwrap_or_else(|error| json!({ "refused": error.to_string() }));
        curve["law"] = law.as_str().into();
        curve
    });
    curves.collect()
}

/// Returns the motion of a request, to check that the machine can make it.
///
/// # Errors
/// Returns an error that names an invalid position or time.
pub fn check(machine: &MachineInUse, way: &RequestedMotion) -> Result<Motion, Error> {
    machine.motion(way)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use simulator::draft::{Typical, text};
    use simulator::experiment::{Document, Experiment, Task};
    use simulator::run::{RunTrace, run};

    use super::*;

    /// A harmonic gear with slack between an encoder on the motor and a coarser one on the load.
    fn with_two_encoders() -> Document {
        let typical = Typical::find("harmonic").unwrap();
        let written = text("two.toml", &typical.answers().unwrap(), Some(&typical)).unwrap();
        let mut document = Document::parse("two.toml", &written).unwrap();
        let keys = [
            "gear.stiffness_nm_per_rad=4000",
            "gear.backlash_deg=0.15",
            "load_encoder.counts_per_turn=16384",
        ];
        document.set(&keys.map(str::to_owned)).unwrap();
        document
    }

    /// `stiction run` has no soft start: its loop is at rest when the step comes, as the twin is.
    #[test]
    fn a_step_of_a_joint_with_two_encoders_is_that_of_a_run_of_its_file_at_motor_and_load() {
        let file = with_two_encoders();
        for law in ["pd", "robust"] {
            let mut runs = Experiment::plan(&file, &[law.to_owned()], &[]).unwrap().runs;
            let place = runs.iter().position(|run| run.task == Task::Step(5.0)).unwrap();
            let plan = runs.swap_remove(place);
            let result = run(&plan).unwrap();
            let RunTrace::Loop(samples) = &result.trace else { unreachable!() };
            let parameters = for_a_device(&plan).unwrap();
            let machine = MachineInUse::new(&parameters, &file).unwrap();
            let twin = machine.plan(law, &[]).unwrap();
            let way = RequestedMotion::Step(5.0);
            let found = PredictedMove::of(&for_a_device(&twin).unwrap(), &twin, &way).unwrap();
            let sides = &result.metrics.sides;
            assert_eq!(found.settled_at_load_s, sides.settled_at_load_s, "{law}");
            assert_eq!(found.success.map(Some), [sides.success_at_load; 2], "{law}");
            assert_eq!(sides.success_at_load, Some(law == "robust"));
            let load_count_deg = 360.0 / 16384.0;
            let mut widest_deg = 0.0f64;
            for (sample, place) in samples.iter().zip(found.begin..found.error.len()) {
                let motor_deg = f64::from(sample.motor_counts.unwrap()) * 360.0 / 100_000.0;
                let twist_deg = motor_deg - sample.at_load_deg;
                widest_deg = widest_deg.max(twist_deg.abs());
                let off_deg = f64::from(found.motor_less_load[place]) - twist_deg;
                assert!(off_deg.abs() < 1e-6, "{law}, tick {place}: {off_deg} deg");
                let off_deg = f64::from(found.position[place]) - sample.at_load_deg;
                assert!(off_deg.abs() < 0.51 * load_count_deg, "{law}, tick {place}: {off_deg}");
            }
            // The gear has 0.15 deg of slack, and winds up on the way.
            assert!(widest_deg > 0.2, "{law}: {widest_deg} deg");
        }
    }

    #[test]
    fn a_peak_of_one_tick_is_not_lost_and_keeps_its_place() {
        for (values, points) in [(600, 600), (601, 600), (5000, 600), (12_345, 240)] {
            let mut all = vec![0.0; values];
            (all[values / 3], all[values / 2]) = (7.0, -5.0);
            let thinned = Thinned::of(values, points);
            let few = thinned.values(&all);
            assert!(few.len() <= points + 2 && few.len() >= points / 2, "{}", few.len());
            for (peak, at) in [(7.0, values / 3), (-5.0, values / 2)] {
                let found = few.iter().position(|value| *value == peak);
                let tick = found.map_or(f64::INFINITY, |place| place as f64 * thinned.ticks());
                assert!((tick - at as f64).abs() <= thinned.piece as f64, "{values}: {tick}");
            }
        }
        // Of few values none is left out.
        assert_eq!(Thinned::of(3, 3).values(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
