//! Claims of the thesis, our measurements, and the verdicts.
//!
//! A claim names its source, a quantity, how that is measured in the runs of the report and a
//! criterion. The verdict follows from the measurement alone.

mod chapter2;
mod chapter3;
mod compensators;
mod details;
mod friction;
mod nonlinear;
mod precision;

use serde::Serialize;

use super::evidence::ReportEvidence;

/// A claim of the thesis.
pub struct Claim {
    /// Section, figure or table of the thesis.
    pub source: &'static str,
    /// The claim, in our words or quoted.
    pub says: &'static str,
    /// What is measured, with its unit.
    pub quantity: &'static str,
    /// The measurement, one value or several; nothing if a run is missing.
    pub measure: fn(&ReportEvidence) -> Option<Vec<f64>>,
    /// Criterion that a value meets if it supports the claim.
    pub holds: Criterion,
    /// Why the claim does not hold, or in what sense it does.
    pub remark: &'static str,
}

/// Criterion of a value that supports a claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// It is larger.
    Above(f64),
    /// It is smaller.
    Below(f64),
    /// It is in between, or equal to a bound.
    Between(f64, f64),
}

/// Verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimVerdict {
    /// Every value supports it.
    Holds,
    /// Some values do.
    InPart,
    /// No value does.
    Fails,
    /// There is no value.
    NotMeasured,
}

impl Criterion {
    /// Returns whether a value supports the claim; NaN never does.
    pub fn met(self, value: f64) -> bool {
        match self {
            Self::Above(least) => value > least,
            Self::Below(most) => value < most,
            Self::Between(least, most) => (least..=most).contains(&value),
        }
    }

    /// Returns the verdict of all values.
    pub fn verdict(self, values: &[f64]) -> ClaimVerdict {
        let met = values.iter().filter(|value| self.met(**value)).count();
        match met {
            _ if values.is_empty() => ClaimVerdict::NotMeasured,
            0 => ClaimVerdict::Fails,
            met if met == values.len() => ClaimVerdict::Holds,
            _ => ClaimVerdict::InPart,
        }
    }
}

impl Claim {
    /// The values, none if a run is missing, and the verdict.
    pub fn judge(&self, evidence: &ReportEvidence) -> (Vec<f64>, ClaimVerdict) {
        let values = (self.measure)(evidence).unwrap_or_default();
        let verdict = self.holds.verdict(&values);
        (values, verdict)
    }
}

/// A part of the table.
pub struct Section {
    /// Its heading.
    pub title: &'static str,
    /// Its claims.
    pub claims: &'static [Claim],
}

/// All claims, in the thesis's order.
pub const SECTIONS: &[Section] = &[
    Section { title: "Chapter 2: friction models", claims: chapter2::CLAIMS },
    Section { title: "Chapter 2: the models in detail, and Appendix A.1", claims: details::CLAIMS },
    Section { title: "Chapter 3: the robot's axis and PD", claims: chapter3::AXIS },
    Section { title: "Chapter 3: integrals", claims: compensators::INTEGRALS },
    Section { title: "Chapter 3: feedforward, DNPF and SRNF", claims: nonlinear::CLAIMS },
    Section { title: "Appendix A.2 and conclusions", claims: chapter3::CONCLUSIONS },
];

/// Each value by its counterpart.
fn ratios(values: Option<Vec<f64>>, by: Option<Vec<f64>>) -> Option<Vec<f64>> {
    Some(values?.into_iter().zip(by?).map(|(value, by)| value / by).collect())
}

/// Their magnitudes.
fn magnitudes(values: Option<Vec<f64>>) -> Option<Vec<f64>> {
    Some(values?.into_iter().map(f64::abs).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_follows_the_measurement_over_each_bound() {
        assert_eq!(Criterion::Above(2.0).verdict(&[2.1, 3.0]), ClaimVerdict::Holds);
        assert_eq!(Criterion::Above(2.0).verdict(&[2.0, 3.0]), ClaimVerdict::InPart);
        assert_eq!(Criterion::Above(2.0).verdict(&[1.9, 2.0]), ClaimVerdict::Fails);
        assert_eq!(Criterion::Below(2.0).verdict(&[1.9]), ClaimVerdict::Holds);
        assert_eq!(Criterion::Below(2.0).verdict(&[2.0]), ClaimVerdict::Fails);
        assert_eq!(Criterion::Between(1.0, 2.0).verdict(&[1.0, 2.0]), ClaimVerdict::Holds);
        assert_eq!(Criterion::Between(1.0, 2.0).verdict(&[0.9, 2.1]), ClaimVerdict::Fails);
        assert_eq!(Criterion::Below(2.0).verdict(&[f64::NAN]), ClaimVerdict::Fails);
        assert_eq!(Criterion::Below(2.0).verdict(&[]), ClaimVerdict::NotMeasured);
    }

    #[test]
    fn a_bound_of_every_claim_can_be_missed() {
        for claim in SECTIONS.iter().flat_map(|section| section.claims) {
            let (inside, outside) = match claim.holds {
                Criterion::Above(bound) => (bound + 1.0, bound - 1.0),
                Criterion::Below(bound) => (bound - 1.0, bound + 1.0),
                Criterion::Between(least, most) => (0.5 * (least + most), most + 1.0),
            };
            assert_eq!(claim.holds.verdict(&[inside]), ClaimVerdict::Holds, "{}", claim.says);
            assert_eq!(claim.holds.verdict(&[outside]), ClaimVerdict::Fails, "{}", claim.says);
        }
    }
}
