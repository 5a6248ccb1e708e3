//! Two-reset PID: an integral that changes its sign where the error does, and is reset to zero
//! where the joint stops.
//!
//! After Beerens, Bisoffi, Zaccarian, Nijmeijer, Heemels and van de Wouw, "Reset PID design for
//! motion systems with Stribeck friction", *IEEE Transactions on Control Systems Technology*, 2021,
//! doi 10.1109/TCST.2021.3063420:
//!
//! ```text
//! v_c(t) = x(t) + w(t)
//! x(t)   = x(t - h) + Ki theta_e h
//!          theta_e crosses zero:    x -> -x    }  these two alternate, and
//!          then theta_a' reaches 0: x -> 0     }  the first one begins
//! w(t)   = w(t - h) + x h/T                    while the joint slides, below
//! ```
//!
//! Why this form: a PID hunts because of the integral that it carries across the target, filled
//! against the static friction and too large against the dynamic one. The first reset makes it
//! brake, and after the second one the joint can rest. Each breakaway then begins nearer the
//! target. The paper proves set-points globally asymptotically stable, for unknown static friction
//! and any Stribeck curve, if `Kp Kd > Ki J`. There, the resets are at the very crossings. Here,
//! they are at the first sample after them: the error by its sign, the stop by the velocity's
//! regression.
//!
//! The paper's joint carries no load. Each second reset would remove the effort that holds a
//! constant load. So, in an addition of ours, an estimate `w` of the load takes over the integral's
//! content with the time constant `T` while the joint slides towards the target (after the second
//! reset, before the first). `T` of some seconds or more keeps the friction, whose sign changes
//! with the side, from entering it. While the joint rests, `w` stays constant.
//!
//! Guarantees: |v_c| never exceeds the full scale, nor do its two parts. Does badly: it is slow
//! near the target, since it fills the integral from zero for each breakaway, in
//! `F / (Ki theta_e)`. A count that hides the crossing hides the reset: with static friction twice
//! the dynamic one it jumps across the band at random. In tracking it is PID, reset by every
//! crossing.

use crate::control::laws::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::saturate;
use crate::units::value::table;

table! {
    /// Gains of two-reset PID.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TwoResetPidGains (law) "controller" {
        /// Integral gain Ki, V/(deg s). Stable below Kp Kd/J.
        ki: f32 = 0x3101 "ki_v_per_deg_s", Between(0.0, HUGE), Needed(4.0);
        /// Time in which the estimate of a constant load takes over the integral T, s.
        load_time: f32 = 0x3102 "load_time_s", Above(0.0, HUGE), Needed(5.0);
    }
}

/// The law two-reset PID, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoResetPid {
    /// Ki h, V/deg.
    ki_h: f32,
    /// h/T.
    share: f32,
    full_scale: f32,
}

/// The state of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwoResetPidState {
    /// Integral x, V.
    integral: f32,
    /// Estimate of the load w, V.
    load: f32,
    /// Error and velocity of the last tick, deg and deg/s.
    error: f32,
    velocity: f32,
    /// Whether the first reset has happened, and the second is due.
    crossed: bool,
}

impl Law for TwoResetPid {
    type Gains = TwoResetPidGains;
    type State = TwoResetPidState;

    const ON_THE_DEVICE: bool = false;

    fn new(gains: &TwoResetPidGains, around: &Loop) -> Self {
        let TwoResetPidGains { ki, load_time } = *gains;
        let share = (around.sample_time / load_time).min(1.0);
        Self { ki_h: ki * around.sample_time, share, full_scale: around.full_scale }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::rival::two_reset_pid::TwoResetPidState;
    /// use stiction::control::laws::{Law, LawInput, Loop, TwoResetPid, TwoResetPidGains};
    /// let around = Loop { sample_time: 0.25, ..Loop::EXAMPLE };
    /// let law = TwoResetPid::new(&TwoResetPidGains { ki: 4.0, load_time: 1e6 }, &around);
    /// let mut state = TwoResetPidState::default();
    /// let sample = |error, velocity| LawInput { error, velocity, ..LawInput::default() };
    /// assert_eq!(law.update(&mut state, &sample(0.5, 0.0)), 0.5);
    /// // Across the target: the sign changes, and then it is integrated further.
    /// assert_eq!(law.update(&mut state, &sample(-0.25, 1.0)), -0.75);
    /// // At rest: it is emptied.
    /// assert_eq!(law.update(&mut state, &sample(-0.25, 0.0)), -0.25);
    /// ```
    fn update(&self, state: &mut TwoResetPidState, input: &LawInput) -> f32 {
        let LawInput { error, velocity, .. } = *input;
        if !state.crossed && error * state.error < 0.0 {
            state.integral = -state.integral;
            state.crossed = true;
        } else if state.crossed && (velocity == 0.0 || velocity * state.velocity < 0.0) {
            state.integral = 0.0;
            state.crossed = false;
        }
        if !state.crossed && velocity != 0.0 {
            state.load = saturate(state.load + self.share * state.integral, self.full_scale).0;
        }
        state.integral = saturate(state.integral + self.ki_h * error, self.full_scale).0;
        (state.error, state.velocity) = (error, velocity);
        saturate(state.integral + state.load, self.full_scale).0
    }
}
