//! An ensemble around a machine's own file: its joint with keys that vary, under its controllers.
//!
//! Each key is drawn from a uniform distribution, `KEY=LOW..HIGH`. Only the joint varies: the gains
//! and the limits of the monitors are those of the unchanged file. As in `stiction run --target
//! servo`, the move begins when the servo is armed, so the settling time includes the soft start.
//! The first step and the first trajectory of the file are judged, by the file's `[goal]`, at the
//! encoder and at the load. Positions are in degrees, efforts in volts.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::case_result::CaseResult;
use super::distribution::{Draws, Purpose};
use super::group::Group;
use super::measures::{CaseSample, StepJudge, TrackingJudge};
use dynamics::joint::DiscSide;
use dynamics::solver::AxisSolver;
use files::document::refused_spread;
use files::error::Error;
use files::goal::PositionGoal;
use files::typed_number;
use simulator::closed_loop::LoopSample;
use simulator::experiment::{Document, Experiment, RunPlan, Task, parameters};
use simulator::plant::Winding;
use simulator::target::WatchedServo;

/// Simulated time of a step, s, unless the goal needs more.
const DURATION_S: f64 = 30.0;

/// Largest settling time if the `[goal]` of the file has none, s.
const SETTLES_WITHIN_S: f64 = 5.0;

/// Returns the goal by which the steps of an ensemble around a file are judged: the file's, with a
/// largest settling time of 5 s if it has none.
#[must_use]
pub fn goal_of_steps(goal: PositionGoal) -> PositionGoal {
    PositionGoal { settle_s: goal.settle_s.or(Some(SETTLES_WITHIN_S)), ..goal }
}

/// A key of the file with the range from which it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct KeySpread {
    key: String,
    range: [f64; 2],
}

impl KeySpread {
    /// Reads `KEY=LOW..HIGH`.
    ///
    /// # Errors
    /// Returns an error that states what is allowed.
    pub fn read(text: &str) -> Result<Self, Error> {
        let refuse = |why: &str| Err(Error::Input(format!("--spread {text}: {why}")));
        let Some((key, range)) = text.split_once('=') else {
            return refuse("write KEY=LOW..HIGH, as in joint.friction.stick_v=0.3..0.6");
        };
        let key = key.trim().to_owned();
        if let Some(why) = refused_spread(&key, [0.0; 2]) {
            return refuse(why);
        }
        match typed_number::parse_range(range) {
            Ok(range) => Ok(Self { key, range }),
            Err(why) => refuse(&why),
        }
    }

    fn draw(&self, draws: &mut Draws) -> String {
        let [low, high] = self.range;
        // With all its digits.
        format!("{}={:?}", self.key, draws.uniform(low, high))
    }
}

/// Draws the keys of a joint, as `KEY=VALUE`.
pub fn drawn_keys(spreads: &[KeySpread], seed: u64, number: u64) -> Vec<String> {
    let draws = &mut Draws::new(seed, 0, Purpose::Joint, number);
    spreads.iter().map(|spread| spread.draw(draws)).collect()
}

/// Returns the ranges of the file's own `[spread]`, as `KEY=LOW..HIGH`.
///
/// # Errors
/// Returns an error that states what is wrong with the file.
pub fn written_spreads(document: &Document) -> Result<Vec<String>, Error> {
    let spread = document.machine()?.spread;
    Ok(spread.into_iter().map(|(key, [low, high])| format!("{key}={low:?}..{high:?}")).collect())
}

/// An ensemble around a file.
#[derive(Clone, Debug)]
pub struct MachineEnsemble {
    document: Document,
    /// Group of the rows in reports; it has the name of the file.
    pub group: Group,
    /// Names of the controllers.
    pub laws: Vec<String>,
    /// Names of the file's own controllers. Drawn joints are planned with these only: a law of
    /// another program must not see a drawn joint.
    of_file: Vec<String>,
    spreads: Vec<KeySpread>,
    nominal: Vec<RunPlan>,
    written: Vec<String>,
}

/// Options of an ensemble around a machine's file.
#[derive(Clone, Copy, Debug, Default)]
pub struct MachineOptions<'a> {
    /// Names of the controllers that are run; all if none is named.
    pub controllers: &'a [String],
    /// Names of laws of other programs, which run beside the controllers.
    pub guests: &'a [String],
    /// Keys that vary, `KEY=LOW..HIGH` each.
    pub spreads: &'a [String],
    /// Samples per second instead of the file's, Hz.
    pub rate_hz: Option<f64>,
}

impl MachineEnsemble {
    /// Opens a machine's file, whose `controllers` are run (all of them if none is named).
    ///
    /// # Errors
    /// Returns an error that names what is wrong with the file, or a controller that the file
    /// lacks.
    pub fn open(file: &str, around: MachineOptions<'_>) -> Result<Self, Error> {
        let mut machine = Self::around(file, Document::open(file)?, around, DURATION_S)?;
        machine.written.insert(0, Document::text(file)?);
        Ok(machine)
    }

