//! `robust-dual`: `robust` with two encoders, one on the motor and one on the load.
//!
//! The law closes its loop on the motor, and decides by the load. With motor `y`, load `l` and set
//! point `r`, all in deg of the joint, the twist of the gear is `w = y - l`, and `e = r - l`.
//!
//! ```text
//!           p' != 0 (from any state)                |e| > 1.25 q for N_r ticks, or > 3.5 q
//!   +-----------> MOVE --- p' = 0 and rest ---> STUCK -- |e| <= 1.25 q for N_h ticks --> HOLD --+
//!   |                                            ^   |                                          |
//!   | lost: |r - l| > 3 |e_b| + 64 q + 2 S       |   +-- S > 9 q: BUMP --+                      |
//!   +----- STUCK, COAST, HOLD, GIVE_UP           |   +-- springs: step --+-> COAST -- judged,   |
//!                                                |   +-- else PULSE -----+     |      gives up  |
//!                                                +---- judged, learned --------+   --> GIVE_UP  |
//!                                                +----------------------------------------------+
//!
//!   MOVE   as `robust` on y, towards r + N, and once the load has left its rest, r + t: t begins
//!          with N + 0.4 s S, and while r moves it integrates the lag of the load
//!   STUCK  u = u_b - Kd x2   (+ Kp e unless S > 9 q)
//!   BUMP, COAST after it     motor_bump.rs
//!   all else                 as `robust`, with `y` for what moves and `e` for what is wanted
//! ```
//!
//! `N`, the neutral twist, and `S`, half the width of the twists that the load's friction holds,
//! are learned from rests ([`twist_levels`]). The motor goes to the position at which the gear is
//! relaxed with the load at its target. Bumps of the motor ([`motor_bump`]) remove the remaining
//! error, and the law learns from each bump ([`bump_memory`]). Where `robust` waits for the joint
//! to rest, this law waits for motor and load. Observer, profile, guard, `R_i`, pulses and steps of
//! the hold effort are those of [`robust`](super::robust). No property of the gear is required.
//! [`load_integral`] is the part of MOVE that `robust` does not have.
//!
//! A joint that swings around its target ends in GIVE_UP as well. After twice `give_up_attempts`,
//! the law stops at a rest whose error is at most the smallest one so far. Each further attempt
//! raises that limit by a tenth. A commanded motion clears the attempts, and so does a HOLD.
//!
//! Why this form: behind a soft gear, the motor's position shows little of the load, and a loop
//! around the load swings. The load leaves its rest at some twist, and jumps as far as the gear was
//! wound up for the difference of stick and slip friction. The motor can reduce that twist while
//! the load slides.
//!
//! Positions are differences of integer counts from an origin of each side, which moves as that of
//! `robust` does. Both origins move by whole counts of their own, and the resulting change of the
//! twist is added to all levels. So an `f32` keeps 1/128 of a count of the load wherever it is.
//!
//! Guarantees: |v_c| never exceeds the full scale; in HOLD the effort is constant. Does badly: the
//! smallest slide, `jump (dF/(u_m - F_m)) (J_m/J_l)`, where it is more than some counts; ticks of
//! 2 ms and more with hard friction; noise of an encoder that is not declared; a wrong ratio of the
//! encoders; set points that move slowly, which it does not follow by attempts as `robust` does.
//!
//! The thresholds are those of a prototype. The law is compiled with the feature `two-encoders`,
//! which the simulator and the image for two encoders have. It has not run on a real joint.

pub mod bump_memory;
#[cfg(test)]
mod golden_traces;
pub mod load_integral;
#[cfg(test)]
mod motion_tests;
pub mod motor_bump;
#[cfg(test)]
mod origin_tests;
mod parameters;
pub mod push;
mod supervisor;
pub mod twist_levels;

pub use parameters::RobustDualGains;
pub use supervisor::Mode;

use super::robust::{Robust, SLOW};
use super::{Law, LawInput, Loop};
use crate::control::signal::{LawSignal, MAX_LAW_SIGNALS};
use crate::units::error::HUGE;
use supervisor::{Seen, Supervisor};

/// Distance of the load from its origin at which the origins move, counts: at rest, and in motion.
const AT_REST: u32 = 1 << 14;
const ON_THE_WAY: u32 = 1 << 16;

/// The same distances for the motor, whose encoder can be finer. A position is then within 1/32 of
/// a count at rest, and 1/16 in motion: less than the tenth that a rest tolerates.
const MOTOR_AT_REST: u32 = 1 << 18;
const MOTOR_ON_THE_WAY: u32 = 1 << 19;

/// The law `robust-dual`, prepared for a joint and a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustDual {
    supervisor: Supervisor,
    /// Angles of a count of motor and load, deg.
    counts: [f32; 2],
    inertia: f32,
}

/// The state of the law from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RobustDualState {
    supervisor: supervisor::SupervisorState,
    /// Positions of the origins of motor and load, counts.
    origins: [i32; 2],
}

impl RobustDualState {
    /// Resets the law at its next tick, as [`RobustState::forget`] does.
    ///
    /// [`RobustState::forget`]: super::robust::RobustState::forget
    pub const fn forget(&mut self) {
        self.supervisor.has_begun = false;
    }

    /// Returns the state of the supervisor.
    pub const fn mode(&self) -> Mode {
        self.supervisor.mode
    }
}

