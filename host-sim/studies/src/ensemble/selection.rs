//! Families, rate and number of joints, as options name them.

use std::ops::RangeInclusive;

use super::bridge::Bridge;
use super::condition::Condition;
use super::family::Family;
use files::error::Error;

/// Default sample rate, Hz.
pub const RATE_HZ: f64 = 1000.0;

/// Allowed number of joints of a family.
pub const CASES_ALLOWED: RangeInclusive<u64> = 1..=1_000_000;

/// Checks the sample rate, Hz, against the range of the core's ticks and the device's timer.
///
/// # Errors
/// Returns an error with the allowed range.
pub fn allowed_rate(rate_hz: f64) -> Result<f64, Error> {
    if (50.0..=10_000.0).contains(&rate_hz) {
        return Ok(rate_hz);
    }
    Err(Error::Input(format!("--rate {rate_hz}: must be a number from 50 to 10000")))
}

/// Returns the named families, each once; `all` stands for the usual ones.
///
/// # Errors
/// Returns an error with a name that no family has.
pub fn families(names: &[String]) -> Result<Vec<Family>, Error> {
    let mut families: Vec<Family> = Vec::new();
    for name in names {
        let named = if name == "all" { Family::USUAL.to_vec() } else { vec![Family::named(name)?] };
        for family in named {
            if !families.contains(&family) {
                families.push(family);
            }
        }
    }
    Ok(families)
}

/// Returns the named families under a condition and with a bridge. If `all` is among the names,
/// families that either does not fit are left out.
///
/// # Errors
/// Returns an error with a name that no family has, or with a family that lacks the condition or
/// the bridge.
pub fn families_under(
    names: &[String],
    condition: Condition,
    bridge: Bridge,
) -> Result<Vec<Family>, Error> {
    let mut found = families(names)?;
    if names.iter().any(|name| name == "all") {
        found.retain(|family| condition.fits(*family) && bridge.fits(*family));
    }
    if let Some(family) = found.iter().find(|family| !bridge.fits(**family)) {
        let (name, of) = (bridge.name(), family.name());
        return Err(Error::Input(format!(
            "--bridge {name} does not go with --plant {of}: the motors of an arm have no electrics"
        )));
    }
    if condition == Condition::SamplingJitter && bridge == Bridge::Current {
        return Err(Error::Input(
            "--bridge current does not go with --condition sampling-jitter: a current loop is in \
             step with the ticks"
                .into(),
        ));
    }
    match found.iter().find(|family| !condition.fits(**family)) {
        Some(family) => {
            let (name, of) = (condition.name(), family.name());
            Err(Error::Input(format!(
                "--condition {name} does not go with --plant {of}: arms have no conditions, and \
                 LuGre friction has no drift, dwell or unevenness"
            )))
        }
        None => Ok(found),
    }
}
