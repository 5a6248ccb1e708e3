//! The thesis's control benchmark (section 3.3.1) on one table: which controller does best on a
//! joint.
//!
//! Every controller takes the joint through the same steps and trajectories; each is judged by its
//! worst run. Steps are run once as the file says and once for 120 s: hunting is slow, and a
//! controller that looks at rest after 10 s may have been waiting for its integral.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::{Document, Experiment, RunPlan, Task};
use crate::run::{RunResult, run_all};

/// How long a step is watched for hunting.
const HUNTING_DURATION: &str = "run.duration_s=120";

/// One controller's row. `None`: it never settled, or nothing of that kind was run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// The name of the controller.
    pub controller: String,
    /// Largest rest error of a step, counts.
    pub rest_error_counts: Option<f64>,
    /// Largest overshoot of a step, deg.
    pub overshoot_deg: Option<f64>,
    /// Longest settling of a step, s; `None` if any never settles.
    pub settling_time_s: Option<f64>,
    /// Largest rms error of a trajectory, deg.
    pub tracking_rms_deg: Option<f64>,
    /// Largest total variation of the drive's output in steps and trajectories, V/s.
    pub chatter_v_per_s: Option<f64>,
    /// Largest peak-to-peak of a step watched for 120 s, counts; zero if none hunts.
    pub hunting_counts: Option<f64>,
    /// Whether any of its runs is unstable or diverged: then its other values say little, and it is
    /// ranked last.
    pub unstable: bool,
    /// Mean of its places in the six columns: 1 is the best in every one.
    pub mean_place: f64,
}

/// The table, best first, and the runs that it was made of (without those of 120 s).
#[derive(Clone, Debug)]
pub struct Benchmark {
    /// A row a controller.
    pub scores: Vec<Score>,
    /// The runs of each document.
    pub results: Vec<Vec<RunResult>>,
}

/// Runs the benchmark on documents that name the same controllers; variants other than the plain
/// one are left out.
///
/// # Errors
/// Says what is wrong with a document.
pub fn benchmark(documents: &[Document]) -> Result<Benchmark, Error> {
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
    rank(&mut scores);
    Ok(Benchmark { scores, results })
}

/// The runs of a document that the benchmark judges: every controller, and no variant.
///
/// # Errors
/// Says what is wrong with the document.
pub fn plain_runs(document: &Document) -> Result<Vec<RunPlan>, Error> {
    let mut plans = Experiment::plan(document, &[], &[])?.runs;
    plans.retain(|plan| plan.slugs().is_empty() && plan.controller.is_some());
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
    let settles = steps.iter().all(|result| result.metrics.settling_time_s.is_some());
    Score {
        controller: controller.into(),
        rest_error_counts: largest(
            &mut steps.iter().map(|r| r.metrics.rest_error_counts.map(f64::abs)),
        ),
        overshoot_deg: largest(&mut steps.iter().map(|r| r.metrics.overshoot_deg)),
        settling_time_s: largest(&mut steps.iter().map(|r| r.metrics.settling_time_s))
            .filter(|_| settles),
        tracking_rms_deg: largest(&mut trajectories.iter().map(|r| r.metrics.rms_error_deg)),
        chatter_v_per_s: largest(
            &mut steps
                .iter()
                .chain(&trajectories)
                .map(|r| r.metrics.control_total_variation_v_per_s),
        ),
        hunting_counts: largest(&mut watched.iter().map(|r| {
            let resolution_deg = r.plan.machine.encoder.resolution_deg();
            Some(r.metrics.hunting_peak_to_peak_deg.unwrap_or(0.0) / resolution_deg)
        })),
        unstable: steps.iter().chain(&trajectories).chain(&watched).any(|result| result.unstable),
        mean_place: 0.0,
    }
}

