//! Reset offset integral (ROI): adds the PD loop's own output as an offset, step by step.
//!
//! Thesis eq. 31:
//!
//! ```text
//! v_c(t) = v_c(t - T_roi) + v_PD    while |theta_d' - theta_a'| < V_roi,
//!                                   once each time T_roi has elapsed
//!        = 0                        otherwise
//! ```
//!
//! As it is printed, eq. 31 could also be read as a running delay. The text settles it: "the timer
//! loop delays incrementing the compensation control signal until the desired time has elapsed"
//! (section 3.1.3), and Fig. 32b shows steps. The comparison is strict, after "smaller than a
//! certain value, V_roi". So the offset is held, and grows by one v_PD each `T_roi`, which is
//! rounded to whole samples.
//!
//! Why this form: the output of PD after the joint has come to rest is a measure of the missing
//! effort. Guarantees: no mean error at constant velocity; the offset is dropped as soon as the
//! velocity error is large, so it does not wind up in a transient; |v_c| never exceeds the full
//! scale. `V_roi = 0` switches the law off. Does badly: at rest it is a slow integrator, and hunts
//! by a few counts.

use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

table! {
    /// Gains of ROI.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ResetOffsetIntegralGains (law) "controller" {
        /// Time between increments T_roi, s. Less than a sample counts as one sample.
        t_roi: f32 = 0x1301 "t_roi_s", Between(0.0, HUGE), Needed(0.14);
        /// Velocity error below which it is active V_roi, deg/s.
        v_roi: f32 = 0x1302 "v_roi_deg_per_s", Between(0.0, HUGE), Needed(2.33);
    }
}

/// The law ROI, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResetOffsetIntegral {
    /// Time between increments T_roi, ticks, at least one.
    period: u32,
    v_roi: f32,
    full_scale: f32,
}

/// The offset of the law and its timer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResetOffsetIntegralState {
    v_c: f32,
    /// Ticks since the last increment, or since activity began.
    elapsed: u32,
}

impl Law for ResetOffsetIntegral {
    type Gains = ResetOffsetIntegralGains;
    type State = ResetOffsetIntegralState;

    fn new(gains: &ResetOffsetIntegralGains, around: &Loop) -> Self {
        let period = libm::roundf(gains.t_roi / around.sample_time) as u32;
        Self { period: period.max(1), v_roi: gains.v_roi, full_scale: around.full_scale }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{Law, LawInput, Loop};
    /// use stiction::control::laws::{ResetOffsetIntegral, ResetOffsetIntegralGains};
    /// use stiction::control::laws::reset_offset_integral::ResetOffsetIntegralState;
    /// let around = Loop::EXAMPLE;
    /// let gains = ResetOffsetIntegralGains { t_roi: 0.04, v_roi: 2.33 };
    /// let law = ResetOffsetIntegral::new(&gains, &around);
    /// let mut state = ResetOffsetIntegralState::default();
    /// let input = LawInput { v_pd: 0.25, ..LawInput::default() };
    /// let v_c = [(); 6].map(|()| law.update(&mut state, &input));
    /// assert_eq!(v_c, [0.0, 0.0, 0.25, 0.25, 0.5, 0.5]);
    /// assert_eq!(law.update(&mut state, &LawInput { velocity_error: 2.4, ..input }), 0.0);
    /// ```
    fn update(&self, state: &mut ResetOffsetIntegralState, input: &LawInput) -> f32 {
        if input.velocity_error.abs() < self.v_roi {
            // Not only equal: the state can be that of a longer period.
            if state.elapsed >= self.period {
                state.v_c = saturate(state.v_c + input.v_pd, self.full_scale).0;
                state.elapsed = 0;
            }
            state.elapsed += 1;
        } else {
            *state = ResetOffsetIntegralState::default();
        }
        state.v_c
    }
}
