//! Why a configuration was refused.

use core::fmt;

use serde::{Deserialize, Serialize};

/// A configuration value that is not allowed.
///
/// `key` is the name that the value has in a machine's TOML file, so that the message can be shown to a person
/// as it stands.
///
/// ```
/// use stiction::pd::PdGains;
/// let error = PdGains { kp: f32::NAN, kd: 0.15 }.validate().unwrap_err();
/// assert_eq!(error.to_string(), "`kp_v_per_deg` is NaN; allowed is a number from 0 to 1000000");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Error {
    /// The key in the machine's TOML file.
    pub key: &'static str,
    /// The value that was found.
    pub found: f32,
    /// The values that would have been taken.
    pub allowed: Allowed,
}

/// The set of values that a key may have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Allowed {
    /// Both ends belong to it.
    Between(f32, f32),
    /// The lower end does not belong to it, the upper one does.
    Above(f32, f32),
    /// Whole even numbers, both ends included.
    EvenBetween(f32, f32),
    /// Later than the corner before by at least this many seconds, so that blends do not overlap.
    LaterBy(f32),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is {}; allowed is ", self.key, self.found)?;
        match self.allowed {
            Allowed::Between(low, high) => write!(f, "a number from {low} to {high}"),
            Allowed::Above(low, high) => write!(f, "a number above {low}, up to {high}"),
            Allowed::EvenBetween(low, high) => write!(f, "an even number from {low} to {high}"),
            Allowed::LaterBy(gap) => {
                write!(f, "a time at least {gap} s after the corner before (two half blends)")
            }
        }
    }
}

impl core::error::Error for Error {}

/// No gain, limit or length of a joint comes near it, and its square is still finite in `f32`.
pub(crate) const HUGE: f32 = 1e6;

/// Refuses what is not in `[low, high]`; NaN is in no range.
pub(crate) fn between(key: &'static str, found: f32, low: f32, high: f32) -> Result<(), Error> {
    if found >= low && found <= high {
        Ok(())
    } else {
        Err(Error { key, found, allowed: Allowed::Between(low, high) })
    }
}

/// Refuses what is not in `(low, high]`; NaN is in no range.
pub(crate) fn above(key: &'static str, found: f32, low: f32, high: f32) -> Result<(), Error> {
    if found > low && found <= high {
        Ok(())
    } else {
        Err(Error { key, found, allowed: Allowed::Above(low, high) })
    }
}