impl RobustDual {
    /// Resets the state to both sides at rest at their present counts.
    #[cold]
    fn begin(&self, state: &mut RobustDualState, counts: [i32; 2]) {
        self.supervisor.start(&mut state.supervisor);
        (state.origins, state.supervisor.has_begun) = (counts, true);
    }

    /// Moves the origins to where both sides are.
    #[cold]
    fn rebase(&self, state: &mut RobustDualState, counts: [i32; 2], away: [i32; 2]) {
        let [motor, load] = away;
        let by = [motor as f32 * self.counts[0], load as f32 * self.counts[1]];
        // The motor's origin keeps its distance from that of the load, to half a count, so that a
        // twist stays a small number.
        let wound_up = libm::roundf((by[0] - by[1]) / self.counts[0]) as i32;
        let motor = motor.wrapping_sub(wound_up);
        let by = [motor as f32 * self.counts[0], by[1]];
        self.supervisor.rebase(&mut state.supervisor, by);
        state.origins = [counts[0].wrapping_sub(wound_up), counts[1]];
    }
}

impl Law for RobustDual {
    type Gains = RobustDualGains;
    type State = RobustDualState;

    const REPLACES_PD: bool = true;
    const SIGNALS: &'static [LawSignal] = &[
        // 0 MOVE, 1 STUCK, 2 PULSE, 3 COAST, 4 HOLD, 5 GIVE_UP, 6 BUMP, after the tick.
        LawSignal { name: "robust_mode", unit: "" },
        LawSignal { name: "robust_gain", unit: "" },
        LawSignal { name: "robust_hold_v", unit: "V" },
        LawSignal { name: "robust_disturbance_v", unit: "V" },
        LawSignal { name: "robust_neutral_twist_deg", unit: "deg" },
        // Half the width S of the twists that the load's friction holds.
        LawSignal { name: "robust_half_twist_deg", unit: "deg" },
        // From the inner profile to the set point of the motor.
        LawSignal { name: "robust_to_go_deg", unit: "deg" },
        LawSignal { name: "robust_attempts", unit: "" },
    ];

    fn new(gains: &RobustDualGains, around: &Loop) -> Self {
        Self {
            supervisor: Supervisor::new(gains, around),
            counts: [around.motor.count().unwrap_or(around.resolution), around.resolution],
            inertia: gains.inertia,
        }
    }

    /// Returns the effort of a tick, V.
    fn update(&self, state: &mut RobustDualState, input: &LawInput) -> f32 {
        let counts = [input.motor_counts, input.counts];
        if !state.supervisor.has_begun {
            self.begin(state, counts);
        }
        let from_origins = |state: &RobustDualState| {
            let [motor, load] = state.origins;
            [counts[0].wrapping_sub(motor), counts[1].wrapping_sub(load)]
        };
        let mut away = from_origins(state);
        let [motor, load] = if self.supervisor.rests(&state.supervisor) {
            [MOTOR_AT_REST, AT_REST]
        } else {
            [MOTOR_ON_THE_WAY, ON_THE_WAY]
        };
        if away[0].unsigned_abs() >= motor || away[1].unsigned_abs() >= load {
            self.rebase(state, counts, away);
            away = from_origins(state);
        }
        let seen = Seen {
            motor: away[0] as f32 * self.counts[0],
            load: away[1] as f32 * self.counts[1],
            reference: input.setpoint.position.ahead_of(state.origins[1]) * self.counts[1],
            velocity: input.setpoint.velocity,
            applied: input.applied,
        };
        self.supervisor.update(&mut state.supervisor, &seen)
    }

    fn signals(&self, state: &RobustDualState) -> [f32; MAX_LAW_SIGNALS] {
        let s = &state.supervisor;
        [
            f32::from(s.mode as u8),
            s.guarded.gain,
            s.held.effort,
            -self.inertia * s.estimate.disturbance,
            s.levels.neutral,
            s.levels.half_width(),
            s.to_go,
            f32::from(s.attempts.all),
        ]
    }

    fn has_given_up(state: &RobustDualState) -> bool {
        state.supervisor.has_begun && matches!(state.mode(), Mode::GiveUp)
    }

    fn begin_motion(state: &mut RobustDualState) {
        state.supervisor.try_again();
    }

    /// Returns twice the profile's speed of the motor, deg/s, at least 16 counts a tick, as
    /// `robust` does.
    fn overspeed(gains: &RobustDualGains, around: &Loop) -> Option<f32> {
        let slowest = 16.0 * around.resolution / around.sample_time;
        Some((2.0 * gains.rules(around).speed).max(slowest).min(HUGE))
    }

    /// Returns the time of `robust` with the encoder on the load, s.
    fn swing_time(_: &RobustDualGains, around: &Loop) -> Option<f32> {
        (around.sample_time <= SLOW).then_some(0.1)
    }

    /// Returns the error of `robust` with the encoder on the motor, plus the twist under the
    /// largest breakaway effort and load, deg: the load lags by this twist before it jumps.
    fn following_error(gains: &RobustDualGains, around: &Loop) -> Option<f32> {
        let of_motor = Robust::following_error(&gains.of_motor(), around)?;
        Some((of_motor + gains.largest_twist()).min(HUGE))
    }

    fn saturating_error(gains: &RobustDualGains, around: &Loop) -> Option<f32> {
        Robust::saturating_error(&gains.of_motor(), around)
    }
}
