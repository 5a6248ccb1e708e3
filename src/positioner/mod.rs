//! `robust` for a firmware of your own: counts and a target in, an effort out.
//!
//! ```text
//! target --+                                   tick(counts, target)
//!          v
//! counts -> robust -> limit u_m -> step u_q -> effort -> your amplifier
//!             ^                                  |
//!             +--------- applied effort ---------+   (tick_applied: what it really was)
//! ```
//!
//! **A law stops no runaway.** An encoder that dies, turns the wrong way or slips, a joint that
//! hits a stop, a motor that gets too hot: the law notices none of them. Limit the travel, the time
//! and the current outside, and turn the output off when a limit is exceeded. The monitors of a
//! device that need no board are in [`RunawayMonitors`]; its page lists what they do not detect.
//!
//! [`PdPositioner`] does the same with PD and one of the thesis's laws, and [`MoveProfile`]
//! generates the path of a move for it. [`Counter`] unwraps a hardware counter. [`Positioner`]'s
//! law is [`Robust`]; its page has the equations and what it does badly. This module adds only SI
//! units, the validation of a [`PositionerConfig`], the limit and the step of the effort, and zero
//! instead of an effort that is not a number. It does not allocate, panic or use `f64`, and depends
//! on no board: it runs on any target that has `core`.
//!
//! ```
//! use stiction::positioner::{EncoderSide, Positioner, PositionerConfig, Target};
//!
//! // Volts: 24 V in steps of 24 mV, a joint that starts at 0.9 to 3 V.
//! let config = PositionerConfig {
//!     sample_time: 1e-3,
//!     counts_per_turn: 100_000.0,
//!     largest_effort: 24.0,
//!     effort_step: 0.024,
//!     inertia: 0.12,
//!     viscous: 0.9,
//!     breakaway: [0.9, 3.0],
//!     load: 0.0,
//!     hold_effort: 0.0,
//!     jitter: 0.0,
//!     speed: 0.0,
//!     acceleration: 0.0,
//!     encoder_side: EncoderSide::Motor,
//! };
//! let positioner = Positioner::new(&config)?;
//! let mut state = positioner.start();
//! // In each tick, 1 ms apart: read the counter, and apply what is returned.
//! let counts = 0;
//! let effort = positioner.tick(&mut state, counts, Target::at_rest(positioner.position(0.5)));
//! // It sets out: more than the least breakaway effort.
//! assert!(effort > 0.9 && effort <= 24.0);
//! # Ok::<(), stiction::positioner::Refused>(())
//! ```

mod config;
mod counter;
mod effort;
mod monitors;
mod move_profile;
mod pd;

pub use crate::control::laws::robust::{EncoderSide, Mode};
pub use crate::units::position::Position;
pub use config::{PositionerConfig, Refused};
pub use counter::{Counter, CounterBits, Direction};
pub use monitors::{MonitorConfig, Runaway, RunawayMonitors, RunawayState};
pub use move_profile::{MoveConfig, MoveProfile};
pub use pd::{PdConfig, PdPositioner, PdState};

use crate::control::laws::robust::RobustState;
use crate::control::laws::{Law, LawInput, Robust};
use crate::control::reference::Setpoint;
use effort::EffortSteps;

/// Position, velocity and acceleration that the joint should have at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Position, counts and a fraction: a target between two counts is kept.
    pub position: Position,
    /// Velocity, rad/s. 0: the target rests, and the joint comes to rest at it by a profile of its
    /// own.
    pub velocity: f32,
    /// Acceleration, rad/s^2, for a law that feeds it forward.
    pub acceleration: f32,
}

impl Target {
    /// Returns a target at rest.
    pub const fn at_rest(position: Position) -> Self {
        Self { position, velocity: 0.0, acceleration: 0.0 }
    }

    /// Returns the target in the core's units.
    fn setpoint(&self) -> Setpoint {
        Setpoint {
            position: self.position,
            velocity: self.velocity.to_degrees(),
            acceleration: self.acceleration.to_degrees(),
        }
    }
}

