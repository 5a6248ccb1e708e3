//! Reset integral (RI): an integrator that is active only near the target.
//!
//! Thesis eq. 29:
//!
//! ```text
//! v_c(t) = v_c(t - h) + Ki theta_e h    |theta_e| <= theta_ri
//!        = 0                            |theta_e| >  theta_ri
//! ```
//!
//! Why this form: a large step does not wind the integral up, since it starts within `theta_ri` of
//! the target. Guarantees: no mean error at constant velocity while the joint slips inside the
//! range; |v_c| never exceeds the full scale (a bound of ours: an integral beyond the largest
//! effort of the drive only delays its own unwinding). Does badly: with static friction above
//! dynamic it hunts around the target forever, for every `Ki` (Armstrong and Amin, *Automatica*
//! 32(5), 1996), with an amplitude that grows with their difference.

use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

table! {
    /// Gains of RI.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ResetIntegralGains (law) "controller" {
        /// Integral gain Ki, V/(deg s).
        ki: f32 = 0x1101 "ki_v_per_deg_s", Between(0.0, HUGE), Needed(4.0);
        /// Range of activity theta_ri, deg.
        theta_ri: f32 = 0x1102 "theta_ri_deg", Between(0.0, HUGE), Needed(0.5);
    }
}

/// The law RI, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResetIntegral {
    /// Ki h, V/deg.
    ki_h: f32,
    theta_ri: f32,
    full_scale: f32,
}

/// The integral of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResetIntegralState {
    v_c: f32,
}

impl Law for ResetIntegral {
    type Gains = ResetIntegralGains;
    type State = ResetIntegralState;

    fn new(gains: &ResetIntegralGains, around: &Loop) -> Self {
        Self {
            ki_h: gains.ki * around.sample_time,
            theta_ri: gains.theta_ri,
            full_scale: around.full_scale,
        }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{Law, LawInput, Loop, ResetIntegral, ResetIntegralGains};
    /// use stiction::control::laws::reset_integral::ResetIntegralState;
    /// let around = Loop { sample_time: 0.25, ..Loop::EXAMPLE };
    /// let law = ResetIntegral::new(&ResetIntegralGains { ki: 4.0, theta_ri: 0.5 }, &around);
    /// let mut state = ResetIntegralState::default();
    /// let near = LawInput { error: 0.5, ..LawInput::default() };
    /// assert_eq!(law.update(&mut state, &near), 0.5);
    /// assert_eq!(law.update(&mut state, &near), 1.0);
    /// assert_eq!(law.update(&mut state, &LawInput { error: 0.6, ..near }), 0.0);
    /// ```
    fn update(&self, state: &mut ResetIntegralState, input: &LawInput) -> f32 {
        state.v_c = if input.error.abs() <= self.theta_ri {
            saturate(state.v_c + self.ki_h * input.error, self.full_scale).0
        } else {
            0.0
        };
        state.v_c
    }
}