    /// Creates the ensemble around an open document. Its steps are simulated for `duration_s`, or
    /// longer if the goal needs more.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn around(
        file: &str,
        mut document: Document,
        MachineOptions { controllers, guests, spreads, rate_hz }: MachineOptions<'_>,
        duration_s: f64,
    ) -> Result<Self, Error> {
        if document.is_lab() {
            let why = "is a friction experiment, which positions nothing";
            return Err(Error::Input(format!("--plant {file}: {why}")));
        }
        let goal = goal_of_steps(document.machine()?.goal);
        let settles_within_s = goal.settle_s.unwrap_or(SETTLES_WITHIN_S);
        // Long enough for a goal with a long settling or hold time.
        let duration_s = duration_s.max(3.0 * settles_within_s + goal.hold_s.unwrap_or(0.0));
        let mut written = vec![format!("run.duration_s={duration_s:?}")];
        if let Some(rate_hz) = rate_hz {
            written.push(format!("loop.sample_time_s={:?}", 1.0 / rate_hz));
        }
        document.set(&written)?;
        written.extend(spreads.iter().cloned());
        let controllers = document.add_controllers(controllers, guests)?;
        let nominal = plans(&document, &controllers)?;
        let mut laws: Vec<String> = Vec::new();
        for law in nominal.iter().filter_map(|plan| plan.controller.clone()) {
            if !laws.contains(&law) {
                laws.push(law);
            }
        }
        if !nominal.iter().any(|plan| matches!(plan.task, Task::Step(_))) {
            let why = "has no step; set at least one, since an ensemble judges steps";
            return Err(Error::Input(format!("--plant {file}: `reference.steps_deg` {why}")));
        }
        let spreads = spreads.iter().map(|text| KeySpread::read(text)).collect::<Result<_, _>>()?;
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        let [unit, effort_unit] = ["deg", "V"].map(str::to_owned);
        let group = Group {
            name: stem.into(),
            unit,
            effort_unit,
            settles_within_s,
            is_family: false,
            near: None,
            has_wall: false,
            goal,
            unseen_slack: document.unseen_slack()?,
        };
        let of_file = laws.iter().filter(|law| !guests.contains(law)).cloned().collect();
        Ok(Self { document, group, laws, of_file, spreads, nominal, written })
    }

    /// Returns the samples per second of the file.
    pub fn rate_hz(&self) -> f64 {
        self.nominal.first().map_or(0.0, |plan| 1.0 / plan.machine.sampling.sample_time_s())
    }

    /// Returns the text of the file, and the keys that are set or vary: they distinguish ensembles.
    pub fn written(&self) -> Vec<String> {
        self.written.clone()
    }

    /// Runs all `cases` joints. The rows are in the order of cases, and within a case in that of
    /// controllers.
    ///
    /// # Errors
    /// Returns an error that names a value that no joint can have.
    pub fn run(&self, seed: u64, cases: u64) -> Result<Vec<CaseResult>, Error> {
        let rows = Mutex::new(Vec::new());
        self.run_some(
            [seed, cases],
            |_, _| true,
            |row| {
                rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
                Ok(())
            },
        )?;
        let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        let place = |row: &CaseResult| (row.case, self.laws.iter().position(|law| *law == row.law));
        rows.sort_by_key(place);
        Ok(rows)
    }

    /// Runs the cases for which `wanted` returns true (number of the case, controller), and passes
    /// each row to `take` as soon as it is there, in any order.
    ///
    /// # Errors
    /// Returns the first error of a case or of `take`. Other cases can have been run before it.
    pub fn run_some(
        &self,
        [seed, cases]: [u64; 2],
        wanted: impl Fn(u64, &str) -> bool + Sync,
        take: impl Fn(CaseResult) -> Result<(), Error> + Sync,
    ) -> Result<(), Error> {
        (0..cases).into_par_iter().try_for_each(|number| {
            let laws: Vec<&String> = self.laws.iter().filter(|law| wanted(number, law)).collect();
            if laws.is_empty() {
                return Ok(());
            }
            let mut document = self.document.clone();
            document.draw(&self.drawn(seed, number))?;
            let joints = plans(&document, &self.of_file)?;
            laws.into_iter().try_for_each(|law| take(self.under(law, number, &joints)?))
        })
    }

    /// Draws the keys of a joint.
    pub fn drawn(&self, seed: u64, number: u64) -> Vec<String> {
        drawn_keys(&self.spreads, seed, number)
    }

    fn under(&self, law: &str, number: u64, joints: &[RunPlan]) -> Result<CaseResult, Error> {
        let mut row = CaseResult {
            family: self.group.name.clone(),
            law: law.into(),
            case: number,
            ..CaseResult::default()
        };
        let of_law = |plan: &RunPlan| plan.controller.as_deref() == Some(law);
        // A variant may have another joint, but these are the runs without variants.
        let first = |is: fn(&Task) -> bool| {
            let nominal = self.nominal.iter().find(|plan| of_law(plan) && is(&plan.task))?;
            Some((nominal, joints.iter().find(|plan| is(&plan.task))?))
        };
        if let Some((nominal, joint)) = first(|task| matches!(task, Task::Step(_))) {
            step(&mut row, nominal, joint, &self.group.goal)?;
        }
        if let Some((nominal, joint)) = first(|task| matches!(task, Task::Trajectory(_))) {
            trajectory(&mut row, nominal, joint)?;
        }
        Ok(row)
    }
}