/// Gives each row the mean of its places, and sorts by it. Equal values share the better place; a
/// missing one is last, and so is every value of an unstable controller.
fn rank(scores: &mut [Score]) {
    let columns: [fn(&Score) -> Option<f64>; 6] = [
        |score| score.rest_error_counts,
        |score| score.overshoot_deg,
        |score| score.settling_time_s,
        |score| score.tracking_rms_deg,
        |score| score.chatter_v_per_s,
        |score| score.hunting_counts,
    ];
    let value = |score: &Score, column: fn(&Score) -> Option<f64>| {
        column(score).filter(|_| !score.unstable).unwrap_or(f64::INFINITY)
    };
    let places: Vec<f64> = scores
        .iter()
        .map(|score| {
            let better = |column| {
                scores.iter().filter(|other| value(other, column) < value(score, column)).count()
                    as f64
            };
            columns.iter().map(|column| 1.0 + better(*column)).sum::<f64>() / columns.len() as f64
        })
        .collect();
    for (score, place) in scores.iter_mut().zip(places) {
        score.mean_place = place;
    }
    scores.sort_by(|a, b| a.mean_place.total_cmp(&b.mean_place));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(controller: &str, values: [Option<f64>; 6]) -> Score {
        let [rest, overshoot, settling, tracking, chatter, hunting] = values;
        Score {
            controller: controller.into(),
            rest_error_counts: rest,
            overshoot_deg: overshoot,
            settling_time_s: settling,
            tracking_rms_deg: tracking,
            chatter_v_per_s: chatter,
            hunting_counts: hunting,
            unstable: false,
            mean_place: 0.0,
        }
    }

    #[test]
    fn places_are_counted_column_by_column_and_one_that_never_settles_is_last() {
        let mut scores = [
            score("c", [3.0, 3.0, 1.0, 3.0, 3.0, 3.0].map(Some)),
            score("b", [Some(2.0), Some(1.0), None, Some(1.0), Some(2.0), Some(1.0)]),
            score("a", [1.0, 1.0, 2.0, 2.0, 1.0, 2.0].map(Some)),
        ];
        rank(&mut scores);
        let ranked = scores.map(|score| (score.controller, score.mean_place));
        // a: 1 1 2 2 1 2; b: 2 1 3 1 2 1; c: 3 3 1 3 3 3. Two share the first place in overshoot.
        let expected = [("a", 9.0 / 6.0), ("b", 10.0 / 6.0), ("c", 16.0 / 6.0)];
        assert_eq!(ranked, expected.map(|(name, place)| (name.into(), place)));
    }

    #[test]
    fn an_unstable_controller_is_last_whatever_its_values_are() {
        let mut wild = score("wild", [0.0; 6].map(Some));
        wild.unstable = true;
        let mut scores = [wild, score("tame", [9.0; 6].map(Some))];
        rank(&mut scores);
        assert_eq!(
            scores.map(|score| (score.controller, score.mean_place)),
            [("tame".into(), 1.0), ("wild".into(), 2.0)]
        );
    }

    #[test]
    fn variants_and_runs_with_a_delay_are_left_out() {
        let benchmark = benchmark(&[Document::open("high-gain").unwrap()]).unwrap();
        let labels = benchmark.results.iter().flatten().map(|result| result.plan.label.as_str());
        assert_eq!(labels.filter(|label| label.contains("delay-1")).count(), 0);
        assert_eq!(benchmark.scores.len(), 5);
    }

    #[test]
    fn srnf_is_ahead_of_pd_on_the_thesis_s_robot_and_every_row_is_the_worst_of_its_runs() {
        let documents = ["step-response", "trajectory"].map(|name| Document::open(name).unwrap());
        let benchmark = benchmark(&documents).unwrap();
        assert_eq!(benchmark.results.iter().flatten().count(), 7 * 5);
        assert_eq!(benchmark.scores.first().unwrap().controller, "srnf");
        let pd = benchmark.scores.iter().find(|score| score.controller == "pd").unwrap();
        // Section 3.3.2 and the closed forms: rests within Ts/Kp, never settles, does not hunt,
        // trails by 0.48 deg.
        assert!((100.0..166.0).contains(&pd.rest_error_counts.unwrap()));
        assert_eq!((pd.settling_time_s, pd.hunting_counts), (None, Some(0.0)));
        assert!((0.43..0.50).contains(&pd.tracking_rms_deg.unwrap()));
    }
}
