//! `stiction tune`: tunes gains for a joint whose parameters are known within bounds.
//!
//! ```text
//! file -> knobs.rs: the gains of a controller ----------------+
//! file, spreads -> joints around the file's, each with and    |
//!      without a sample of delay -> servo, monitors -> rows   v
//! search.rs: gains -> figures.rs: cost for a goal, under limits -> the least
//!      -> judgement.rs: tried again on joints of another seed -> refusal.rs: or why not
//!      -> text.rs: a new file, a table; pareto.rs: charts
//! ```
//!
//! Gains are judged on other joints than those of the search, and on three times as many: a
//! judgement runs one to six sets of gains, the search some forty. Gains that are no better there
//! than the file's are dropped. If none of the best candidates is better, the file's gains stay. If
//! no joint succeeds at its load, the tuning is refused. Gains are judged at the encoder; the
//! figures at the load are reported too. Guarantees: the same result for the same seed on any
//! number of cores; no more failures on the joints of the judgement than with the file's gains.
//! Limits: the search finds a valley near the file's gains, not the lowest one; it covers only the
//! joint of the file with its spread.

mod figures;
mod judgement;
mod knobs;
mod limits;
mod pareto;
mod refusal;
mod search;
mod text;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

pub use self::figures::{SideFigures, TuningFigures, TuningGoal};
pub use self::knobs::Knob;
pub use self::limits::{CASES_ALLOWED, limit, takes_long};
use self::refusal::Evidence;
pub use self::text::{is_refused, object, reason, render, rewritten};
use crate::ensemble::{CaseResult, MachineEnsemble, MachineOptions, written_spreads};
use figure::chart::Chart;
use files::error::Error;
use simulator::experiment::{Document, Experiment};

/// Default number of joints on which gains are tried; each is run with and without a
/// sample of delay.
pub const CASES: u64 = 8;

/// Duration of a step, s: three times the time within which it should settle.
const DURATION_S: f64 = 15.0;

/// Ratio of the number of joints in the judgement to that in the search.
const JUDGES: u64 = 3;

/// Factors on the joint's gain that are tried for the margins, as well as their inverses.
const FACTORS: [f64; 6] = [1.25, 1.5, 2.0, 3.0, 4.0, 6.0];

