//! Homing switch and encoder index of a simulated joint.
//!
//! ```text
//! edge_deg > 0, hysteresis h, bounce b:
//! position  ------------------------> edge_deg ----   at the switch from edge_deg on
//!           <--- edge_deg - h --------------------    away from it from edge_deg - h on
//! level     ________|~|_|~|_|~~~~~~~~~~~~~~~~~~~~~    after a change, it alternates from sample to
//!                   |<-- b -->|                       sample for the time b
//! ```
//!
//! The switch is at an angle of the joint: the joint is at it from there on, away from where it is
//! at power-on. Its contact is as `device.home_switch` of the file says, with the pull-up of the
//! board's input. Limits: its edges are exact but for the hysteresis, and its level is that of the
//! last sample.
//!
//! The index is on the disc of the encoder whose counter the board captures: of two, that of the
//! motor. It is high for `index_width_counts` counts in every turn of the disc, from a quarter of a
//! turn behind the place of power-on on. The turn has four times `encoder.lines` counts, or
//! `device.index_counts` without a data sheet. Its edge captures the counter after the lag
//! `encoder.index_lag_us`: at the speed v, v times the lag farther in the sense of the motion.

use stiction::control::device_config::HomeSwitch;
use stiction::servo::Input;

/// A homing switch with its wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwitchModel {
    /// Position of its edge, deg; `None`: the joint never comes to the switch.
    pub edge_deg: Option<f64>,
    /// Angle by which the joint has to go back from the edge to leave the switch, deg.
    pub hysteresis_deg: f64,
    /// Time for which the contact bounces after a change, s.
    pub bounce_s: f64,
    /// Its contact.
    pub contact: HomeSwitch,
    /// Whether its wire is cut.
    pub is_cut: bool,
    /// Whether the joint is at the switch; `None` before the first sample.
    is_at: Option<bool>,
    /// Time of the last change, s.
    changed_s: f64,
    /// Whether the contact shows the other level in this sample.
    is_off: bool,
}

impl SwitchModel {
    /// Returns a switch without hysteresis and bounces.
    pub const fn new(contact: HomeSwitch, edge_deg: Option<f64>) -> Self {
        Self {
            edge_deg,
            hysteresis_deg: 0.0,
            bounce_s: 0.0,
            contact,
            is_cut: false,
            is_at: None,
            changed_s: f64::NEG_INFINITY,
            is_off: false,
        }
    }

    /// Returns whether a joint in this position is at the switch.
    fn is_at(&self, position_deg: f64) -> bool {
        let width_deg = if self.is_at == Some(true) { self.hysteresis_deg } else { 0.0 };
        self.edge_deg.is_some_and(|edge_deg| {
            if edge_deg < 0.0 {
                position_deg <= edge_deg + width_deg
            } else {
                position_deg >= edge_deg - width_deg
            }
        })
    }

    /// Samples the switch at a time, s, with the joint in this position. Returns whether the input
    /// is high.
    pub fn is_high(&mut self, position_deg: f64, at_s: f64) -> bool {
        let is_at = self.is_at(position_deg);
        if self.is_at.replace(is_at).is_some_and(|before| before != is_at) {
            // The first sample has the new level.
            (self.changed_s, self.is_off) = (at_s, true);
        }
        let bounces = (0.0..self.bounce_s).contains(&(at_s - self.changed_s));
        self.is_off = bounces && !self.is_off;
        let is_closed = match self.contact {
            HomeSwitch::None => false,
            HomeSwitch::NormallyClosed => is_at == self.is_off,
            HomeSwitch::NormallyOpen => is_at != self.is_off,
        };
        self.is_cut || !is_closed
    }

    /// Samples the switch, and returns the bit of the input in [`Input::lines`].
    pub fn line(&mut self, position_deg: f64, at_s: f64) -> u8 {
        if self.is_high(position_deg, at_s) { Input::SWITCH } else { 0 }
    }
}

/// An index on the disc of an encoder, with the lag of its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndexModel {
    /// Counts of a turn of the disc.
    pub every: i64,
    /// First count of the index, in the direction of the counter.
    pub first: i64,
    /// Width of the index, counts.
    pub width: i64,
    /// Time from the edge of the index to the capture of the counter, s.
    pub lag_s: f64,
    /// Rest of the lag of an edge before this tick, s.
    pending_s: Option<f64>,
}

impl IndexModel {
    /// Returns an index without a lag, a quarter of a turn behind the place of power-on.
    pub const fn new(every: i64, width: i64) -> Self {
        Self { every, first: every / 4, width, lag_s: 0.0, pending_s: None }
    }

    /// Returns the count of the disc at which the counter is captured in a tick, in which the disc
    /// goes evenly from one count to another; `None` if it is not captured. Of two captures, that
    /// is the last one.
    pub fn capture(&mut self, from: i64, to: i64, tick_s: f64) -> Option<i64> {
        let counts_per_s = (to - from) as f64 / tick_s;
        // The counter has passed whole counts only.
        let behind = |count: i64, lag_s: f64| count + (counts_per_s * lag_s) as i64;
        let mut captured = None;
        if let Some(left_s) = self.pending_s.take() {
            if left_s <= tick_s {
                captured = Some(behind(from, left_s));
            } else {
                self.pending_s = Some(left_s - tick_s);
            }
        }
        if let Some(rise) = self.rise(from, to) {
            let left_s = tick_s - (rise - from) as f64 / counts_per_s;
            if self.lag_s <= left_s {
                captured = Some(behind(rise, self.lag_s));
            } else {
                self.pending_s = Some(self.lag_s - left_s);
            }
        }
        captured
    }

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
