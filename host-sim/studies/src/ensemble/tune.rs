//! The constants of the rules, tried on joints that do not score.

use std::sync::{Mutex, PoisonError};

use super::rows::Header;
use super::rules::Rule;
use super::run::{Ensemble, run_with};
use super::summary::{Summary, summaries};
use crate::error::Error;

/// A constant and what the law comes to with it, on each family.
#[derive(Clone, Debug)]
pub struct Tried {
    /// Name of the law.
    pub law: &'static str,
    /// The constant.
    pub constant: f64,
    /// Name of the family, and the summary there.
    pub families: Vec<(String, Summary)>,
}

/// Runs each constant that was tried for the rules of an ensemble.
///
/// # Errors
/// If the core refuses gains.
pub fn tune(ensemble: &Ensemble) -> Result<Vec<Tried>, Error> {
    let mut all = Vec::new();
    for rule in &ensemble.rules {
        let Rule { law, constant, tried, .. } = rule;
        let constants = if tried.is_empty() { std::slice::from_ref(constant) } else { tried };
        for constant in constants {
            all.push(try_constant(ensemble, rule, law, *constant)?);
        }
    }
    Ok(all)
}

fn try_constant(
    ensemble: &Ensemble,
    rule: &'static Rule,
    law: &'static str,
    constant: f64,
) -> Result<Tried, Error> {
    let of_rule = Ensemble { rules: vec![rule], ..ensemble.clone() };
    let rows = Mutex::new(Vec::new());
    run_with(
        &of_rule,
        |rule, told| (rule.tune)(told, constant),
        |_, _, _| true,
        |row| {
            rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
            Ok(())
        },
    )?;
    let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let families = summaries(&Header::of(&of_rule), &rows).into_iter();
    let families = families.filter_map(|(group, mut laws)| Some((group.name, laws.pop()?)));
    Ok(Tried { law, constant, families: families.collect() })
}