/// Request of a tuning.
#[derive(Clone, Debug)]
pub struct GainSearch {
    /// Name of the machine's file.
    pub file: String,
    /// Contents of the file.
    pub document: Document,
    /// Objective of the gains.
    pub goal: TuningGoal,
    /// Upper limits of metrics.
    pub limits: Vec<(String, f64)>,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`.
    pub spreads: Vec<String>,
    /// Number of joints in the search; each runs with and without a sample of delay.
    pub cases: u64,
    /// Seed of the joints of the search. The joints of the judgement have the next seed.
    pub seed: u64,
}

/// A gain before and after the tuning.
#[derive(Clone, Debug, PartialEq)]
pub struct TunedGain {
    /// Key in the table of the controller.
    pub key: &'static str,
    /// Value before the tuning: that of the file, or of the law's rule.
    pub from: f64,
    /// Value after the tuning; equal to `from` if the file's gains stay.
    pub to: f64,
}

/// Result of the tuning of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct TuningResult {
    /// Name of the controller.
    pub controller: String,
    /// Gains of the controller.
    pub gains: Vec<TunedGain>,
    /// Whether these gains are better than the file's and a joint succeeds; otherwise the file's
    /// gains stay.
    pub better: bool,
    /// Reason why the file's gains stay, with a remedy; `None` if other gains are better.
    pub refusal: Option<String>,
    /// Figures of the file's gains on the joints of the judgement.
    pub before: TuningFigures,
    /// Figures of the kept gains on the same joints.
    pub after: TuningFigures,
    /// Figures of all tried sets of gains on the joints of the search; the first set is the file's.
    pub tried: Vec<TuningFigures>,
    /// Index of the kept gains in `tried`; 0 for the file's gains.
    pub kept: usize,
    /// Smallest and largest tried factor on the joint's gain between which the kept gains succeed;
    /// the joint has a sample of delay.
    pub margins: [f64; 2],
    /// Worst joint of the judgement: its drawn keys, its delay in samples, its result.
    pub worst: Option<(Vec<String>, u8, CaseResult)>,
}

/// Result of the gains that are in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct CurrentResult {
    /// Figures on the joints of the judgement, as in [`TuningResult`].
    pub figures: TuningFigures,
    /// Margins, as in [`TuningResult`].
    pub margins: [f64; 2],
    /// Worst joint, as in [`TuningResult`].
    pub worst: Option<(Vec<String>, u8, CaseResult)>,
}

impl TuningResult {
    /// Returns whether no joint of the judgement succeeds at its load, with the file's gains or
    /// with others.
    pub const fn is_refused(&self) -> bool {
        !self.better && self.before.at_load.successes == 0
    }

    /// Returns the new gains with their keys in a file; empty if the file's gains stay.
    pub fn set(&self) -> Vec<(String, f64)> {
        let gains = self.gains.iter().filter(|_| self.better);
        gains.map(|gain| (path(&self.controller, gain.key), gain.to)).collect()
    }
}

impl GainSearch {
    /// Tunes a controller of the file, and calls `tried_one` before each set of gains.
    ///
    /// # Errors
    /// Returns an error about the file or a spread, or if the controller has no gain to tune.
    pub fn tune(
        &self,
        controller: &str,
        tried_one: &(dyn Fn() + Sync),
    ) -> Result<TuningResult, Error> {
        let cancelled = || Error::Input(format!("{}: the search has ended by itself", self.file));
        self.tune_while(controller, tried_one, &|| true)?.ok_or_else(cancelled)
    }

    /// Tunes as [`tune`](Self::tune) does, and calls `goes_on` before each joint. If it returns
    /// false, the tuning ends within the time of one joint, and the result is `None`.
    ///
    /// # Errors
    /// As [`tune`](Self::tune).
    pub fn tune_while(
        &self,
        controller: &str,
        tried_one: &(dyn Fn() + Sync),
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<TuningResult>, Error> {
        let wanted = [controller.to_owned()];
        let runs = Experiment::without_variants(&self.document, &wanted)?;
        let plan = runs.first().ok_or_else(|| {
            Error::Input(format!("{}: {controller} positions nothing", self.file))
        })?;
        let knobs = knobs::knobs(plan)?;
        if knobs.is_empty() {
            let why = "has no gain above 0 to tune (with two encoders, `robust` has only values of \
                the joint); take another one with --controller";
            return Err(Error::Input(format!("{}: the controller {controller} {why}", self.file)));
        }
        if !goes_on() {
            return Ok(None);
        }
        let searched = [self.seed, self.cases];
        let Some(rows) = self.rows_while(controller, &[], searched, goes_on)? else {
            return Ok(None);
        };
        let start = TuningFigures::of(&rows);
        if self.goal == TuningGoal::Track && start.at_encoder.tracking_counts.is_none() {
            return Err(Error::Input(format!(
                "{}: the goal track needs a trajectory in `reference.trajectories`",
                self.file
            )));
        }
        let tried = Mutex::new(vec![start]);
        let candidates = Mutex::new(Vec::new());
        let is_cancelled = AtomicBool::new(false);
        let cost = |factors: &[f64]| {
            // The search cannot be cancelled, but it ends soon if all costs are equal.
            if is_cancelled.load(Ordering::Relaxed) || !goes_on() {
                is_cancelled.store(true, Ordering::Relaxed);
                return 0.0;
            }
            tried_one();
            // Gains that the core refuses have a very high cost.
            let set = set(controller, &knobs, factors);
            let rows = match self.rows_while(controller, &set, searched, goes_on) {
                Ok(Some(rows)) => rows,
                Ok(None) => {
                    is_cancelled.store(true, Ordering::Relaxed);
                    return 0.0;
                }
                Err(_) => return 1e3,
            };
            let figures = TuningFigures::of(&rows);
            tried.lock().unwrap_or_else(PoisonError::into_inner).push(figures);
            let cost = figures.cost(&start, self.goal, &self.limits);
            let candidate = (cost - start.cost(&start, self.goal, &self.limits), factors.to_vec());
            candidates.lock().unwrap_or_else(PoisonError::into_inner).push(candidate);
            cost
        };
        search::least(knobs.len(), &cost)?;
        if is_cancelled.into_inner() {
            return Ok(None);
        }
        let judged = [self.judged(), self.judges()];
        let Some(before) = self.rows_while(controller, &[], judged, goes_on)? else {
            return Ok(None);
        };
        let was = TuningFigures::of(&before);
        let candidates = candidates.into_inner().unwrap_or_else(PoisonError::into_inner);
        // In the order of `tried`, whose first entry is that of the file's gains.
        let order: Vec<Vec<f64>> = candidates.iter().map(|(_, factors)| factors.clone()).collect();
        let passed = judgement::first(
            candidates,
            &before,
            (self.goal, &self.limits),
            |factors| set(controller, &knobs, factors),
            |set| self.rows_while(controller, set, judged, goes_on),
        )?;
        let judgement::Outcome::Judged(passed) = passed else { return Ok(None) };
        let tried = tried.into_inner().unwrap_or_else(PoisonError::into_inner);
        let found = passed.as_ref().map(|passed| TuningFigures::of(&passed.rows));
        let refusal = Evidence {
            controller,
            figures: [&was, found.as_ref().unwrap_or(&was)],
            rows: passed.as_ref().map_or(&before, |passed| &passed.rows),
            is_better: passed.is_some(),
            tried: tried.len(),
            goal: &self.document.machine()?.goal,
            slack: self.document.unseen_slack()?,
        }
        .refusal();
        let better = refusal.is_none();
        let judgement::Passed { factors, set, rows } =
            passed.filter(|_| better).unwrap_or_else(|| judgement::Passed {
                factors: vec![1.0; knobs.len()],
                set: Vec::new(),
                rows: before,
            });
        let kept = order.iter().position(|one| better && *one == factors);
        let stays = TuningFigures::of(&rows);
        let turned = knobs.iter().zip(&factors).map(|(knob, factor)| {
            let to = if better { rounded(knob.start * factor) } else { knob.start };
            TunedGain { key: knob.key, from: knob.start, to }
        });
        let Some(margins) = self.margins(controller, &set, goes_on)? else { return Ok(None) };
        Ok(Some(TuningResult {
            controller: controller.into(),
            gains: turned.collect(),
            better,
            refusal,
            before: was,
            after: stays,
            tried,
            kept: kept.map_or(0, |place| place + 1),
            margins,
            worst: self.worst(controller, rows)?,
        }))
    }

    /// Returns the approximate number of runs of the search's set of joints in a tuning, to
    /// estimate its time. Margins are left out: each of their runs has one joint.
    ///
    /// # Errors
    /// As [`tune`](Self::tune).
    pub fn about_sets(&self, controller: &str) -> Result<u64, Error> {
        let wanted = [controller.to_owned()];
        let runs = Experiment::without_variants(&self.document, &wanted)?;
        let gains = runs.first().map(knobs::knobs).transpose()?.map_or(0, |knobs| knobs.len());
        Ok(search::about(gains) + JUDGES * (1 + judgement::CANDIDATES as u64))
    }

    /// Judges a controller with the gains of the file.
    ///
    /// # Errors
    /// Returns an error about the file or a spread.
    pub fn standing(&self, controller: &str) -> Result<CurrentResult, Error> {
        let rows = self.rows(controller, &[], [self.judged(), self.judges()])?;
        Ok(CurrentResult {
            figures: TuningFigures::of(&rows),
            // It is not cancelled.
            margins: self.margins(controller, &[], &|| true)?.unwrap_or([1.0; 2]),
            worst: self.worst(controller, rows)?,
        })
    }

    /// Returns charts of the tried gains.
    ///
    /// # Errors
    /// Returns an error about the file.
    pub fn charts(&self, tuned: &[TuningResult]) -> Result<Vec<Chart>, Error> {
        let machine = self.document.machine()?;
        let count_deg = machine.count_deg();
        Ok(pareto::charts(&self.file, tuned, &machine.goal, count_deg))
    }

    /// Returns the seed of the joints on which gains are judged.
    const fn judged(&self) -> u64 {
        self.seed.wrapping_add(1)
    }

    /// Returns the number of joints on which gains are judged.
    pub const fn judges(&self) -> u64 {
        self.cases.saturating_mul(JUDGES)
    }

    /// Runs the joints of a seed under a controller with the gains `set`, without and with a sample
    /// of delay.
    fn rows(
        &self,
        controller: &str,
        set: &[(String, f64)],
        [seed, cases]: [u64; 2],
    ) -> Result<Vec<CaseResult>, Error> {
        // The runs are never cancelled, so there are rows.
        let rows = self.rows_while(controller, set, [seed, cases], &|| true)?;
        Ok(rows.unwrap_or_default())
    }

    /// Runs joints as `rows` does, and calls `goes_on` before each joint. If it returns false, the
    /// result is `None`.
    fn rows_while(
        &self,
        controller: &str,
        set: &[(String, f64)],
        [seed, cases]: [u64; 2],
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Vec<CaseResult>>, Error> {
        let rows = Mutex::new(Vec::new());
        for delay in 0..2 {
            self.ensemble(controller, set, delay)?.run_some(
                [seed, cases],
                |_, _| goes_on(),
                |row| {
                    let place = (row.case, delay);
                    rows.lock().unwrap_or_else(PoisonError::into_inner).push((place, row));
                    Ok(())
                },
            )?;
        }
        let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        rows.sort_by_key(|(place, _)| *place);
        Ok(goes_on().then(|| rows.into_iter().map(|(_, row)| row).collect()))
    }

    fn ensemble(
        &self,
        controller: &str,
        set: &[(String, f64)],
        delay: u8,
    ) -> Result<MachineEnsemble, Error> {
        let mut document = self.document.clone();
        document.set(&[format!("run.delay_samples={delay}")])?;
        document.set_numbers(set)?;
        let controllers = [controller.to_owned()];
        let around = MachineOptions {
            controllers: &controllers,
            spreads: &self.spreads,
            ..MachineOptions::default()
        };
        MachineEnsemble::around(&self.file, document, around, DURATION_S)
    }

    /// Returns the smallest and the largest tried factor on the joint's gain up to which the joint
    /// succeeds; `None` if `goes_on` returns false. In a data sheet, the inertias of load and rotor
    /// are divided by the factor.
    fn margins(
        &self,
        controller: &str,
        set: &[(String, f64)],
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<[f64; 2]>, Error> {
        const GAIN: &str = "joint.gain_deg_per_s2_per_v";
        const INERTIAS: [&str; 2] = ["load.inertia_kg_m2", "motor.rotor_inertia_kg_m2"];
        let exactly = |key: &str, value: f64| format!("{key}={value:?}..{value:?}");
        let around = |factor: f64| -> Vec<String> {
            let gain = self.document.number(GAIN).map(|gain| exactly(GAIN, gain * factor));
            let inertia = |key| Some(exactly(key, self.document.number(key)? / factor));
            gain.into_iter().chain(INERTIAS.into_iter().filter_map(inertia)).collect()
        };
        if around(1.0).is_empty() {
            return Ok(Some([1.0; 2]));
        }
        let succeeds = |factor: f64| -> Result<bool, Error> {
            let alone = Self { spreads: around(factor), ..self.clone() };
            let rows = alone.ensemble(controller, set, 1)?.run(self.seed, 1)?;
            let figures = TuningFigures::of(&rows);
            Ok(figures.at_encoder.successes == figures.cases)
        };
        let mut margins = [1.0; 2];
        for (margin, up) in margins.iter_mut().zip([false, true]) {
            for factor in FACTORS.map(|factor| if up { factor } else { 1.0 / factor }) {
                if !goes_on() {
                    return Ok(None);
                }
                if !succeeds(factor)? {
                    break;
                }
                *margin = factor;
            }
        }
        Ok(Some(margins))
    }

    fn worst(
        &self,
        controller: &str,
        rows: Vec<CaseResult>,
    ) -> Result<Option<(Vec<String>, u8, CaseResult)>, Error> {
        let late = |row: &CaseResult| {
            let settled_s = row.settled_at_encoder_s.filter(|_| row.faults().next().is_none());
            settled_s.unwrap_or(f64::INFINITY)
        };
        // The two rows of a case are in the order of their delays.
        let worst = rows.into_iter().enumerate().max_by(|(_, a), (_, b)| {
            late(a)
                .total_cmp(&late(b))
                .then(a.rest_at_encoder_counts.total_cmp(&b.rest_at_encoder_counts))
        });
        let Some((place, row)) = worst else { return Ok(None) };
        let drawn = self.ensemble(controller, &[], 0)?.drawn(self.judged(), row.case);
        Ok(Some((drawn, (place % 2) as u8, row)))
    }
}

/// Returns the key of a controller's gain in a file.
fn path(controller: &str, gain: &str) -> String {
    format!("controller.{controller}.{gain}")
}

/// Returns the gains of a controller with their keys, each multiplied by its factor.
fn set(controller: &str, knobs: &[Knob], factors: &[f64]) -> Vec<(String, f64)> {
    let pairs = knobs.iter().zip(factors);
    pairs
        .map(|(Knob { key, start }, factor)| (path(controller, key), rounded(start * factor)))
        .collect()
}

/// Rounds to four digits; further digits have no meaning.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Returns the spread of a file's joint, `KEY=LOW..HIGH`: its `[spread]`, or else [`assumed`].
///
/// # Errors
/// Returns an error about the file.
pub fn spreads(document: &Document) -> Result<Vec<String>, Error> {
    let written = written_spreads(document)?;
    Ok(if written.is_empty() { assumed(document) } else { written })
}

/// Returns the assumed spread of a file without `[spread]`: inertia 20 % and viscous friction 50 %
/// to either side; slip friction from 25 % below to the middle between slip and stick, and stick
/// friction from there to 25 % above. For friction this is the worst accuracy of identification
/// methods; the slip friction of a joint never exceeds its stick friction.
pub fn assumed(document: &Document) -> Vec<String> {
    const ALONE: [(&str, f64); 4] = [
        ("joint.gain_deg_per_s2_per_v", 0.2),
        ("joint.viscous_v_per_deg_per_s", 0.5),
        ("load.inertia_kg_m2", 0.2),
        ("friction.viscous_nm_s_per_rad", 0.5),
    ];
    const LEVELS: [[&str; 2]; 2] = [
        ["joint.friction.slip_v", "joint.friction.stick_v"],
        ["friction.slip_nm", "friction.stick_nm"],
    ];
    let range =
        |key: &str, low: f64, high: f64| format!("{key}={:?}..{:?}", rounded(low), rounded(high));
    let alone = ALONE.into_iter().filter_map(|(key, share)| {
        let value = document.number(key)?;
        Some(range(key, value * (1.0 - share), value * (1.0 + share)))
    });
    let levels = LEVELS.into_iter().filter_map(|[slip, stick]| {
        let (below, above) = (document.number(slip)?, document.number(stick)?);
        let middle = 0.5 * (below + above);
        Some([range(slip, 0.75 * below, middle), range(stick, middle, 1.25 * above)])
    });
    alone.chain(levels.flatten()).collect()
}
