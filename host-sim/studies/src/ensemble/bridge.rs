//! What the bridge of a joint makes of an effort. [`electrics`](super::electrics) simulates it.

use serde::{Deserialize, Serialize};

use super::family::Family;
use files::setup::name_of;

/// What the bridge of a joint makes of an effort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
pub enum Bridge {
    /// A torque: the amplifier is ideal, and the back-EMF is a part of the viscous friction.
    #[default]
    Ideal,
    /// The voltage of a motor with electrics.
    Voltage,
    /// The current of a motor with electrics, by a current loop.
    Current,
}

impl Bridge {
    /// Returns the name in options and reports.
    pub fn name(self) -> String {
        name_of(&self)
    }

    /// Returns whether the joints of a family can have it.
    pub const fn fits(self, family: Family) -> bool {
        matches!(self, Self::Ideal) || !family.is_arm()
    }

    /// Returns the suffix that tables append to the name of a family; empty for `Ideal`.
    pub(super) fn suffix(self) -> String {
        match self {
            Self::Ideal => String::new(),
            Self::Voltage | Self::Current => format!(", {} bridge", self.name()),
        }
    }
}

/// The electrics of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electrics {
    /// What the bridge makes of an effort.
    pub bridge: Bridge,
    /// Time constant L/R of the configured winding, s.
    pub lag_s: f64,
    /// Damping by the back-EMF with the configured resistance, in the units of the joint.
    pub damping: f64,
}
