//! `stiction tune`: gains for a joint that is known within bounds.
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
//! The joints on which gains are judged are not those on which they were found, and three times as
//! many: a judgement is one to six sets of gains, the search some forty. Gains that are no better
//! there than those of the file are dropped, and if the next best ones are no better either, or no
//! joint succeeds, the tuning is refused and the file's stay. Gains are judged at the encoder, and
//! the load's figures are beside. Guarantees: the same result for the same seed on any number of
//! cores; no more failures on the joints of the judgement than the file's gains have. Does badly:
//! it finds a valley near the file's gains, not the lowest one; it knows the joint of the file with
//! its spread, and nothing that the file does not say.

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

/// So long a step is watched, s: three times the time within which it should settle.
const DURATION_S: f64 = 15.0;

/// Joints of the judgement for each joint of the search.
const JUDGES: u64 = 3;

/// Factors on the joint's gain that the margins try; their inverses as well.
const FACTORS: [f64; 6] = [1.25, 1.5, 2.0, 3.0, 4.0, 6.0];

/// What is asked for.
#[derive(Clone, Debug)]
pub struct GainSearch {
    /// The name of the file.
    pub file: String,
    /// The file.
    pub document: Document,
    /// Objective of the gains.
    pub goal: TuningGoal,
    /// Upper limits of metrics.
    pub limits: Vec<(String, f64)>,
    /// Keys of the joint that vary, `KEY=LOW..HIGH`.
    pub spreads: Vec<String>,
    /// Joints; each is run with and without a sample of delay.
    pub cases: u64,
    /// Seed of the joints on which gains are looked for; those on which they are judged have the
    /// next one.
    pub seed: u64,
}

/// A gain before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct TunedGain {
    /// Its key.
    pub key: &'static str,
    /// The value of the file, or of the law's rule.
    pub from: f64,
    /// The value that was found.
    pub to: f64,
}

/// What was found for a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct TuningResult {
    /// Its name.
    pub controller: String,
    /// Its gains.
    pub gains: Vec<TunedGain>,
    /// Whether they are better than the file's and some joint succeeds; if not, the file's stay.
    pub better: bool,
    /// Why the file's gains stay, and what would help; none if others are better.
    pub refusal: Option<String>,
    /// The file's gains on the joints of the judgement.
    pub before: TuningFigures,
    /// The gains that stay, there.
    pub after: TuningFigures,
    /// Everything that was tried, on the joints of the search; the first are the file's gains.
    pub tried: Vec<TuningFigures>,
    /// Place of the gains that stay in `tried`.
    pub kept: usize,
    /// Factors on the file's joint between which the gains that stay succeed, of those that were
    /// tried; the joint has a sample of delay there.
    pub margins: [f64; 2],
    /// Worst joint of the judgement: its drawn keys, its delay in samples, its result.
    pub worst: Option<(Vec<String>, u8, CaseResult)>,
}

/// What the gains of a file come to.
#[derive(Clone, Debug, PartialEq)]
pub struct CurrentResult {
    /// On the joints of the judgement, those on which [`TuningResult`] has its figures.
    pub figures: TuningFigures,
    /// As of [`TuningResult`].
    pub margins: [f64; 2],
    /// As of [`TuningResult`].
    pub worst: Option<(Vec<String>, u8, CaseResult)>,
}

impl TuningResult {
    /// Returns whether no joint of the judgement succeeds, with the file's gains or with others.
    pub const fn is_refused(&self) -> bool {
        !self.better && self.before.at_load.successes == 0
    }

    /// Returns these gains with their keys in a file; none if the file's stay.
    pub fn set(&self) -> Vec<(String, f64)> {
        let gains = self.gains.iter().filter(|_| self.better);
        gains.map(|gain| (path(&self.controller, gain.key), gain.to)).collect()
    }
}

impl GainSearch {
    /// Tunes a controller of the file, and calls `tried_one` before each set of gains.
    ///
    /// # Errors
    /// Names what is wrong with the file, a spread or a limit, or a controller that has nothing to
    /// turn.
    pub fn tune(
        &self,
        controller: &str,
        tried_one: &(dyn Fn() + Sync),
    ) -> Result<TuningResult, Error> {
        let cancelled = || Error::Input(format!("{}: the search has ended by itself", self.file));
        self.tune_while(controller, tried_one, &|| true)?.ok_or_else(cancelled)
    }

