//! PD with one law of the thesis, for a firmware of your own: only that law is linked.
//!
//! ```text
//! counts -> velocity by least squares -+
//! target -------------> error ---------+-> PD (eq. 28) + law -> limit, step -> effort
//! ```
//!
//! The page of each law in [`laws`](crate::control::laws) has its equation, and what it does badly.
//! As with [`Positioner`](super::Positioner): **a law stops no runaway.**

use super::config::{COUNTS, RANGE, SAMPLE_TIME, check, refused};
use super::effort::EffortSteps;
use super::{Refused, Target};
use crate::control::laws::{Law, LawInput, Loop};
use crate::control::motor_encoder::MotorEncoder;
use crate::control::pd::PdGains;
use crate::control::velocity::{MAX_WINDOW, Velocity, VelocityState};
use crate::units::value::Values;

/// Configuration of a PD loop. Angles are rad of the joint; the effort is in any unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdConfig {
    /// Time between two ticks, s.
    pub sample_time: f32,
    /// Counts of the encoder in a turn of the joint.
    pub counts_per_turn: f32,
    /// Largest effort.
    pub largest_effort: f32,
    /// Step of the effort. The returned effort is a multiple of it, or the largest effort.
    pub effort_step: f32,
    /// Proportional gain Kp, effort per rad.
    pub kp: f32,
    /// Derivative gain Kd, effort per rad/s.
    pub kd: f32,
    /// Number of positions in the regression of the velocity, from 2 on; 5 in the thesis.
    pub velocity_window: u32,
}

/// PD with one law, prepared.
///
/// The gains of a law are in its own units, with degrees for angles: `SmoothRobustNonlinearGains`
/// has its `alpha` in 1/deg. Volts stand for any unit of effort.
///
/// ```
/// use stiction::control::laws::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
/// use stiction::positioner::{PdConfig, PdPositioner, Position, Target};
///
/// let config = PdConfig {
///     sample_time: 1e-3,
///     counts_per_turn: 100_000.0,
///     largest_effort: 5.0,
///     effort_step: 0.005,
///     kp: 60.0,
///     kd: 9.0,
///     velocity_window: 5,
/// };
/// let gains = SmoothRobustNonlinearGains { v_ms: 0.4, alpha: 100.0 };
/// let loop_ = PdPositioner::<SmoothRobustNonlinear>::new(&config, &gains)?;
/// let mut state = loop_.start();
/// // 100 counts are 0.36 deg: Kp asks for 0.38, and the law for all of 0.4.
/// let target = Target::at_rest(Position::from_counts(100));
/// assert_eq!(loop_.tick(&mut state, 0, target), 0.775);
/// # Ok::<(), stiction::positioner::Refused>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PdPositioner<L: Law> {
    law: L,
    pd: PdGains,
    velocity: Velocity,
    effort: EffortSteps,
    resolution: f32,
}

/// State of a PD loop from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PdState<S> {
    law: S,
    velocity: VelocityState,
    /// Counter at the last tick; none before the first.
    counts: Option<i32>,
    applied: f32,
    saturated: bool,
}

impl<L: Law> PdPositioner<L> {
    /// Validates configuration and gains, and prepares both.
    ///
    /// # Errors
    /// Returns the first field that is outside its range.
    pub fn new(config: &PdConfig, gains: &L::Gains) -> Result<Self, Refused> {
        let PdConfig { largest_effort, effort_step, .. } = *config;
        check("sample_time", config.sample_time, SAMPLE_TIME)?;
        check("counts_per_turn", config.counts_per_turn, COUNTS)?;
        check("largest_effort", largest_effort, RANGE)?;
        check("effort_step", effort_step, [1e-6 * largest_effort, largest_effort])?;
        check("kp", config.kp, [0.0, RANGE[1]])?;
        check("kd", config.kd, [0.0, RANGE[1]])?;
        check("velocity_window", config.velocity_window as f32, [2.0, MAX_WINDOW as f32])?;
        gains.validate().map_err(refused::<L::Gains>)?;
        let pd = PdGains { kp: config.kp.to_radians(), kd: config.kd.to_radians() };
        let resolution = 360.0 / config.counts_per_turn;
        let around = Loop {
            sample_time: config.sample_time,
            resolution,
            full_scale: largest_effort,
            lsb: effort_step,
            kp: pd.kp,
            motor: MotorEncoder::NONE,
        };
        Ok(Self {
            law: L::new(gains, &around),
            pd,
            velocity: Velocity::new(config.velocity_window, resolution, config.sample_time),
            effort: EffortSteps::new(largest_effort, effort_step),
            resolution,
        })
    }

    /// Returns the state of a joint at rest, before the first tick.
    pub fn start(&self) -> PdState<L::State> {
        PdState::default()
    }

    /// Runs one tick with the counter's position (it can wrap) and the target, and returns the
    /// effort until the next tick, which must be applied at once.
    pub fn tick(&self, state: &mut PdState<L::State>, counts: i32, target: Target) -> f32 {
        let travel = counts.wrapping_sub(state.counts.unwrap_or(counts));
        state.counts = Some(counts);
        let velocity = self.velocity.update(&mut state.velocity, travel);
        let setpoint = target.setpoint();
        let error = setpoint.position.ahead_of(counts) * self.resolution;
        let velocity_error = setpoint.velocity - velocity;
        let v_pd = if L::REPLACES_PD { 0.0 } else { self.pd.update(error, velocity_error) };
        let PdState { applied, saturated, .. } = *state;
        let input = LawInput {
            counts,
            #[cfg(feature = "two-encoders")]
            motor_counts: counts,
            travel,
            setpoint,
            error,
            velocity,
            velocity_error,
            v_pd,
            applied,
            saturated,
        };
        let asked = v_pd + self.law.update(&mut state.law, &input);
        let is_finite = asked.is_finite() && setpoint.is_finite();
        if !is_finite {
            // Values that the law has learned need not be numbers either.
            state.law = L::State::default();
        }
        (state.applied, state.saturated) = self.effort.apply(if is_finite { asked } else { 0.0 });
        state.applied
    }

    /// Resets the state. Call it before the next tick if the output was off or the counter was set.
    pub fn restart(&self, state: &mut PdState<L::State>) {
        *state = self.start();
    }
}
