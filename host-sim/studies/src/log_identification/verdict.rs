//! Verdict on an identification from a log.

use super::LogStatistics;
use super::cut_off::CutOff;
use super::free_run::FreeRun;
use super::implausible::Implausible;
use super::misfit::Misfit;
use super::model::{FittedModel, FittedParameter};
use super::proposal::Proposal;
use files::error::rounded;

/// Relative residuals, % of the effort: good up to the first, poor above the second. Published
/// identifications of robots and drives have 3 to 15 %.
const RESIDUAL_PERCENT: [f64; 2] = [5.0, 15.0];

/// Shares of the velocity's variance that a free run explains: good from the first on, poor below
/// the second.
const EXPLAINED: [f64; 2] = [0.9, 0.5];

/// Relative standard deviations of the inertia: good up to the first, poor above the second.
const INERTIA: [f64; 2] = [0.05, 0.3];

/// Ratio of a coefficient's uncertainty to that without the other columns, above which it cannot be
/// separated from others.
const MIXED_UP: f64 = 30.0;

/// Relative standard deviation of the Stribeck term above which the log does not identify it.
const UNKNOWN: f64 = 0.5;

/// Noise's share of the acceleration's power above which the verdict warns of a too small inertia.
const NOISY: f64 = 0.02;

/// Quality of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FitQuality {
    /// No objections.
    Good,
    /// Usable with care.
    Fair,
    /// Not usable.
    Poor,
}

impl FitQuality {
    /// Returns the word for the verdict.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }
}

/// Verdict on a fit, with reasons.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FitVerdict {
    /// Quality of the fit.
    pub quality: FitQuality,
    /// Findings for and against the fit, one sentence each.
    pub words: Vec<String>,
    /// Findings against the fit.
    pub doubts: Vec<String>,
}

/// Objections to a fit.
#[derive(Clone, Copy, Debug)]
pub struct Objections<'a> {
    /// Values outside the range of existing machines.
    pub implausible: &'a [Implausible],
    /// Causes of the residual that the model leaves out.
    pub misfits: &'a [Misfit],
    /// Terms that the fitted model lacks and that would lower its residual.
    pub proposals: &'a [Proposal],
}

/// Returns the verdict on a fit.
pub fn of(
    fitted: &FittedModel,
    parameters: &[(&'static str, FittedParameter)],
    free_run: &FreeRun,
    against: Objections<'_>,
    cut_off: &CutOff,
    read: &LogStatistics,
) -> FitVerdict {
    let Objections { implausible, misfits, proposals } = against;
    let mut verdict = FitVerdict { quality: FitQuality::Good, words: vec![], doubts: vec![] };
    for value in implausible {
        verdict.judge([false, !value.is_far], value.words.clone());
    }
    let residual = fitted.relative_residual_percent();
    verdict.judge(
        [residual <= RESIDUAL_PERCENT[0], residual <= RESIDUAL_PERCENT[1]],
        format!("the residual is {} % of the effort", rounded(residual)),
    );
    let explained = free_run.velocity_r2;
    verdict.judge(
        [explained >= EXPLAINED[0], explained >= EXPLAINED[1]],
        format!("the free run explains {} % of the velocity", rounded(100.0 * explained.max(0.0))),
    );
    let uncertain = |of: &FittedParameter| of.sd / of.value.abs();
    if let Some((_, inertia)) = parameters.first() {
        let part = uncertain(inertia);
        if part > INERTIA[0] {
            verdict.judge(
                [false, part <= INERTIA[1]],
                format!(
                    "the inertia is uncertain by {} %: the log accelerates too little, or the \
                     machine is not one rigid body",
                    rounded(100.0 * part)
                ),
            );
        }
    }
    let names = fitted.model.coefficients();
    for (name, inflation) in names.iter().zip(fitted.fit.inflation) {
        if inflation > MIXED_UP {
            verdict.judge(
                [false, true],
                format!(
                    "`{name}` cannot be separated from other parameters: log several speeds and \
                     accelerations"
                ),
            );
        }
    }
    let ways = |name: &str| fitted.get(name).map(|one| (one.value, one.sd));
    // A load can make the level of one way negative, but not the mean of both.
    let coulomb = fitted.coulomb();
    let mean = if fitted.model.is_asymmetric {
        "the mean of `coulomb_positive` and `coulomb_negative`"
    } else {
        "`coulomb`"
    };
    let named = ["viscous", "viscous_positive", "viscous_negative"]
        .into_iter()
        .filter_map(|name| Some((format!("`{name}`"), ways(name)?)));
    for (name, (value, sd)) in named.chain([(mean.to_owned(), (coulomb.value, coulomb.sd))]) {
        if value < -2.0 * sd {
            verdict.judge(
                [false, true],
                format!("{name} is negative, which is impossible for friction: terms are missing"),
            );
        }
    }
    if let Some((value, sd)) = ways("stribeck")
        && sd > UNKNOWN * value.abs()
    {
        let words = "the log hardly identifies the Stribeck term: log slower motions, or leave it \
                     out";
        verdict.judge([false, true], words.into());
    }
    for misfit in misfits {
        let part = rounded((100.0 * misfit.share).round());
        verdict.judge([false, true], format!("{} ({part} % of the residual)", misfit.words));
    }
    for proposal in proposals {
        verdict.judge([false, true], proposal.words());
    }
    if cut_off.noise > NOISY {
        verdict.judge(
            [false, cut_off.noise < 10.0 * NOISY],
            format!(
                "noise of the position makes the inertia up to {} % too small",
                rounded(100.0 * cut_off.noise)
            ),
        );
    }
    if misfits.is_empty() && proposals.is_empty() && residual > RESIDUAL_PERCENT[0] {
        let words = "the residual shows none of the causes that are tested; not tested are a noisy \
                     effort, a rattling backlash and a limiting drive";
        verdict.words.push(words.into());
    }
    if read.saturated > 0.01 {
        let part = rounded(100.0 * read.saturated);
        verdict.words.push(format!("{part} % of the samples are saturated and were left out"));
    }
    verdict
}

impl FitVerdict {
    fn judge(&mut self, [is_good, is_fair]: [bool; 2], words: String) {
        let quality = match (is_good, is_fair) {
            (true, _) => FitQuality::Good,
            (false, true) => FitQuality::Fair,
            (false, false) => FitQuality::Poor,
        };
        self.quality = self.quality.max(quality);
        if !is_good {
            self.doubts.push(words.clone());
        }
        self.words.push(words);
    }
}
