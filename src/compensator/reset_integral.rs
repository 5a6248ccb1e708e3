//! Reset integral (RI): an integrator that is active only near the target.
//!
//! Thesis eq. 29:
//!
//! ```text
//! v_c(t) = v_c(t - h) + Ki theta_e h    |theta_e| <= theta_ri
//!        = 0                            |theta_e| >  theta_ri
//! ```
//!
//! Why this form: a large step does not wind the integral up, since it starts within `theta_ri` of the target.
//! Guarantees: no mean error at constant velocity while the joint slips inside the range; |v_c| never exceeds the full scale (a
//! bound of ours: an integral that asks for more than the drive can give only delays its own unwinding).
//! Does badly: with static friction above dynamic it hunts around the target for ever, for every `Ki`
//! (Armstrong and Amin, *Automatica* 32(5), 1996), with an amplitude that grows with their difference.

use super::{Loop, Sample};
use crate::error::{Error, HUGE, between};
use crate::saturation::saturate;
use serde::{Deserialize, Serialize};

/// Gains of RI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResetIntegralGains {
    /// Integral gain Ki, V/(deg s).
    pub ki: f32,
    /// Range of activity theta_ri, deg.
    pub theta_ri: f32,
}

impl ResetIntegralGains {
    /// Refuses gains that are negative or not finite.
    ///
    /// # Errors
    /// Names the gain.
    pub fn validate(&self) -> Result<(), Error> {
        between("ki_v_per_deg_s", self.ki, 0.0, HUGE)?;
        between("theta_ri_deg", self.theta_ri, 0.0, HUGE)
    }
}

/// RI for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResetIntegral {
    /// Ki h, V/deg.
    ki_h: f32,
    theta_ri: f32,
    full_scale: f32,
}

/// The integral.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    v_c: f32,
}

impl State {
    /// Nothing integrated.
    pub const REST: Self = Self { v_c: 0.0 };
}

impl ResetIntegral {
    /// Validates and prepares the law.
    ///
    /// # Errors
    /// Names the gain.
    pub fn new(gains: &ResetIntegralGains, around: &Loop) -> Result<Self, Error> {
        gains.validate()?;
        Ok(Self {
            ki_h: gains.ki * around.sample_time,
            theta_ri: gains.theta_ri,
            full_scale: around.full_scale,
        })
    }

    /// v_c for one sample, V.
    ///
    /// ```
    /// use stiction::compensator::{Loop, ResetIntegral, ResetIntegralGains, Sample, reset_integral::State};
    /// let around = Loop { sample_time: 0.25, full_scale: 5.0, kp: 1.0 };
    /// let law = ResetIntegral::new(&ResetIntegralGains { ki: 4.0, theta_ri: 0.5 }, &around).unwrap();
    /// let mut state = State::default();
    /// let near = Sample { error: 0.5, ..Sample::default() };
    /// assert_eq!(law.update(&mut state, &near), 0.5);
    /// assert_eq!(law.update(&mut state, &near), 1.0);
    /// assert_eq!(law.update(&mut state, &Sample { error: 0.6, ..near }), 0.0);
    /// ```
    pub fn update(&self, state: &mut State, sample: &Sample) -> f32 {
        state.v_c = if sample.error.abs() <= self.theta_ri {
            saturate(state.v_c + self.ki_h * sample.error, self.full_scale).0
        } else {
            0.0
        };
        state.v_c
    }
}
