//! Options that the commands of `stiction ensemble` share.

use clap::builder::TypedValueParser;

use files::error::Error;
use studies::ensemble::{Condition, Family};

/// Default sample rate, Hz.
pub(super) const RATE_HZ: f64 = 1000.0;

/// Returns the parser of the number of joints of a family.
pub(super) fn cases() -> impl TypedValueParser<Value = u64> {
    clap::value_parser!(u64).range(1..=1_000_000)
}

/// Checks the sample rate, Hz, against the range of the core's ticks and the device's timer.
pub(super) fn allowed_rate(rate_hz: f64) -> Result<f64, Error> {
    if (50.0..=10_000.0).contains(&rate_hz) {
        return Ok(rate_hz);
    }
    Err(Error::Input(format!("--rate {rate_hz}: must be a number from 50 to 10000")))
}

/// Returns the named families, each once.
pub(super) fn families(names: &[String]) -> Result<Vec<Family>, Error> {
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

/// Returns the named families under a condition. Of `all` it leaves out those that do not have it.
pub(super) fn families_under(names: &[String], condition: Condition) -> Result<Vec<Family>, Error> {
    let mut found = families(names)?;
    if names.iter().any(|name| name == "all") {
        found.retain(|family| condition.fits(*family));
    }
    match found.iter().find(|family| !condition.fits(**family)) {
        Some(family) => {
            let (name, of) = (condition.name(), family.name());
            Err(Error::Input(format!(
                "--condition {name} does not go with --plant {of}: a bristle has no such friction, \
                 and arms have no conditions"
            )))
        }
        None => Ok(found),
    }
}
