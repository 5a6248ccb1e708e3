//! `robust`: a supervisor that moves the joint by a profile, and then by attempts onto the count.
//!
//! The law replaces PD. It consists of separate algorithms, each with its equation and source in
//! its own file. The supervisor selects which of them acts:
//!
//! ```text
//!           p' != 0 (from any state)                   |e| > 1.25 q for N_r ticks, or > 3.5 q
//!   +-----------> MOVE --- p' = 0 and rest ---> STUCK -- |e| <= 1.25 q for N_h ticks --> HOLD --+
//!   |                                            ^   |                                          |
//!   | lost: |r - y| > 3 |e_b| + 64 q *           |   +-- springs: step of u_b ----+             |
//!   +----- STUCK, COAST, HOLD, GIVE_UP           |---+-- else PULSE (A, N) --> COAST -- judged, |
//!                                                |                               |  gives up    |
//!                                                +---- judged, learned ----------+--> GIVE_UP   |
//!                                                +------------------ springs = true ------------+
//!
//!   MOVE   u = Kp (p - y) + d Kd (p' - x2) + J p'' + B p' - g J x3 + (1 - g) R_i s  p' != 0
//!          u = Kp e + Kd (r' - x2) + u_b + 0.8 g R_i sat(e / 8 q)                   p' = 0
//!   STUCK  u = u_b + Kp e - Kd x2
//!   PULSE  u = u_b + s A
//!   COAST  u = u_b - Kd x2   (+ Kp e after a step)
//!   HOLD   u = what STUCK gave last
//!
//!   Kp = g^2 J w_n^2,   Kd = g max(0, 2 zeta J w_n - B),   while it moves g is 0.3 at least
//!
//!   p' = r', slower than the joint can slide:  MOVE --> STUCK, PULSE, COAST, STUCK, PULSE ...
//! ```
//!
//! `q` is one count. With a configured load, the joint already counts as lost (*) beyond `|e_b| +
//! 64 q`. `p` is the profile within the set point `r`
//! ([`BoundedAcceleration`](crate::control::profile::BoundedAcceleration)), `x2` and `x3` are the
//! observer's ([`extended_state_observer`]), `R_i` the learned friction ([`sliding_friction`]), `A`
//! and `N` planned ([`pulse_planner`], [`reverse_pulse`]), `u_b` the hold effort ([`hold_effort`],
//! [`load_rule`]), `g` the guard's gain and `d` its factor on the damping, 1 or 1/2
//! ([`oscillation_guard`]). [`rest_detector`] detects rest, and [`give_up`] ends the attempts. `e =
//! r - y`; at rest, `y` is the mean of the rest. Several transitions can happen in a tick, in the
//! order MOVE, HOLD, STUCK, then PULSE or COAST: a pulse of one tick shows as COAST.
//!
//! If the joint cannot slide at the speed of a slow set point, the law follows the set point by
//! attempts, too: it inches ([`inching`] has the conditions). These attempts do not count towards
//! giving up. The observer is faster while the set point moves (`w_m`), since friction changes its
//! direction then; with jitter it is not, since a faster observer responds to jitter as to motion.
//!
//! Why this form: a law that is a function of the error rests where its effort equals the friction,
//! or swings about the target. An attempt decides only at rest, learns from its result, and stops
//! where the error is as small as the encoder resolves: the stop band of 1.25 counts leaves a true
//! error of 1.75 at most. Everything that happens fast is planned open loop, so a delay, a coarse
//! encoder or a spring makes attempts worse, not the loop unstable.
//!
//! Positions are differences of integer counts from an origin. The origin moves to the joint if the
//! joint rests 16,384 counts away from it, and in motion from 65,536 counts on. So an `f32` keeps
//! 1/128 of a count however far the joint has turned, and 1/500 at rest. The origin does not move
//! at each rest: comparisons with one count are between nearly equal numbers there, and another
//! origin would round them to the other side.
//!
//! Guarantees: |v_c| never exceeds the full scale. In HOLD and in GIVE_UP the effort is constant.
//! The law is odd: a mirrored motion has the mirrored effort. From a tick at rest, the first effort
//! is that of a profile that sets out, however far the target is. `u_b` stays within `0.8 F_hi +
//! u_L`. Does badly: inertia that is wrong by half, in tracking; a load that slides by more than 16
//! counts behind the transmission; noise of the encoder that is not declared; a loop slower than 5
//! ms on 100 000 counts; loads and end stops, without [`load_rule`] and [`give_up`]. The learned
//! values are lost when the joint is armed again. The thresholds are those of a prototype, and the
//! law has not run on a real joint.

pub mod extended_state_observer;
pub mod give_up;
pub mod hold_effort;
pub mod inching;
pub mod load_rule;
pub mod oscillation_guard;
mod parameters;
pub mod pulse_planner;
pub mod rest_detector;
pub mod reverse_pulse;
pub mod sliding_friction;
#[cfg(test)]
mod slow_traces;
mod supervisor;