/// Returns the runs of a file, without its variants.
fn plans(document: &Document, controllers: &[String]) -> Result<Vec<RunPlan>, Error> {
    Experiment::without_variants(document, controllers)
}

/// Result of a drive.
struct Driven {
    /// Description of the fault that ended the run; none if no monitor tripped.
    fault: Option<String>,
    /// Side of the gear on which `success` is judged: the load, if the file has a data sheet; the
    /// encoder's side ([`DiscSide::Motor`]), if it has a `[joint]`.
    side: DiscSide,
}

impl Driven {
    /// Returns the value of the judged side.
    fn of<T>(&self, at_encoder: T, at_load: T) -> T {
        match self.side {
            DiscSide::Motor => at_encoder,
            DiscSide::Load => at_load,
        }
    }
}

/// Runs the servo of one plan on the joint of another, up to a fault.
fn drive(pair: [&RunPlan; 2], samples: u32, see: impl FnMut(&CaseSample)) -> Result<Driven, Error> {
    let [nominal, joint] = pair;
    nominal.as_case(|| {
        // The drive of a data sheet's axis has no current.
        if joint.has_current_loop() || joint.has_heat()? {
            let has_sheet = joint.nm_per_v()?.is_some();
            let side = if has_sheet { DiscSide::Load } else { DiscSide::Motor };
            return Ok(Driven {
                fault: drive_with(joint.joint()?, joint.winding()?, pair, samples, see)?,
                side,
            });
        }
        let (fault, side) = match joint.sheet_axis()? {
            Some(axis) => (drive_with(axis, None, pair, samples, see)?, DiscSide::Load),
            None => {
                (drive_with(joint.joint()?, joint.winding()?, pair, samples, see)?, DiscSide::Motor)
            }
        };
        Ok(Driven { fault, side })
    })
}

fn drive_with<S: AxisSolver>(
    solver: S,
    winding: Option<Winding>,
    [nominal, joint]: [&RunPlan; 2],
    samples: u32,
    mut see: impl FnMut(&CaseSample),
) -> Result<Option<String>, Error> {
    let closed_loop = joint.closed_loop()?;
    let h = closed_loop.sample_time_s;
    let mut plant = closed_loop.plant(solver).with_winding(winding);
    let mut servo = WatchedServo::new(parameters(nominal)?, plant.counters(), plant.counts())?;
    let count = closed_loop.encoder.resolution;
    let mut seen: Vec<CaseSample> = Vec::new();
    let on_moment = |moment: &LoopSample| {
        let speed = f64::from(moment.tick.reference_velocity);
        let error = |position_deg: f64| (moment.reference_deg - position_deg) / count;
        seen.push(CaseSample {
            error: error(moment.at_encoder_deg),
            load_error: error(moment.at_load_deg),
            position: moment.position_deg / count,
            speed_ratio: if speed == 0.0 { 0.0 } else { moment.velocity_deg_per_s / speed },
            speed: speed * h / count,
            effort: moment.applied_v,
        });
    };
    closed_loop.step(&mut servo, &mut plant, samples, on_moment, |_| {});
    // Samples after a fault do not count for the law.
    let end = servo.fault.map_or(seen.len(), |(_, tick)| tick as usize);
    seen.iter().take(end).for_each(&mut see);
    Ok(servo.fault.map(|(latched, _)| latched.fault.describe().to_owned()))
}

fn step(
    row: &mut CaseResult,
    nominal: &RunPlan,
    joint: &RunPlan,
    goal: &PositionGoal,
) -> Result<(), Error> {
    let h = joint.machine.sampling.sample_time_s();
    let count = joint.machine.count_deg();
    let mut judge = StepJudge::new(joint.samples()?, f64::INFINITY, h).by(goal, count);
    let mut last = CaseSample::default();
    let driven = drive([nominal, joint], joint.samples()?, |sample| {
        judge.see(sample);
        last = *sample;
    })?;
    let found = judge.measures(&last, 0.0);
    row.step_fault.clone_from(&driven.fault);
    row.count = count;
    row.judge([found.at_encoder, found.at_load], 0.0);
    let judged = driven.of(found.at_encoder, found.at_load);
    row.settled_s = judged.settled_s;
    row.rest_counts = judged.rest_counts;
    row.reversals = found.reversals;
    row.swing_counts = found.swing_counts;
    row.period_s = found.period_s;
    row.variation_rest_per_s = found.variation_per_s;
    row.held_effort = found.held_effort;
    Ok(())
}

