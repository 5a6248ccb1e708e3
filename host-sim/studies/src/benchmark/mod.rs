//! Benchmark of controllers on the joint of a file, as one table: the thesis's control benchmark
//! (section 3.3.1).
//!
//! Every controller runs the same steps and trajectories, and is judged by its worst run. Steps run
//! twice: with the duration of the file, and for 120 s. Hunting is slow: a controller that seems to
//! rest after 10 s can be waiting for its integral.

mod ranking;

use serde::Serialize;

pub use self::ranking::{COLUMNS, Disqualification, Weights};
use files::data_sheet::UnseenSlack;
use files::error::Error;
use files::goal::PositionGoal;
use simulator::both_sides::BothSides;
use simulator::experiment::{Document, Experiment, RunPlan, Task};
use simulator::progress::Progress;
use simulator::run::{RunDriver, RunResult, RunTrace, run_all_driven};

/// Setting of the steps that are watched for hunting: a duration of 120 s.
const HUNTING_DURATION: &str = "run.duration_s=120";

/// Row of a controller. A value is `None` if no run has it; a settling time also if a step never
/// settles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Name of the controller.
    pub controller: String,
    /// Largest rest error of a step, counts.
    pub rest_error_counts: Option<f64>,
    /// Largest overshoot of a step, deg.
    pub overshoot_deg: Option<f64>,
    /// Longest settling time of a step, s; `None` if a step never settles.
    pub settling_time_s: Option<f64>,
    /// Largest rms error of a trajectory, deg.
    pub tracking_rms_deg: Option<f64>,
    /// Largest total variation of the drive's output in steps and trajectories, V/s.
    pub chatter_v_per_s: Option<f64>,
    /// Largest peak-to-peak amplitude of hunting in the steps of 120 s, counts; 0 if none hunts.
    pub hunting_counts: Option<f64>,
    /// Largest number of stops of the joint in a trajectory, while the set point moves at more than
    /// half of its top speed: stair-like motion.
    pub sticks_in_motion: Option<f64>,
    /// Worst rest, settling and success of the steps on both sides of the gear, by the file's goal.
    #[serde(flatten)]
    pub sides: BothSides,
    /// Longest settling time of a step at the encoder, s. If the encoder cannot see slack, this
    /// time is ranked instead of `settling_time_s`.
    #[serde(skip)]
    pub settling_time_at_encoder_s: Option<f64>,
    /// Whether the gear has slack that the encoder cannot see. No law corrects this slack, so rest
    /// and settling are ranked at the encoder.
    #[serde(skip)]
    pub is_ranked_at_encoder: bool,
    /// Whether a run of the controller is unstable or diverged.
    pub unstable: bool,
    /// Reason why the controller is not ranked, if any; its other values then mean little.
    pub disqualified: Option<Disqualification>,
    /// Weighted mean of the controller's places in the columns: 1 if it is the best in each; `None`
    /// if it is disqualified.
    pub mean_place: Option<f64>,
}

/// Table of a benchmark, best controller first, and its runs without those of 120 s.
#[derive(Clone, Debug)]
pub struct Benchmark {
    /// One row for each controller.
    pub scores: Vec<Score>,
    /// Results of the runs, a list for each input file.
    pub results: Vec<Vec<RunResult>>,
    /// Slack of the gear that the encoder cannot measure.
    pub unseen_slack: Option<UnseenSlack>,
    /// Goal of the first document.
    pub goal: PositionGoal,
}

