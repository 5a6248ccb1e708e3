//! Runs of the report. Everything that it shows comes from these.

use std::collections::BTreeMap;

use indicatif::ProgressBar;
use rayon::prelude::*;

use super::runs::{AXIS, EPS, LAB};
use crate::lab::{self, LabPlan, LabResult};
use files::error::Error;
use files::machine::ThesisFigures;
use simulator::closed_loop::LoopSample;
use simulator::experiment::{Document, Experiment, RunPlan};
use simulator::metrics::RunMetrics;
use simulator::progress::Silent;
use simulator::run::{self, RunResult, RunTrace};
use studies::benchmark::{Score, Weights, benchmark};

/// Results, by the names in `runs.rs`.
pub struct ReportEvidence {
    axis: BTreeMap<&'static str, Vec<RunResult>>,
    /// For each name the run of the thesis's eps first.
    lab: BTreeMap<&'static str, Vec<Result<LabResult, String>>>,
    /// The control benchmark, best controller first.
    pub scores: Vec<Score>,
}

/// Planned runs of the report.
pub struct ReportPlans(Vec<(&'static str, Job)>);

enum Job {
    Axis(Box<RunPlan>),
    Lab(Box<LabPlan>),
}

enum Done {
    Axis(Box<RunResult>),
    Lab(Box<Result<LabResult, String>>),
}

impl ReportPlans {
    /// All runs of the report, checked.
    ///
    /// # Errors
    /// Returns an error that names what is wrong with a built-in experiment.
    pub fn new() -> Result<Self, Error> {
        let mut jobs = Vec::new();
        for set in LAB {
            let assignments =
                [format!("run.friction=[{:?}]", set.model), format!("run.solver={}", set.solver)];
            let more = set.set.iter().map(|s| (*s).to_owned());
            let document = opened(set.experiment, assignments.into_iter().chain(more).collect())?;
            for eps in EPS.iter().take(if set.is_scanned() { EPS.len() } else { 1 }) {
                let mut document = document.clone();
                document.set(&[format!("run.eps={eps}")])?;
                jobs.extend(
                    lab::plan(&document)?
                        .into_iter()
                        .map(|plan| (set.name, Job::Lab(Box::new(plan)))),
                );
            }
        }
        for set in AXIS {
            let assignments: Vec<String> = set.set.iter().map(|s| (*s).to_owned()).collect();
            let document = opened(set.experiment, assignments.clone())?;
            let controllers: Vec<String> =
                set.controllers.iter().map(|s| (*s).to_owned()).collect();
            let fixed: Vec<String> =
                assignments.iter().filter_map(|a| Some(a.split_once('=')?.0.to_owned())).collect();
            let plans = Experiment::plan(&document, &controllers, &fixed)?.runs;
            jobs.extend(plans.into_iter().map(|plan| (set.name, Job::Axis(Box::new(plan)))));
        }
        Ok(Self(jobs))
    }

    /// Returns the runs of one name.
    #[cfg(test)]
    pub fn only(name: &str) -> Result<Self, Error> {
        let mut all = Self::new()?;
        all.0.retain(|(of, _)| *of == name);
        Ok(all)
    }

    /// Returns the number of runs.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Runs them all. A failed solver in the friction lab is a result, too.
    ///
    /// # Errors
    /// Returns an error that names an invalid value.
    pub fn run(self, bar: &ProgressBar) -> Result<ReportEvidence, Error> {
        let run = |(name, job): &(&'static str, Job)| {
            let done = match job {
                Job::Axis(plan) => Done::Axis(Box::new(run::run(plan)?)),
                Job::Lab(plan) => {
                    Done::Lab(Box::new(lab::run(plan).map_err(|error| error.to_string())))
                }
            };
            bar.inc(1);
            Ok((*name, done))
        };
        let done: Vec<(&'static str, Done)> =
            self.0.par_iter().map(run).collect::<Result<_, Error>>()?;
        let mut evidence =
            ReportEvidence { axis: BTreeMap::new(), lab: BTreeMap::new(), scores: benchmarked()? };
        for (name, done) in done {
            match done {
                Done::Axis(result) => evidence.axis.entry(name).or_default().push(*result),
                Done::Lab(result) => evidence.lab.entry(name).or_default().push(*result),
            }
        }
        Ok(evidence)
    }
}

fn opened(experiment: &str, set: Vec<String>) -> Result<Document, Error> {
    let mut document = Document::open(experiment)?;
    document.set(&set)?;
    Ok(document)
}

fn benchmarked() -> Result<Vec<Score>, Error> {
    let documents = [Document::open("step-response")?, Document::open("trajectory")?];
    Ok(benchmark(&documents, &Weights::default(), &Silent)?.scores)
}

impl ReportEvidence {
    /// Returns the runs of the axis with a name.
    pub fn axis(&self, name: &str) -> &[RunResult] {
        self.axis.get(name).map(Vec::as_slice).unwrap_or_default()
    }

    /// Returns one of these runs, by its label.
    pub fn run(&self, name: &str, label: &str) -> Option<&RunResult> {
        self.axis(name).iter().find(|result| result.plan.label == label)
    }

    /// Returns one of these runs, so that a test can change its metrics.
    #[cfg(test)]
    pub fn run_mut(&mut self, name: &str, label: &str) -> Option<&mut RunResult> {
        self.axis.get_mut(name)?.iter_mut().find(|result| result.plan.label == label)
    }

    /// Returns a metric of several runs, or `None` if a run is missing.
    pub fn metrics(
        &self,
        name: &str,
        labels: &[&str],
        of: impl Fn(&RunMetrics) -> Option<f64>,
    ) -> Option<Vec<f64>> {
        labels.iter().map(|label| of(&self.run(name, label)?.metrics)).collect()
    }

    /// Returns the samples of a run.
    pub fn moments(&self, name: &str, label: &str) -> Option<&[LoopSample]> {
        match &self.run(name, label)?.trace {
            RunTrace::Loop(moments) => Some(moments),
            RunTrace::Ramp(_) => None,
        }
    }

    /// Returns a run of the friction lab.
    pub fn lab(&self, name: &str) -> Option<&LabResult> {
        self.lab.get(name)?.first()?.as_ref().ok()
    }

    /// Returns the derivative evaluations of a run; at each eps if it is scanned.
    pub fn evaluations(&self, name: &str) -> Option<Vec<f64>> {
        let each =
            self.lab.get(name)?.iter().map(|result| Some(result.as_ref().ok()?.evaluations as f64));
        each.collect()
    }

    /// Returns why the solver of a run of the friction lab failed.
    pub fn trouble(&self, name: &str) -> Option<&str> {
        self.lab.get(name)?.first()?.as_ref().err().map(String::as_str)
    }

    /// Returns why the first failed run failed.
    pub fn trouble_of_any(&self) -> Option<&str> {
        self.lab.values().flatten().find_map(|result| result.as_ref().err()).map(String::as_str)
    }

    /// Returns the number of runs.
    pub fn len(&self) -> usize {
        self.axis.values().map(Vec::len).sum::<usize>()
            + self.lab.values().map(Vec::len).sum::<usize>()
    }

    /// Returns the thesis's figures of a built-in experiment.
    ///
    /// # Errors
    /// Returns an error that names what is wrong with the experiment.
    pub fn sources(experiment: &str) -> Result<Vec<ThesisFigures>, Error> {
        Ok(Document::open(experiment)?.machine()?.figures)
    }
}
