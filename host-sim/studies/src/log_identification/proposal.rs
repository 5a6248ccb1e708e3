//! Proposes terms that the model leaves out, and that would lower the residual.
//!
//! Each term is fitted to the same rows. A term pays if it meets all of these conditions:
//!
//! ```text
//! n ln(R_0 / R_1) - k ln n > 10      BIC, with the residual's power R before and with k coefficients
//! r_1 <= 2/3 r_0                     relative residuals r
//! sqrt(r_0^2 - r_1^2) >= 0.2 %       what the term explains, of the effort
//! ```
//!
//! BIC: G. Schwarz, *Annals of Statistics* 6 (1978), 461; a difference above 10 is very strong (R.
//! E. Kass and A. E. Raftery, *J. American Statistical Association* 90 (1995), 773). Rows that lie
//! closer than half a period of the cut-off are not independent, so n counts half periods.
//! The second bound is for residuals with a longer correlation, for which BIC overestimates the
//! information. The third is the accuracy of the inertia at the cut-off. A Stribeck term is
//! proposed only if the friction falls with the speed by more than two standard deviations.
//!
//! Limits: each term is tried alone, on the rows of the fit. `--stribeck` uses slower rows as well,
//! so the residual of that command differs.

use super::model::{FittedModel, MachineModel, RegressionSample};
use super::regression;
use files::error::rounded;

/// Drop of BIC that a term needs.
const DROP: f64 = 10.0;

/// Largest part of the residual that a term may leave.
const LEFT: f64 = 2.0 / 3.0;

/// Least share of the effort that a term explains, %.
const LEAST_PERCENT: f64 = 0.2;

/// Number of rows in the search for the Stribeck velocity.
const SEARCHED: usize = 8_000;

/// Least drop of friction with speed, standard deviations.
const FALLS: f64 = 2.0;

/// A term that the model leaves out, and that would lower the residual.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Proposal {
    /// Short name of the term, for scripts.
    pub term: &'static str,
    /// Residual of the model as it is, % of the effort.
    pub residual_before: f64,
    /// Residual with the term, %.
    pub residual_with: f64,
    /// Option of `stiction identify` that adds the term.
    pub option: &'static str,
}

impl Proposal {
    /// Returns the sentence: gravity would lower the residual from 0.83 % to 0.08 %: add
    /// `--gravity`.
    pub fn words(&self) -> String {
        let Self { term, residual_before, residual_with, option } = self;
        let what = match *term {
            "stribeck" => "a Stribeck term",
            "asymmetric" => "friction that differs by the direction",
            term => term,
        };
        let [before, with] = [residual_before, residual_with].map(|percent| two_digits(*percent));
        format!("{what} would lower the residual from {before} % to {with} %: add `{option}`")
    }
}

fn two_digits(percent: f64) -> String {
    rounded(format!("{percent:.1e}").parse().unwrap_or(percent))
}

/// Returns the terms that would pay, the best first. `independent` is the number of independent
/// rows, `creeping` the creeping speed. Gravity is not proposed for a linear machine: there it does
/// not depend on the position.
pub fn proposals(
    fitted: &FittedModel,
    moments: &[RegressionSample],
    (independent, creeping): (f64, f64),
    is_linear: bool,
) -> Vec<Proposal> {
    let model = fitted.model;
    let mut all = Vec::new();
    let mut consider = |term, option, more: f64, with: Option<FittedModel>| {
        all.extend(with.filter(|with| pays(fitted, with, more, independent)).map(|with| {
            Proposal {
                term,
                residual_before: fitted.relative_residual_percent(),
                residual_with: with.relative_residual_percent(),
                option,
            }
        }));
    };
    let fit = |model: MachineModel| regression::fit(model, moments).ok();
    if !model.has_gravity && !is_linear {
        consider("gravity", "--gravity", 2.0, fit(MachineModel { has_gravity: true, ..model }));
    }
    if model.stribeck.is_none() {
        let stride = moments.len().div_ceil(SEARCHED).max(1);
        let few: Vec<RegressionSample> = moments.iter().step_by(stride).copied().collect();
        let found = regression::stribeck(model, &few, creeping).ok();
        let with = found
            .and_then(|found| fit(found.model))
            .filter(|with| with.get("stribeck").is_some_and(|term| term.value > FALLS * term.sd));
        consider("stribeck", "--stribeck", 2.0, with);
    }
    if !model.is_asymmetric {
        let with = fit(MachineModel { is_asymmetric: true, ..model });
        consider("asymmetric", "--model asymmetric", 1.0, with);
    }
    all.sort_by(|a, b| a.residual_with.total_cmp(&b.residual_with));
    all
}

/// Returns whether a fit with `more` coefficients pays.
fn pays(before: &FittedModel, with: &FittedModel, more: f64, rows: f64) -> bool {
    let drop = rows * (before.fit.residual / with.fit.residual).ln() - more * rows.ln();
    let [one, other] = [before, with].map(FittedModel::relative_residual_percent);
    let explained = (one * one - other * other).max(0.0).sqrt();
    drop > DROP && other <= LEFT * one && explained >= LEAST_PERCENT
}