/// Runs the benchmark on documents with the same controllers. Runs of a variant or with a delay are
/// left out.
///
/// # Errors
/// Returns an error with the file and the invalid key, or the error of `progress`.
pub fn benchmark(
    documents: &[Document],
    weights: &Weights,
    progress: &impl Progress,
) -> Result<Benchmark, Error> {
    let run_all = |plans: &[RunPlan]| run_all_driven(plans, RunDriver::ByLoop, progress);
    let mut results = Vec::new();
    let mut watched = Vec::new();
    for document in documents {
        results.push(run_all(&plain_runs(document)?)?);
        let mut document = document.clone();
        document.set(&[HUNTING_DURATION.into()])?;
        let mut steps = plain_runs(&document)?;
        steps.retain(|plan| matches!(plan.task, Task::Step(_)));
        watched.extend(run_all(&steps)?);
    }
    let all: Vec<&RunResult> = results.iter().flatten().collect();
    let mut controllers: Vec<String> = Vec::new();
    for name in all.iter().filter_map(|result| result.plan.controller.as_ref()) {
        if !controllers.contains(name) {
            controllers.push(name.clone());
        }
    }
    let mut scores: Vec<Score> =
        controllers.iter().map(|name| score(name, &all, &watched)).collect();
    ranking::rank(&mut scores, weights);
    let unseen_slack = all.iter().find_map(|result| result.unseen_slack);
    let goal = all.first().map(|result| result.plan.machine.goal).unwrap_or_default();
    Ok(Benchmark { scores, results, unseen_slack, goal })
}

/// Returns the runs of a document that the benchmark judges: those of every controller, without
/// variant and delay.
///
/// # Errors
/// Returns an error about the document.
pub fn plain_runs(document: &Document) -> Result<Vec<RunPlan>, Error> {
    let mut plans = Experiment::plan(document, &[], &[])?.runs;
    plans.retain(RunPlan::is_plain);
    Ok(plans)
}

fn score(controller: &str, results: &[&RunResult], watched: &[RunResult]) -> Score {
    let of = |result: &&RunResult| result.plan.controller.as_deref() == Some(controller);
    let is_step = |result: &&RunResult| matches!(result.plan.task, Task::Step(_));
    let steps: Vec<_> = results.iter().copied().filter(of).filter(is_step).collect();
    let trajectories: Vec<_> =
        results.iter().copied().filter(of).filter(|result| !is_step(result)).collect();
    let watched: Vec<_> = watched.iter().filter(of).collect();
    let largest = |values: &mut dyn Iterator<Item = Option<f64>>| values.flatten().reduce(f64::max);
    let is_ranked_at_encoder = steps.iter().any(|result| result.unseen_slack.is_some());
    let settles = steps.iter().all(|result| settles(result));
    let slowest = |of: fn(&RunResult) -> Option<f64>| {
        let is_settled = steps.iter().all(|result| of(result).is_some());
        largest(&mut steps.iter().map(|result| of(result))).filter(|_| is_settled)
    };
    let sides = steps.iter().map(|result| result.metrics.sides);
    let runs = || steps.iter().chain(&trajectories);
    let unstable = runs().copied().chain(watched.iter().copied()).any(|result| result.unstable);
    let disqualified = if unstable {
        Some(Disqualification::Unstable)
    } else if !runs().any(|result| moves(result)) {
        Some(Disqualification::NeverMoves)
    } else {
        Some(Disqualification::NeverSettles).filter(|_| !settles)
    };
    Score {
        controller: controller.into(),
        rest_error_counts: largest(
            &mut steps.iter().map(|r| r.metrics.rest_error_counts.map(f64::abs)),
        ),
        overshoot_deg: largest(&mut steps.iter().map(|r| r.metrics.overshoot_deg)),
        settling_time_s: slowest(|r| r.metrics.settling_time_s),
        tracking_rms_deg: largest(&mut trajectories.iter().map(|r| r.metrics.rms_error_deg)),
        chatter_v_per_s: largest(&mut runs().map(|r| r.metrics.control_total_variation_v_per_s)),
        hunting_counts: largest(&mut watched.iter().map(|r| {
            let resolution_deg = r.plan.machine.count_deg();
            Some(r.metrics.hunting_peak_to_peak_deg.unwrap_or(0.0) / resolution_deg)
        })),
        sticks_in_motion: largest(
            &mut trajectories.iter().map(|r| r.metrics.sticks_in_motion.map(f64::from)),
        ),
        sides: sides.reduce(|one, other| one.worst(other)).unwrap_or_default().magnitude(),
        settling_time_at_encoder_s: slowest(|r| r.metrics.settling_time_at_encoder_s),
        is_ranked_at_encoder,
        unstable,
        disqualified,
        mean_place: None,
    }
}

