//! Hidden wind-up: at standstill the compensator holds effort that moves nothing, and that the
//! motor turns into heat.
//!
//! A warning, not a fault: an integral that waits for the joint to break away is doing its work.

use super::limits::{Limits, Units};

/// Monitor of the compensator's effort at standstill.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindUp {
    v_c: f32,
    ticks: u32,
}

impl WindUp {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let v_c = if limits.wind_up_effort > 0.0 { limits.wind_up_effort } else { f32::INFINITY };
        Self { v_c, ticks: Units::whole(limits.wind_up_time, units.tick) }
    }

    #[inline]
    pub fn check(&self, state: &mut u32, v_c: f32, standstill: u32) -> bool {
        *state = if v_c.abs() >= self.v_c { state.saturating_add(1) } else { 0 };
        (*state).min(standstill) >= self.ticks
    }
}