/// Position controller for a joint that sticks, prepared for a joint and a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Positioner {
    law: Robust,
    effort: EffortSteps,
    counts_per_turn: f32,
}

/// State of a positioner from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionerState {
    law: RobustState,
    /// Effort since the last tick.
    applied: f32,
}

impl Positioner {
    /// Validates a configuration and prepares it.
    ///
    /// # Errors
    /// Returns the first field that is outside its range.
    ///
    /// ```
    /// # use stiction::positioner::{EncoderSide, Positioner, PositionerConfig};
    /// # let config = PositionerConfig {
    /// #     sample_time: 1e-3, counts_per_turn: 1e5, largest_effort: 24.0, effort_step: 0.024,
    /// #     inertia: 0.12, viscous: 0.9, breakaway: [0.9, 3.0], load: 0.0, hold_effort: 0.0,
    /// #     jitter: 0.0, speed: 0.0, acceleration: 0.0, encoder_side: EncoderSide::Motor,
    /// # };
    /// let wrong = PositionerConfig { breakaway: [0.9, 30.0], ..config };
    /// let why = Positioner::new(&wrong).unwrap_err();
    /// assert_eq!((why.field, why.found, why.low, why.high), ("breakaway[1]", 30.0, 0.9, 24.0));
    /// ```
    pub fn new(config: &PositionerConfig) -> Result<Self, Refused> {
        let (gains, around) = config.prepared()?;
        Ok(Self {
            law: Robust::new(&gains, &around),
            effort: EffortSteps::new(config.largest_effort, config.effort_step),
            counts_per_turn: config.counts_per_turn,
        })
    }

    /// Returns the state of a joint at rest, before the first tick.
    pub fn start(&self) -> PositionerState {
        PositionerState::default()
    }

    /// Returns the position of an angle (rad), counted from the counter's zero. An `f32` resolves
    /// an angle to 6e-8 of its size: after many turns, add counts instead.
    pub fn position(&self, angle: f32) -> Position {
        let turns = angle * (0.5 * core::f32::consts::FRAC_1_PI);
        Position::default().displaced(turns * self.counts_per_turn)
    }

    /// Runs one tick with the counter's position (it can wrap) and the target, and returns the
    /// effort until the next tick. That effort must be applied at once and in full; if not, see
    /// [`tick_applied`](Self::tick_applied).
    pub fn tick(&self, state: &mut PositionerState, counts: i32, target: Target) -> f32 {
        let applied = state.applied;
        self.tick_applied(state, counts, target, applied)
    }

    /// Runs one tick, for an amplifier that has limited the last effort: `applied` is the mean
    /// effort that the joint has had since the last tick.
    pub fn tick_applied(
        &self,
        state: &mut PositionerState,
        counts: i32,
        target: Target,
        applied: f32,
    ) -> f32 {
        let setpoint = target.setpoint();
        let input = LawInput { counts, setpoint, applied, ..LawInput::default() };
        let asked = self.law.update(&mut state.law, &input);
        state.applied = if asked.is_finite() && setpoint.is_finite() {
            self.effort.apply(asked).0
        } else {
            // Zero effort, and the law starts again where the joint is.
            state.law.forget();
            0.0
        };
        state.applied
    }

    /// Discards what the law has learned: it starts at rest, where the joint is. Call it before the
    /// next tick if the output was off or the counter was set.
    pub fn restart(&self, state: &mut PositionerState) {
        state.law.forget();
        state.applied = 0.0;
    }

    /// Restarts the attempts of a law that has [given up](Mode::GiveUp). A moving target restarts
    /// them, too.
    pub fn try_again(&self, state: &mut PositionerState) {
        Robust::begin_motion(&mut state.law);
    }

    /// Returns the state of the law after the last tick.
    pub const fn mode(&self, state: &PositionerState) -> Mode {
        state.law.mode()
    }
}

#[cfg(test)]
mod monitors_tests;
#[cfg(test)]
mod path_tests;
#[cfg(test)]
mod tests;