pub use parameters::{EncoderSide, RobustGains};
pub use supervisor::Mode;

use super::{Law, LawInput, Loop};
use crate::control::signal::{LawSignal, MAX_LAW_SIGNALS};
use crate::units::error::HUGE;
pub(super) use parameters::{Rules, SLOW};
use supervisor::{Seen, Supervisor};

/// Distance from the origin at which the origin moves to the joint, counts: at rest, and in motion.
const AT_REST: u32 = 1 << 14;
const ON_THE_WAY: u32 = 1 << 16;

/// The law `robust`, prepared for a joint and a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust {
    supervisor: Supervisor,
    /// Angle of a count q, deg.
    count: f32,
    inertia: f32,
}

/// The state of the law from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobustState {
    supervisor: supervisor::SupervisorState,
    /// Position of the origin, counts.
    origin: i32,
    /// Whether a tick has set the origin.
    begun: bool,
}

impl RobustState {
    /// Resets the law: its next tick sets the whole state. This call clears one flag alone, since a
    /// tick that latches a fault has to turn off the bridge first.
    pub const fn forget(&mut self) {
        self.begun = false;
    }

    /// Returns the state of the supervisor.
    pub const fn mode(&self) -> Mode {
        self.supervisor.mode
    }

    /// Returns whether the law follows a slow set point by attempts.
    pub const fn is_inching(&self) -> bool {
        self.supervisor.inching.active
    }

    /// Returns the gain g of the oscillation guard.
    pub const fn gain(&self) -> f32 {
        self.supervisor.guarded.gain
    }

    /// Returns the hold effort u_b, V.
    pub const fn hold_effort(&self) -> f32 {
        self.supervisor.held.effort
    }
}

impl Robust {
    /// Resets the state to a joint at rest at `counts`. In place: copying the whole state would
    /// cost a tenth of the tick.
    #[cold]
    fn begin(&self, state: &mut RobustState, counts: i32) {
        self.supervisor.start(&mut state.supervisor);
        (state.origin, state.begun) = (counts, true);
    }
}

impl Law for Robust {
    type Gains = RobustGains;
    type State = RobustState;