/// Returns whether a step settles. If the file has a goal, the step must meet it at the encoder.
/// Otherwise the joint must stay within 0.05 deg of its target; the encoder's side, if the encoder
/// cannot see slack.
fn settles(result: &RunResult) -> bool {
    let metrics = &result.metrics;
    if !result.plan.machine.goal.is_default() {
        return metrics.sides.success_at_encoder == Some(true);
    }
    let settled_s = match result.unseen_slack {
        Some(_) => metrics.settling_time_at_encoder_s,
        None => metrics.settling_time_s,
    };
    settled_s.is_some()
}

/// Returns whether the joint moved by more than a count from its first position.
fn moves(result: &RunResult) -> bool {
    let RunTrace::Loop(moments) = &result.trace else { return false };
    let count_deg = result.plan.machine.count_deg();
    let Some(first) = moments.first() else { return false };
    moments.iter().any(|moment| (moment.position_deg - first.position_deg).abs() > count_deg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::solver::{Event, EventKind};
    use simulator::progress::Silent;

    #[test]
    fn variants_and_runs_with_a_delay_are_left_out() {
        let benchmark =
            benchmark(&[Document::open("high-gain").unwrap()], &Weights::default(), &Silent)
                .unwrap();
        let labels = benchmark.results.iter().flatten().map(|result| result.plan.label.as_str());
        assert_eq!(labels.filter(|label| label.contains("delay-1")).count(), 0);
        assert_eq!(benchmark.scores.len(), 5);
    }

    #[test]
    fn srnf_is_ahead_of_pd_on_the_thesis_s_robot_and_every_row_is_the_worst_of_its_runs() {
        let documents = ["step-response", "trajectory"].map(|name| Document::open(name).unwrap());
        let benchmark = benchmark(&documents, &Weights::default(), &Silent).unwrap();
        assert_eq!(benchmark.results.iter().flatten().count(), 7 * 5);
        assert_eq!(benchmark.scores.first().unwrap().controller, "srnf");
        let pd = benchmark.scores.iter().find(|score| score.controller == "pd").unwrap();
        // Section 3.3.2 and the closed forms: rests within Ts/Kp, never settles, does not hunt,
        // trails by 0.48 deg.
        assert!((100.0..166.0).contains(&pd.rest_error_counts.unwrap()));
        assert_eq!((pd.settling_time_s, pd.hunting_counts), (None, Some(0.0)));
        assert!((0.43..0.50).contains(&pd.tracking_rms_deg.unwrap()));
        assert_eq!((pd.disqualified, pd.mean_place), (Some(Disqualification::NeverSettles), None));
        // Section 3.3.6: feedforward leaves PD's rest error as it is.
        let last: Vec<&str> =
            benchmark.scores.iter().rev().take(2).map(|score| &*score.controller).collect();
        assert_eq!(last, ["pd", "feedforward"]);
    }

    #[test]
    fn a_joint_that_never_moves_and_one_that_climbs_in_stairs_are_reported() {
        let judged = |experiment: &str, set: &[&str]| {
            let mut document = Document::open(experiment).unwrap();
            document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
            let mut benchmark = benchmark(&[document], &Weights::default(), &Silent).unwrap();
            (benchmark.scores.remove(0), benchmark.results.remove(0))
        };
        let heavy = ["loop.controller=srnf", "joint.friction.stick_v=6", "joint.friction.slip_v=6"];
        let (stuck, _) = judged("step-response", &heavy);
        assert_eq!(stuck.disqualified, Some(Disqualification::NeverMoves));
        // At 0.02 deg/s, SRNF moves in stairs: each stick of the solver counts as a stop, except
        // the one at the end. At the thesis's own speeds there are none.
        let slow = [
            "loop.controller=srnf",
            "reference.trajectories=[{corner_times_s=[1, 101], corner_positions_deg=[0, 2], \
             half_blend_s=0.25}]",
        ];
        let (slow, results) = judged("trajectory", &slow);
        let is_stick = |event: &&Event| event.kind == EventKind::Stick;
        let events = results[0].events.iter().filter(is_stick).count() as f64;
        let counted = slow.sticks_in_motion.unwrap();
        assert!(events > 10.0 && (events - 1.0..=events).contains(&counted), "{counted} {events}");
        let (fast, _) = judged("trajectory", &["loop.controller=srnf"]);
        assert_eq!(fast.sticks_in_motion, Some(0.0));
    }
}
