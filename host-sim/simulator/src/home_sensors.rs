//! Homing switch and encoder index of a simulated joint.
//!
//! The switch is at an angle of the joint: the joint is at it from there on, away from where it is
//! at power-on. Its contact is as `device.home_switch` of the file says, with the pull-up of the
//! board's input. Limits: it neither bounces nor has a hysteresis, and its edge is exact.
//!
//! The index is on the disc of the encoder whose counter the board captures: of two, that of the
//! motor. It is high for `index_width_counts` counts in every turn of the disc, from a quarter of a
//! turn behind the place of power-on on. The turn has four times `encoder.lines` counts, or
//! `device.index_counts` without a data sheet.

use stiction::control::device_config::HomeSwitch;
use stiction::servo::Input;

/// A homing switch with its wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwitchModel {
    /// Position of its edge, deg; `None`: the joint never comes to the switch.
    pub edge_deg: Option<f64>,
    /// Its contact.
    pub contact: HomeSwitch,
    /// Whether its wire is cut.
    pub is_cut: bool,
}

impl SwitchModel {
    /// Returns whether a joint in this position is at the switch.
    fn is_at(&self, position_deg: f64) -> bool {
        self.edge_deg.is_some_and(|edge_deg| {
            if edge_deg < 0.0 { position_deg <= edge_deg } else { position_deg >= edge_deg }
        })
    }

    /// Returns whether the input is high while the joint is in this position.
    pub fn is_high(&self, position_deg: f64) -> bool {
        let is_closed = match self.contact {
            HomeSwitch::None => false,
            HomeSwitch::NormallyClosed => !self.is_at(position_deg),
            HomeSwitch::NormallyOpen => self.is_at(position_deg),
        };
        self.is_cut || !is_closed
    }

    /// Returns the bit of the input in [`Input::lines`].
    pub fn line(&self, position_deg: f64) -> u8 {
        if self.is_high(position_deg) { Input::SWITCH } else { 0 }
    }
}

/// An index on the disc of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexModel {
    /// Counts of a turn of the disc.
    pub every: i64,
    /// First count of the index, in the direction of the counter.
    pub first: i64,
    /// Width of the index, counts.
    pub width: i64,
}

impl IndexModel {
    /// Returns whether the index is high at a count of the disc.
    pub const fn is_high(&self, count: i64) -> bool {
        (count - self.first).rem_euclid(self.every) < self.width
    }

    /// Returns the last count on the way of the disc at which the index has risen; `None` if it has
    /// not.
    pub const fn rise(&self, from: i64, to: i64) -> Option<i64> {
        if to > from {
            let beyond = (to - self.first).rem_euclid(self.every);
            let rise = to - beyond;
            return if rise > from { Some(rise) } else { None };
        }
        let beyond = (self.first + self.width - 1 - to).rem_euclid(self.every);
        let rise = to + beyond;
        if rise < from { Some(rise) } else { None }
    }
}
