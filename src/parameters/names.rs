//! The names of configured values, for hosts: a device reports a value by its number alone.

use core::fmt;

use super::declarations;
use crate::control::laws;
use crate::motion;
use crate::units::error::{Allowed, InvalidValue};
use crate::units::key::Key;
use crate::units::value::About;

/// Returns the declaration of a value; none if the value is unknown to this version.
pub fn about(key: Key) -> Option<&'static About> {
    let key = laws::declared(motion::declared(key));
    declarations().find(|about| about.key == key)
}

/// The path of a value in a machine's file, as in `drive.lsb_v`: two tables may have the same key.
/// A number that is unknown to this version is printed as the number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValuePath(pub Key);

impl fmt::Display for ValuePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match about(self.0) {
            // A controller has a table of its own name.
            Some(about) if about.table == "controller" => {
                write!(f, "controller.NAME.{}", about.name)
            }
            Some(about) => write!(f, "{}.{}", about.table, about.name),
            None => write!(f, "value {:#06x}", self.0.0),
        }
    }
}

/// An error that prints the path of its value.
///
/// ```
/// use stiction::{control::pd::PdGains, parameters::names::NamedError, units::value::Values};
/// let error = PdGains { kp: f32::NAN, kd: 0.15 }.validate().unwrap_err();
/// let message = NamedError(error).to_string();
/// assert!(message.starts_with("`controller.NAME.kp_v_per_deg` is NaN; must be a number"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedError(pub InvalidValue);

impl fmt::Display for NamedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let InvalidValue { key, found, allowed } = self.0;
        write!(f, "`{}` is {found}; must be {}", ValuePath(key), NamedBounds(allowed))
    }
}

/// Bounds that print the path of a value that they depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedBounds(pub Allowed);

impl fmt::Display for NamedBounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Allowed::UpTo(high, key) => {
                write!(f, "a number above 0, up to `{}`, which is {high}", ValuePath(key))
            }
            Allowed::DueTo(high, key) => {
                write!(f, "a number above 0, up to {high}, because of `{}`", ValuePath(key))
            }
            Allowed::SetBy(only, key) => write!(f, "{only}, because of `{}`", ValuePath(key)),
            allowed => write!(f, "{allowed}"),
        }
    }
}