fn trajectory(row: &mut CaseResult, nominal: &RunPlan, joint: &RunPlan) -> Result<(), Error> {
    let Task::Trajectory(motion) = &joint.task else { return Ok(()) };
    let h = joint.machine.sampling.sample_time_s();
    let count = joint.machine.count_deg();
    let [first, last] = [motion.corner_times_s.first(), motion.corner_times_s.last()]
        .map(|corner_s| corner_s.copied().unwrap_or(0.0));
    let [from_s, until_s] = [first - motion.half_blend_s, last + motion.half_blend_s];
    let pairs = motion.corner_times_s.windows(2).zip(motion.corner_positions_deg.windows(2));
    let top = pairs.map(|(t, p)| ((p[1] - p[0]) / (t[1] - t[0])).abs()).fold(0.0, f64::max);
    let window = [from_s, until_s].map(|time_s| (time_s / h).round() as u32);
    let mut judge = TrackingJudge::new(window, top * h / count);
    // To the end of the motion, whatever the simulated time of a step.
    let driven = drive([nominal, joint], window[1] + 1, |sample| judge.see(sample))?;
    let found = judge.measures(h);
    let [at_encoder, at_load] =
        [found.rms_counts, found.load_rms_counts].map(|rms| rms.map(|rms| rms * count));
    (row.tracking_at_encoder_rms, row.tracking_at_load_rms) = (at_encoder, at_load);
    row.tracking_rms = driven.of(at_encoder, at_load);
    row.tracking_fault = driven.fault;
    row.sticks_in_motion = found.sticks;
    row.variation_motion_per_s = found.variation_per_s;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_a_key_of_the_joint_and_a_range() {
        let spread = KeySpread::read("joint.friction.stick_v = 0.3 .. 0.6").unwrap();
        assert_eq!((&*spread.key, spread.range), ("joint.friction.stick_v", [0.3, 0.6]));
        let with_commas = KeySpread::read("joint.friction.stick_v=0,3..0,6").unwrap();
        assert_eq!(with_commas, spread);
        for (text, said) in [
            ("joint.friction.stick_v", "write KEY=LOW..HIGH"),
            ("joint.friction.stick_v=0.6..0.3", "the lower end comes first; type 0.3..0.6"),
            ("joint.friction.stick_v=0.3", "`0.3` is not a range"),
            ("joint.friction.stick_v=0,125..0,2", "`0,125` is ambiguous: type 0.125"),
            (
                "controller.pd.kp_v_per_deg=1..2",
                "only keys of [joint], [motor], [gear], [load] and [friction] can vary",
            ),
        ] {
            let message = KeySpread::read(text).unwrap_err().to_string();
            assert!(message.contains(said) && message.contains("--spread"), "{message}");
        }
    }

    #[test]
    fn the_thesis_s_joint_under_its_own_controllers_is_judged_as_it_is_known_to_be() {
        let spreads = ["joint.friction.slip_v=0.30..0.39".to_owned()];
        let laws = ["pd", "srnf"].map(str::to_owned);
        let around =
            MachineOptions { controllers: &laws, spreads: &spreads, ..MachineOptions::default() };
        let ensemble = MachineEnsemble::open("step-response", around).unwrap();
        assert_eq!(ensemble.laws, laws);
        let rows = ensemble.run(1, 3).unwrap();
        assert_eq!(rows, ensemble.run(1, 3).unwrap());
        for row in &rows {
            // Section 3.3.2: PD rests up to 0.4 deg off, which is 165 counts; SRNF within 6.
            let [least, most] = if row.law == "pd" { [2.0, 166.0] } else { [0.0, 6.0] };
            assert!((least..most).contains(&row.rest_counts), "{row:?}");
            assert!(row.step_fault.is_none() && row.tracking_rms.is_none(), "{row:?}");
        }
        let pd: Vec<f64> =
            rows.iter().filter(|row| row.law == "pd").map(|row| row.rest_counts).collect();
        assert!(pd[0] != pd[1] || pd[1] != pd[2], "the friction does not vary: {pd:?}");
        let unknown = MachineOptions { controllers: &["pdd".into()], ..MachineOptions::default() };
        let error = MachineEnsemble::open("step-response", unknown).unwrap_err();
        assert!(error.to_string().contains("pdd"), "{error}");
    }
}
