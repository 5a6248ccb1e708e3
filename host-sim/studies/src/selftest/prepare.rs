//! Prepares a self-test before anything moves: checks that the device is the machine of the file,
//! chooses the range of the moves, and predicts them.

use stiction::Parameters;
use stiction::link::Status;

use super::measures::SessionFigures;
use super::moves::{MoveRange, ROOM, longest_way, room, targets};
use super::prediction::{Prediction, PredictionInput};
use super::session::{LONGEST_S, SelfTestSession, time_s};
use super::text::SelfTestResult;
use super::verdict::{SelfTestCheck, bounds, verdict};
use crate::tuning::spreads;
use files::data_sheet::UnseenSlack;
use files::error::{Error, rounded};
use files::goal::PositionGoal;
use simulator::device::client::Client;
use simulator::device::wire::Wire;
use simulator::device::{machine_file, parameters, words};
use simulator::experiment::{Document, Experiment, RunPlan};

/// Keys in which device and file must agree; otherwise they are different machines.
const OF_THE_MACHINE: [&str; 4] = ["encoder.", "motor_encoder.", "drive.", "loop.sample_time_s"];

/// Default number of moves.
pub const MOVES: usize = 20;

/// Default number of joints in the prediction.
pub const JOINTS: u64 = 24;

/// Default seed: the first year of the project, as for ensembles. No joint was tuned on it.
pub const SEED: u64 = 2026;

