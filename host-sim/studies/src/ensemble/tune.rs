//! Trials of the rules' constants, on joints that do not score.

use std::sync::{Mutex, PoisonError};

use super::rows::EnsembleHeader;
use super::run::{Ensemble, run_with};
use super::summary::{LawSummary, summaries};
use files::error::Error;
use simulator::progress::Progress;
use simulator::rules::GainRule;

/// Results of a law with one constant of its rule, on each family.
#[derive(Clone, Debug)]
pub struct ConstantTrial {
    /// Name of the law.
    pub law: &'static str,
    /// The constant.
    pub constant: f64,
    /// Name of each family, and the summary of the law there.
    pub families: Vec<(String, LawSummary)>,
}

/// Runs an ensemble with each listed constant of its rules.
///
/// # Errors
/// If the core refuses gains, or `progress` ends the work.
pub fn tune(ensemble: &Ensemble, progress: &impl Progress) -> Result<Vec<ConstantTrial>, Error> {
    let mut all = Vec::new();
    for rule in &ensemble.rules {
        let GainRule { law, constant, tried, .. } = rule;
        let constants = if tried.is_empty() { std::slice::from_ref(constant) } else { tried };
        for constant in constants {
            all.push(try_constant(ensemble, progress, rule, law, *constant)?);
        }
    }
    Ok(all)
}

fn try_constant(
    ensemble: &Ensemble,
    progress: &impl Progress,
    rule: &'static GainRule,
    law: &'static str,
    constant: f64,
) -> Result<ConstantTrial, Error> {
    let of_rule = Ensemble { rules: vec![rule], ..ensemble.clone() };
    let rows = Mutex::new(Vec::new());
    run_with(
        &of_rule,
        progress,
        |rule, bounds| (rule.gains_with)(bounds, constant),
        |_, _, _| true,
        |row| {
            rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
            Ok(())
        },
    )?;
    let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let families = summaries(&EnsembleHeader::of(&of_rule), &rows).into_iter();
    let families = families.filter_map(|(group, mut laws)| Some((group.name, laws.pop()?)));
    Ok(ConstantTrial { law, constant, families: families.collect() })
}
