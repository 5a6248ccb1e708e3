//! Errors of a configuration: the value that is refused, and the values that are allowed.

use core::fmt;

use crate::units::key::Key;

/// A configured value that is not allowed.
///
/// A device reports the number of the value. A host has the names as well:
/// [`parameters::names::NamedError`](crate::parameters::names::NamedError) prints the error with
/// the path of the value in a machine's file.
///
/// ```
/// use stiction::{control::pd::PdGains, units::value::Values};
/// let message = PdGains { kp: f32::NAN, kd: 0.15 }.validate().unwrap_err().to_string();
/// assert!(message.starts_with("value 0x0401 is NaN; must be a number"), "{message}");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvalidValue {
    /// The number of the value.
    pub key: Key,
    /// The value that was found, as a number.
    pub found: f32,
    /// The values that are allowed.
    pub allowed: Allowed,
}

/// The set of values that are allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "device", derive(serde::Serialize, serde::Deserialize))]
pub enum Allowed {
    /// The numbers from the first to the second; both belong to the set.
    Between(f32, f32),
    /// The numbers from the first to the second; the first does not belong to the set, the second
    /// does.
    Above(f32, f32),
    /// Every value of the type.
    Any,
    /// The times that are at least this much later than the previous corner's, s, so that blends do
    /// not overlap.
    LaterBy(f32),
    /// The laws that are not in the sum yet; no law beside one that replaces PD.
    AnotherLaw,
    /// The numbers from the first to the second, as [`Between`](Self::Between), where zero means
    /// off. A machine's file can also write zero as the word `"off"`.
    OrOff(f32, f32),
    /// The positive numbers up to the first, which is another configured value.
    UpTo(f32, Key),
    /// The positive numbers up to the first, which follows from another configured value.
    DueTo(f32, Key),
    /// One number, which follows from another configured value.
    SetBy(f32, Key),
}

impl Allowed {
    /// Returns whether a number belongs to the set; NaN belongs to no range. No number belongs to
    /// [`LaterBy`](Self::LaterBy), since times are compared where the corners are available, nor to
    /// [`AnotherLaw`](Self::AnotherLaw), which only reports a refused law.
    pub fn includes(self, found: f32) -> bool {
        match self {
            Self::Between(low, high) | Self::OrOff(low, high) => found >= low && found <= high,
            Self::Above(low, high) => found > low && found <= high,
            Self::UpTo(high, _) | Self::DueTo(high, _) => found > 0.0 && found <= high,
            Self::SetBy(only, _) => found == only,
            Self::Any => true,
            Self::LaterBy(_) | Self::AnotherLaw => false,
        }
    }
}

impl fmt::Display for InvalidValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "value {:#06x} is {}; must be {}", self.key.0, self.found, self.allowed)
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Between(low, high) => write!(f, "a number from {low} to {high}"),
            Self::Above(low, high) => write!(f, "a number above {low}, up to {high}"),
            Self::Any => f.write_str("anything"),
            Self::LaterBy(gap) => {
                write!(f, "a time at least {gap} s after the corner before (two half blends)")
            }
            Self::AnotherLaw => f.write_str("each law once, and none beside one that replaces PD"),
            Self::OrOff(low, high) => write!(f, "a number from {low} to {high}, or \"off\""),
            Self::UpTo(high, key) => {
                write!(f, "a number above 0, up to value {:#06x}, which is {high}", key.0)
            }
            Self::DueTo(high, key) => {
                write!(f, "a number above 0, up to {high}, because of value {:#06x}", key.0)
            }
            Self::SetBy(only, key) => write!(f, "{only}, because of value {:#06x}", key.0),
        }
    }
}

impl core::error::Error for InvalidValue {}

/// Bound of numbers that have no other bound: no gain, limit or length of a joint comes near it,
/// and its square is still finite in `f32`.
pub(crate) const HUGE: f32 = 1e6;

/// Refuses a number that is not in `[low, high]`; NaN is in no range.
pub(crate) fn between(key: Key, found: f32, low: f32, high: f32) -> Result<(), InvalidValue> {
    let allowed = Allowed::Between(low, high);
    if allowed.includes(found) { Ok(()) } else { Err(InvalidValue { key, found, allowed }) }
}

/// Refuses a number that is not in `(low, high]`; NaN is in no range.
pub(crate) fn above(key: Key, found: f32, low: f32, high: f32) -> Result<(), InvalidValue> {
    let allowed = Allowed::Above(low, high);
    if allowed.includes(found) { Ok(()) } else { Err(InvalidValue { key, found, allowed }) }
}