/// Options of a self-test.
#[derive(Clone, Debug)]
pub struct SelfTestRequest {
    /// Name of the machine's file.
    pub machine: String,
    /// Range of the moves to either side, deg; `None`: the default.
    pub range_deg: Option<f64>,
    /// Number of moves.
    pub moves: usize,
    /// Number of simulated joints.
    pub joints: u64,
    /// Seed of the joints.
    pub seed: u64,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`; if empty, those of the file.
    pub spreads: Vec<String>,
}

/// Goal of a move, and slack of the gear, from the file.
#[derive(Clone, Copy, Debug)]
struct Judge {
    goal: PositionGoal,
    slack: Option<UnseenSlack>,
}

/// A self-test before its prediction.
#[derive(Clone, Debug)]
pub struct PlannedSelfTest {
    /// Input of the prediction.
    pub request: PredictionInput,
    machine: String,
    range: MoveRange,
    doubts: Vec<String>,
    differences: Vec<String>,
    judge: Judge,
}

/// A self-test with its prediction, before the moves.
#[derive(Clone, Debug)]
pub struct PreparedSelfTest {
    /// Input of the prediction.
    pub request: PredictionInput,
    machine: String,
    range: MoveRange,
    prediction: Prediction,
    doubts: Vec<String>,
    differences: Vec<String>,
    judge: Judge,
}

impl SelfTestRequest {
    /// Reads the parameters of a device, and predicts its moves.
    ///
    /// # Errors
    /// Returns an error about the file, the range or the device, or that most of the simulated
    /// joints end early.
    pub fn prepare<W: Wire>(&self, client: &mut Client<W>) -> Result<PreparedSelfTest, Error> {
        self.plan(client)?.predict()
    }

    /// Reads the parameters of a device, and plans the moves.
    ///
    /// # Errors
    /// Returns an error about the file, the range or the device.
    pub fn plan<W: Wire>(&self, client: &mut Client<W>) -> Result<PlannedSelfTest, Error> {
        self.plan_of(client, Document::open(&self.machine)?)
    }

    /// Plans the moves with the joint of a document that is not a file; `machine` is its name.
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn plan_of<W: Wire>(
        &self,
        client: &mut Client<W>,
        document: Document,
    ) -> Result<PlannedSelfTest, Error> {
        let parameters = client.parameters()?;
        let doubts = document.doubts()?;
        let differences = differences(&self.machine, &document, &parameters)?;
        let judge = Judge { goal: document.machine()?.goal, slack: document.unseen_slack()? };
        let range = self.range(client, (&parameters, &judge.goal))?;
        let spreads =
            if self.spreads.is_empty() { spreads(&document)? } else { self.spreads.clone() };
        let request = PredictionInput {
            document,
            parameters,
            spreads,
            joints: self.joints,
            seed: self.seed,
            targets: targets(range, self.moves),
        };
        let machine = self.machine.clone();
        Ok(PlannedSelfTest { request, machine, range, doubts, differences, judge })
    }

    /// Returns the requested range, or the default.
    fn range<W: Wire>(
        &self,
        client: &mut Client<W>,
        found: (&Parameters, &PositionGoal),
    ) -> Result<MoveRange, Error> {
        let status = client.status()?;
        allowed(self.range_deg, found, at_deg(&status), self.moves)
    }
}

fn at_deg(status: &Status) -> f64 {
    f64::from(status.position) * f64::from(status.resolution)
}

impl PlannedSelfTest {
    /// Predicts the moves, on all cores. It needs no device.
    ///
    /// # Errors
    /// Returns an error that names a key that cannot vary, or that most of the simulated joints end
    /// early.
    pub fn predict(self) -> Result<PreparedSelfTest, Error> {
        let cancelled = || Error::Input("selftest: the prediction was cancelled".into());
        self.predict_while(&|_| true)?.ok_or_else(cancelled)
    }

    /// Predicts the moves, on all cores. `goes_on` is called with the number of completed joints;
    /// if it returns false, the result is `None`.
    ///
    /// # Errors
    /// As [`predict`](Self::predict).
    pub fn predict_while(
        self,
        goes_on: &(dyn Fn(u64) -> bool + Sync),
    ) -> Result<Option<PreparedSelfTest>, Error> {
        let Self { request, machine, range, doubts, differences, judge } = self;
        let Some(prediction) = request.predict_while(goes_on)? else { return Ok(None) };
        if prediction.figures.len() < prediction.ended.len().max(1) {
            let why = prediction.ended.first().map_or("", String::as_str);
            return Err(Error::Refused(format!(
                "selftest: nothing was moved: {1} of {0} simulated joints end early, the first by \
                 {why}; use a smaller range, or other gains",
                request.joints,
                prediction.ended.len()
            )));
        }
        Ok(Some(PreparedSelfTest {
            request,
            machine,
            range,
            prediction,
            doubts,
            differences,
            judge,
        }))
    }
}

impl PreparedSelfTest {
    /// Checks that the prediction still fits the device: its parameters can have changed, or the
    /// joint can have been turned by hand. Returns the status of the device.
    ///
    /// # Errors
    /// Returns an error about the change or the device.
    pub fn fits<W: Wire>(&self, client: &mut Client<W>) -> Result<Status, Error> {
        let found = client.parameters()?;
        if found != self.request.parameters {
            let why = "selftest: the device runs other parameters than those of the prediction; \
                       predict anew";
            return Err(Error::Refused(why.into()));
        }
        let status = client.status()?;
        allowed(
            Some(self.range.deg),
            (&found, &self.judge.goal),
            at_deg(&status),
            self.request.targets.len(),
        )?;
        Ok(status)
    }

    /// Returns the name of the machine's file.
    pub fn machine(&self) -> &str {
        &self.machine
    }

    /// Returns the farthest target to either side, deg.
    pub const fn range_deg(&self) -> f64 {
        self.range.deg
    }

    /// Returns the doubts about the joint of the file, one sentence each.
    pub fn doubts(&self) -> &[String] {
        &self.doubts
    }

    /// Returns the differences between device and file.
    pub fn differences(&self) -> &[String] {
        &self.differences
    }

    /// Returns the goal by which each move is judged.
    pub const fn goal(&self) -> PositionGoal {
        self.judge.goal
    }

    /// Returns the slack of the gear that the encoder cannot measure.
    pub const fn unseen_slack(&self) -> Option<UnseenSlack> {
        self.judge.slack
    }

    /// Returns a sentence with the prediction on both sides of the gear; `None` if the encoder
    /// measures the load.
    pub fn predicted_sides(&self) -> Option<String> {
        self.judge.slack?;
        let [at_encoder, at_load] = self.prediction.missed_of_most();
        let moves = self.request.targets.len();
        Some(format!(
            "Predicted of {moves} moves on the median joint: {} miss the goal at the encoder, {} at \
             the load.",
            at_encoder.unwrap_or(0),
            at_load.unwrap_or(0)
        ))
    }

    /// Returns the largest total time of all moves, s.
    pub fn longest_s(&self) -> f64 {
        let targets = &self.request.targets;
        let from = std::iter::once(&0.0).chain(targets);
        let profile = &self.request.parameters.profile;
        from.zip(targets).map(|(from, to)| time_s(profile, &self.judge.goal, to - from)).sum()
    }

    /// Returns the figures with their bounds.
    pub fn bounds(&self) -> Vec<SelfTestCheck> {
        bounds(&self.prediction)
    }

    /// Returns the verdict on the session of a device.
    pub fn judged(self, session: SelfTestSession) -> SelfTestResult {
        let SelfTestSession { moves, status, is_ended, refused } = session;
        let by = || match (status.fault.code, refused) {
            (0, None) => "a stop".into(),
            (0, Some(why)) => why,
            _ => words::fault(&status.fault, status.sample_time),
        };
        let checks =
            if is_ended { vec![] } else { verdict(&SessionFigures::of(&moves), &self.prediction) };
        SelfTestResult {
            machine: self.machine,
            range_deg: self.range.deg,
            spreads: self.request.spreads,
            seed: self.request.seed,
            prediction: self.prediction,
            moves,
            checks,
            ended_by: is_ended.then(by),
            doubts: self.doubts,
            differences: self.differences,
            goal: self.judge.goal,
            unseen_slack: self.judge.slack,
            count_deg: self.range.count_deg,
        }
    }
}

/// Returns the range of `moves` moves of a joint at `at_deg`: the requested range, or the default.
fn allowed(
    asked_deg: Option<f64>,
    (found, goal): (&Parameters, &PositionGoal),
    at_deg: f64,
    moves: usize,
) -> Result<MoveRange, Error> {
    const LIMITS: &str = "`limits.position_min_deg`, `limits.position_max_deg`";
    let derived = MoveRange::derived(found, at_deg);
    let (least, room) = (derived.least_deg(), room(found, at_deg));
    if ROOM * room < least {
        return Err(Error::Input(format!(
            "selftest: the joint is {} deg from a position limit ({LIMITS}), but the moves go to \
             either side; move it to at least {} deg from both limits",
            rounded(room),
            rounded(least / ROOM),
        )));
    }
    let deg = asked_deg.unwrap_or(derived.deg);
    let refuse = |why: String| {
        let what = match asked_deg {
            Some(_) => format!("selftest: a range of {deg} deg"),
            None => format!("selftest: the default range is {} deg", rounded(deg)),
        };
        Err(Error::Input(format!("{what}: {why}")))
    };
    if !deg.is_finite() || deg < least {
        return refuse(match asked_deg {
            Some(_) => {
                format!("it must be at least {} deg, ten times the shortest move", rounded(least))
            }
            None => format!(
                "that is the distance within 1 s by `profile.velocity_deg_per_s` and \
                 `profile.acceleration_deg_per_s2`, but less than ten times the shortest move; set \
                 a range of {} deg or more",
                rounded(least)
            ),
        });
    }
    if deg > ROOM * room {
        return refuse(format!(
            "the joint is {} deg from a position limit ({LIMITS}), and the range must be at most \
             {} of that: {} deg",
            rounded(room),
            rounded(ROOM),
            rounded(ROOM * room),
        ));
    }
    let range = |deg: f64| MoveRange { deg, ..derived };
    let time_s = |deg: f64| time_s(&found.profile, goal, longest_way(&targets(range(deg), moves)));
    if time_s(deg) > LONGEST_S {
        let fits = largest(least, deg, |deg| time_s(deg) <= LONGEST_S);
        return refuse(format!(
            "its longest move takes up to {} s within [profile], but each move of a self-test has \
             at most {LONGEST_S} s; {}",
            rounded(time_s(deg).ceil()),
            match fits {
                Some(deg) => format!("a range up to {} deg fits", rounded(deg)),
                None => "even the smallest range takes too long: raise \
                         `profile.velocity_deg_per_s` or `profile.acceleration_deg_per_s2`"
                    .into(),
            }
        ));
    }
    Ok(range(deg))
}

/// Returns the largest number from `low` to `high` for which `holds` is true, rounded down to three
/// digits; `None` if it is false for `low`.
fn largest(low: f64, high: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    if !holds(low) {
        return None;
    }
    let (mut low, mut high) = (low, high);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    let unit = 10f64.powf(low.log10().floor() - 2.0);
    let down = (low / unit).floor() * unit;
    Some(if holds(down) { down } else { low })
}

/// Returns the differences between the device's parameters and those of the file's most similar
/// controller.
fn differences(
    machine: &str,
    document: &Document,
    found: &Parameters,
) -> Result<Vec<String>, Error> {
    let runs = Experiment::without_variants(document, &[])?;
    let compared = |plan: &RunPlan| -> Result<Vec<String>, Error> {
        let mut lines = machine_file::changes(&parameters(plan)?, found)?;
        // A session depends neither on autostart nor on the reference of the file, and a bridge
        // with another frequency moves the joint as well.
        let is_asked = |line: &String| {
            !["reference", "identification", "device.autostart", "drive.pwm_hz"]
                .iter()
                .any(|no| line.starts_with(no))
        };
        lines.retain(is_asked);
        Ok(lines)
    };
    let nearest = runs.iter().filter_map(|plan| compared(plan).ok()).min_by_key(Vec::len);
    let lines = nearest.ok_or_else(|| {
        Error::Input(format!("{machine}: no controller of the file can run on a device"))
    })?;
    let other = lines.iter().find(|line| OF_THE_MACHINE.iter().any(|key| line.starts_with(key)));
    other.map_or(Ok(lines.clone()), |line| {
        Err(Error::Refused(format!(
            "selftest: the device is another machine than {machine} ({line}); push that file, or \
             use the device's file"
        )))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(velocity: f32, position: [f32; 2]) -> Parameters {
        let document = Document::open("step-response").unwrap();
        let plan = Experiment::without_variants(&document, &["srnf".into()]).unwrap().remove(0);
        let mut found = parameters(&plan).unwrap();
        found.profile.velocity = velocity;
        [found.limits.position_min, found.limits.position_max] = position;
        found
    }

    fn judged_by_default(
        asked_deg: Option<f64>,
        found: &Parameters,
        at_deg: f64,
        moves: usize,
    ) -> Result<MoveRange, Error> {
        allowed(asked_deg, (found, &PositionGoal::default()), at_deg, moves)
    }

    fn said(range: Result<MoveRange, Error>) -> String {
        range.unwrap_err().to_string()
    }

    #[test]
    fn a_range_whose_longest_move_takes_too_long_is_refused_and_one_that_fits_is_named() {
        let slow = found(2.0, [0.0; 2]);
        let why = said(judged_by_default(Some(800.0), &slow, 0.0, 20));
        assert!(why.contains("selftest: a range of 800 deg") && why.contains("60 s"), "{why}");
        let fits: f64 =
            why.split("up to ").last().unwrap().split(' ').next().unwrap().parse().unwrap();
        assert_eq!(judged_by_default(Some(fits), &slow, 0.0, 20).unwrap().deg, fits);
        // Some 46 s at 2 deg/s in five fourths of it, over a little more than the range.
        assert!((45.0..93.0).contains(&fits), "{fits}");
        assert!(
            said(judged_by_default(Some(1.03 * fits), &slow, 0.0, 20)).contains("takes up to 6")
        );
        assert!(judged_by_default(Some(800.0), &found(200.0, [0.0; 2]), 0.0, 20).is_ok());
        // A goal with a hold time needs longer moves: one that just fits without it does not.
        let hold = PositionGoal { hold_s: Some(5.0), ..PositionGoal::default() };
        assert!(said(allowed(Some(fits), (&slow, &hold), 0.0, 20)).contains("60 s"));
    }

    #[test]
    fn a_near_position_limit_is_named_and_a_given_range_must_leave_room() {
        let bounded = found(20.0, [-5.0, 5.0]);
        // No option was given, so the message names none.
        let why = said(judged_by_default(None, &bounded, 4.99, 20));
        assert!(
            why.contains("0.01 deg from a position limit") && !why.contains("a range of"),
            "{why}"
        );
        let count_deg = MoveRange::derived(&bounded, 0.0).count_deg;
        let least = format!("at least {} deg from both", rounded(40.0 * count_deg / 0.9));
        assert!(why.contains(&least), "{why}: {least}");
        assert_eq!(judged_by_default(Some(4.5), &bounded, 0.0, 20).unwrap().deg, 4.5);
        let why = said(judged_by_default(Some(4.6), &bounded, 0.0, 20));
        assert!(why.contains("range of 4.6") && why.contains(": 4.5 deg"), "{why}");
    }
}
