//! The supply of the bridge, too low (a cable, a fuse, a battery) or too high (a braking motor, a
//! wrong adapter).
//!
//! Three readings in a row trip the monitor: a single low reading may be the dip of a commutation.

use super::limits::{Limits, Units};
use crate::safety::fault::Fault;

/// Number of readings in a row that trip.
const READINGS: u8 = 3;

/// Monitor of the converter's readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Supply {
    lowest: u16,
    highest: u16,
}

/// Number of readings in a row outside the range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SupplyState {
    out: u8,
}

impl Supply {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let reading = |v: f32, off: u16| match units.supply {
            unit if unit > 0.0 && v > 0.0 => libm::roundf(v / unit) as u16,
            _ => off,
        };
        Self {
            lowest: reading(limits.supply_min, 0),
            highest: reading(limits.supply_max, u16::MAX),
        }
    }

    /// Returns the fault of a reading, if the reading is outside the range.
    #[inline]
    pub const fn is_out(&self, reading: u16) -> Option<Fault> {
        if reading < self.lowest {
            Some(Fault::SupplyLow)
        } else if reading > self.highest {
            Some(Fault::SupplyHigh)
        } else {
            None
        }
    }

    #[inline]
    pub const fn check(&self, state: &mut SupplyState, reading: u16) -> Option<Fault> {
        let out = self.is_out(reading);
        state.out = if out.is_some() { state.out.saturating_add(1) } else { 0 };
        if state.out >= READINGS { out } else { None }
    }
}