    /// Tunes as [`tune`](Self::tune) does, and calls `goes_on` before each joint that is run.
    /// Returns nothing if that returned false. So a tuning ends within the time of one joint.
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
            let why = "has no gain above zero to turn (`robust` with two encoders has facts of the \
                joint alone); --controller names another one";
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
            // The search has no way out, but it ends soon where all costs are the same.
            if is_cancelled.load(Ordering::Relaxed) || !goes_on() {
                is_cancelled.store(true, Ordering::Relaxed);
                return 0.0;
            }
            tried_one();
            // Gains that the core refuses are no gains.
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
        // In the order of `tried`, behind the file's gains.
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

    /// About how many sets of joints a tuning runs, counted in those of the search: for an estimate
    /// of its time. Margins are runs of one joint each, and are left out.
    ///
    /// # Errors
    /// As [`tune`](Self::tune).
    pub fn about_sets(&self, controller: &str) -> Result<u64, Error> {
        let wanted = [controller.to_owned()];
        let runs = Experiment::without_variants(&self.document, &wanted)?;
        let gains = runs.first().map(knobs::knobs).transpose()?.map_or(0, |knobs| knobs.len());
        Ok(search::about(gains) + JUDGES * (1 + judgement::CANDIDATES as u64))
    }

    /// Judges a controller of the file as it stands.
    ///
    /// # Errors
    /// Names what is wrong with the file or a spread.
    pub fn standing(&self, controller: &str) -> Result<CurrentResult, Error> {
        let rows = self.rows(controller, &[], [self.judged(), self.judges()])?;
        Ok(CurrentResult {
            figures: TuningFigures::of(&rows),
            // It is not cancelled.
            margins: self.margins(controller, &[], &|| true)?.unwrap_or([1.0; 2]),
            worst: self.worst(controller, rows)?,
        })
    }

    /// Charts what was tried.
    ///
    /// # Errors
    /// Names what is wrong with the file.
    pub fn charts(&self, tuned: &[TuningResult]) -> Result<Vec<Chart>, Error> {
        let machine = self.document.machine()?;
        let count_deg = machine.count_deg();
        Ok(pareto::charts(&self.file, tuned, &machine.goal, count_deg))
    }

    /// The seed of the joints on which gains are judged.
    const fn judged(&self) -> u64 {
        self.seed.wrapping_add(1)
    }

    /// The number of joints on which gains are judged.
    pub const fn judges(&self) -> u64 {
        self.cases.saturating_mul(JUDGES)
    }

    /// Runs joints of a seed under a controller with keys set, without a delay and with
    /// one.
    fn rows(
        &self,
        controller: &str,
        set: &[(String, f64)],
        [seed, cases]: [u64; 2],
    ) -> Result<Vec<CaseResult>, Error> {
        // Without an end there are rows.
        let rows = self.rows_while(controller, set, [seed, cases], &|| true)?;
        Ok(rows.unwrap_or_default())
    }

    /// Does the same as long as `goes_on` returns true; `None` if it did not. It is called before
    /// each joint.
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

    /// The smallest and the largest factor on the joint's gain up to which all succeed. A joint of
    /// a data sheet has a larger gain if it has less inertia, of the load and of the rotor. None if
    /// `goes_on` says no.
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
        // Rows of a case stand in the order of their delays.
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

/// Returns the gains of a controller, each turned by its factor.
fn set(controller: &str, knobs: &[Knob], factors: &[f64]) -> Vec<(String, f64)> {
    let pairs = knobs.iter().zip(factors);
    pairs
        .map(|(Knob { key, start }, factor)| (path(controller, key), rounded(start * factor)))
        .collect()
}

/// Rounds to four digits: more are not known.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// How far the joint of a file may be off: what its `[spread]` says, or else [`assumed`].
///
/// # Errors
/// Names what is wrong with the file.
pub fn spreads(document: &Document) -> Result<Vec<String>, Error> {
    let written = written_spreads(document)?;
    Ok(if written.is_empty() { assumed(document) } else { written })
}

/// Returns the spread of a file without `[spread]`: inertia of 20 % and viscous friction
/// of 50 % to either side; slip friction from 25 % below to the middle between slip and stick, and
/// stick friction from there to 25 % above. So friction is off as far as methods of identification
/// leave it at worst, and no joint slips with more than it sticks with.
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
