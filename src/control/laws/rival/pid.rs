//! PID: an integral of the error beside PD, which stops at the drive's limits.
//!
//! ```text
//! v_c(t) = v_c(t - h) + Ki theta_e h  unless the drive limits the effort, and theta_e has its sign
//!        = v_c(t - h)                 otherwise
//! ```
//!
//! The second line is the anti-windup: conditional integration (Astrom and Hagglund, *PID
//! Controllers*, 2nd ed., 1995, section 3.5). While the drive applies less than requested, an error
//! that would increase the request is not integrated. An error that reduces it is integrated, so
//! the integral leaves the limit automatically. A back-calculation would need one more time
//! constant, and does the same on a joint that is at its limit for tenths of a second.
//!
//! Why this form: it is what most drives have, and so the law that any other has to beat.
//! Guarantees: |v_c| never exceeds the full scale; no constant load leaves an error at rest, if the
//! joint comes to rest at all. Does badly: with static friction above dynamic it hunts around the
//! target forever, for every `Ki` (Armstrong and Amin, *Automatica* 32(5), 1996). It seems to
//! settle where the hunting stays within the band, or where a count hides it.

use crate::control::laws::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

table! {
    /// Gains of the integral of PID.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct PidGains (law) "controller" {
        /// Integral gain Ki, V/(deg s).
        ki: f32 = 0x3001 "ki_v_per_deg_s", Between(0.0, HUGE), Needed(1.0);
    }
}

/// The integral of PID, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid {
    /// Ki h, V/deg.
    ki_h: f32,
    full_scale: f32,
}

/// The integral of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PidState {
    v_c: f32,
}

impl Law for Pid {
    type Gains = PidGains;
    type State = PidState;

    const ON_THE_DEVICE: bool = false;

    fn new(gains: &PidGains, around: &Loop) -> Self {
        Self { ki_h: gains.ki * around.sample_time, full_scale: around.full_scale }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::rival::pid::PidState;
    /// use stiction::control::laws::{Law, LawInput, Loop, Pid, PidGains};
    /// let around = Loop { sample_time: 0.25, ..Loop::EXAMPLE };
    /// let law = Pid::new(&PidGains { ki: 4.0 }, &around);
    /// let mut state = PidState::default();
    /// let input = LawInput { error: 0.5, ..LawInput::default() };
    /// assert_eq!(law.update(&mut state, &input), 0.5);
    /// let limited = LawInput { applied: 5.0, saturated: true, ..input };
    /// assert_eq!(law.update(&mut state, &limited), 0.5);
    /// assert_eq!(law.update(&mut state, &LawInput { error: -0.25, ..limited }), 0.25);
    /// ```
    fn update(&self, state: &mut PidState, input: &LawInput) -> f32 {
        // During a soft start the effort can be limited to zero, which has no sign.
        let asks_for_more = input.saturated && input.applied * input.error >= 0.0;
        if !asks_for_more {
            state.v_c = saturate(state.v_c + self.ki_h * input.error, self.full_scale).0;
        }
        state.v_c
    }
}
