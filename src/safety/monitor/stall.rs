//! Effort beyond any friction, and the encoder does not count.
//!
//! Trips when, for the configured time, the effort has had one sign and at least the size of the
//! threshold, and the joint has stood still ([`super::Standstill`]). Under PD a joint may rest
//! forever with effort applied, so the threshold lies above the breakaway effort: by default twice
//! that. This monitor cannot distinguish a blocked joint, a cut encoder wire (one or both), a motor
//! that is not connected and a bridge that does not drive.
//!
//! Does badly: a cut wire under less effort than the threshold looks like rest.

use super::limits::{Limits, Units};

/// Monitor of effort without motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stall {
    code: i32,
    ticks: u32,
}

/// Ticks for which the effort has been beyond the threshold, and its sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StallState {
    positive: bool,
    ticks: u32,
}

impl Stall {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let code = Units::threshold(limits.stall_effort, units.code);
        Self {
            code: i32::try_from(code).unwrap_or(i32::MAX),
            ticks: Units::whole(limits.stall_time, units.tick),
        }
    }

    #[inline]
    pub fn check(&self, state: &mut StallState, code: i32, standstill: u32) -> bool {
        if code.abs() < self.code {
            state.ticks = 0;
            return false;
        }
        if state.positive != (code > 0) {
            *state = StallState { positive: code > 0, ticks: 0 };
        }
        state.ticks = state.ticks.saturating_add(1);
        state.ticks.min(standstill) >= self.ticks
    }
}