    const REPLACES_PD: bool = true;
    const SIGNALS: &'static [LawSignal] = &[
        // 0 MOVE, 1 STUCK, 2 PULSE, 3 COAST, 4 HOLD, 5 GIVE_UP, after the tick.
        LawSignal { name: "robust_mode", unit: "" },
        LawSignal { name: "robust_gain", unit: "" },
        LawSignal { name: "robust_hold_v", unit: "V" },
        // The effort that the model lacks, -J x3.
        LawSignal { name: "robust_disturbance_v", unit: "V" },
        LawSignal { name: "robust_friction_forward_v", unit: "V" },
        LawSignal { name: "robust_friction_backward_v", unit: "V" },
        // From the inner profile to the set point.
        LawSignal { name: "robust_to_go_deg", unit: "deg" },
        LawSignal { name: "robust_attempts", unit: "" },
    ];

    fn new(gains: &RobustGains, around: &Loop) -> Self {
        Self {
            supervisor: Supervisor::new(gains, around),
            count: around.resolution,
            inertia: gains.inertia,
        }
    }

    /// Returns the effort of a tick, V.
    ///
    /// ```
    /// use stiction::control::laws::{Law, LawInput, Loop, Robust, RobustGains};
    /// use stiction::units::position::Position;
    /// use stiction::control::reference::Setpoint;
    /// use stiction::units::value::Table;
    /// let law = Robust::new(&RobustGains::EXAMPLE, &Loop::EXAMPLE);
    /// let mut state = Default::default();
    /// let setpoint = Setpoint::at_rest(Position::from_counts(1000));
    /// let input = LawInput { setpoint, ..LawInput::default() };
    /// // A profile sets out: J a_m (1.25 V), friction R_0, damping, and a count of error.
    /// let v_c = law.update(&mut state, &input);
    /// assert!(v_c > 1.25 + 0.35 && v_c < 2.5, "{v_c}");
    /// ```
    fn update(&self, state: &mut RobustState, input: &LawInput) -> f32 {
        if !state.begun {
            self.begin(state, input.counts);
        }
        let mut away = input.counts.wrapping_sub(state.origin);
        let farthest = if self.supervisor.rests(&state.supervisor) { AT_REST } else { ON_THE_WAY };
        if away.unsigned_abs() >= farthest {
            self.supervisor.rebase(&mut state.supervisor, away as f32 * self.count);
            state.origin = input.counts;
            away = 0;
        }
        let seen = Seen {
            position: away as f32 * self.count,
            reference: input.setpoint.position.ahead_of(state.origin) * self.count,
            velocity: input.setpoint.velocity,
            applied: input.applied,
        };
        self.supervisor.update(&mut state.supervisor, &seen)
    }

    fn signals(&self, state: &RobustState) -> [f32; MAX_LAW_SIGNALS] {
        let s = &state.supervisor;
        let [backward, forward] = s.friction;
        [
            f32::from(s.mode as u8),
            s.guarded.gain,
            s.held.effort,
            -self.inertia * s.estimate.disturbance,
            forward,
            backward,
            s.to_go,
            f32::from(s.attempts.all),
        ]
    }

    fn has_given_up(state: &RobustState) -> bool {
        state.begun && matches!(state.mode(), Mode::GiveUp)
    }

    fn begin_motion(state: &mut RobustState) {
        state.supervisor.try_again();
    }

    /// Returns twice the profile's speed, deg/s, at least 16 counts a tick. No part of the law
    /// requests more than twice the profile's speed.
    fn overspeed(gains: &RobustGains, around: &Loop) -> Option<f32> {
        let slowest = 16.0 * around.resolution / around.sample_time;
        Some((2.0 * Rules::new(gains, around).speed).max(slowest).min(HUGE))
    }

    /// Returns the time for which the joint can swing before the guard has lowered the gain, s. The
    /// guard needs some swings to detect that a gain is too high. Meanwhile the motor, or the load
    /// with the encoder, swings against the transmission. In a slow loop the guard does not check
    /// for wide swings, and the monitor does: none is returned.
    fn swing_time(gains: &RobustGains, around: &Loop) -> Option<f32> {
        let fast = around.sample_time <= SLOW;
        fast.then(|| if Rules::new(gains, around).on_load { 0.1 } else { 0.05 })
    }

    /// Returns the default limit of the following error, deg: the larger one of the first two of
    /// these errors, but no more than the third one, and at least 16 counts.
    ///
    /// - The distance in which the profile reaches its full speed, `v_m^2 / (2 a_m)`. The profile
    ///   trails a set point that starts at that speed by this distance.
    /// - The error at which the loop requests the largest breakaway effort and load, `(F_hi + u_L)
    ///   / (J w_n^2)`. A joint can hang back by this error before the requested effort moves it.
    /// - The error at which the loop requests the full scale,
    ///   [`saturating_error`](Law::saturating_error). A loop that has run away reaches it, as with
    ///   an encoder that is reversed in motion. Where this error is the limit, a set point that
    ///   starts at more than `sqrt(8) a_m / w_n` needs a larger limit, or a blend.
    ///
    /// With the encoder on the motor and a sample time up to 10 ms, the error is doubled: a motor
    /// that swings against its gear exceeds the single error on either side before the guard has
    /// lowered the gain.
    fn following_error(gains: &RobustGains, around: &Loop) -> Option<f32> {
        let Rules { speed, acceleration, bandwidth, on_load, .. } = Rules::new(gains, around);
        let way = speed * speed / (2.0 * acceleration);
        let stiffness = gains.inertia * bandwidth * bandwidth;
        let saturating = around.full_scale / stiffness;
        let hanging = (gains.breakaway_high + gains.load) / stiffness;
        let swings = if on_load || around.sample_time > SLOW { 1.0 } else { 2.0 };
        Some((swings * way.max(hanging).min(saturating)).max(16.0 * around.resolution).min(HUGE))
    }

    /// Returns `u_m / (J w_n^2)`, deg.
    fn saturating_error(gains: &RobustGains, around: &Loop) -> Option<f32> {
        let bandwidth = Rules::new(gains, around).bandwidth;
        Some((around.full_scale / (gains.inertia * bandwidth * bandwidth)).min(HUGE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::reference::Setpoint;
    use crate::units::position::Position;
    use crate::units::value::Table;

    /// Kd = 2 zeta J w_n - B, times p' - x2.
    #[test]
    fn guard_halves_the_damping_of_a_motion_and_nothing_else() {
        let gains = RobustGains { bandwidth: 40.0, ..RobustGains::EXAMPLE };
        let law = Robust::new(&gains, &Loop::EXAMPLE);
        let mut state = RobustState::default();
        law.update(&mut state, &LawInput::default());
        // The first tick of a profile that sets out.
        let setpoint = Setpoint::at_rest(Position::from_counts(1000));
        let input = LawInput { setpoint, ..LawInput::default() };
        let mut guarded = state;
        guarded.supervisor.guarded.damping = 0.5;
        let [whole, half] = [&mut state, &mut guarded].map(|state| law.update(state, &input));
        let behind = state.supervisor.profile.velocity - state.supervisor.estimate.velocity;
        let derivative = 2.0 * gains.damping * gains.inertia * gains.bandwidth - gains.viscous;
        let expected = 0.5 * derivative * behind;
        assert!(expected > 0.01 && (whole - half - expected).abs() < 1e-5, "{whole} {half}");
    }
}
