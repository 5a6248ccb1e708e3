//! The thesis's own method: fourth-order Runge-Kutta with a fixed step, and Karnopp's friction with
//! a velocity band.
//!
//! ```text
//! F_f = F_d sgn(V)          |V| >  D_v
//!     = F_i                 |V| <= D_v and |F_i| <= F_s
//!     = F_s sgn(F_i)        |V| <= D_v and |F_i| >  F_s        (eq. 1, whose third row prints sgn(V))
//! ```
//!
//! with the axis's velocity V and, for the input force F_i, its effort v in volts. Inside the band
//! the velocity is *not* set to zero: a "stuck" axis coasts at up to `D_v` (section 2.3.1.2).
//!
//! Limits: a step that crosses the band (width 2e-4 deg/s in Table 21) misses it, and the stuck
//! axis creeps; with an acceleration of `kappa (F_s + F_d)` = 21 deg/s^2 the band is passed in
//! 10 us. Use steps of 10 us or less, or the exact solver. Shorter steps reduce the error only down
//! to the error of the band.

use super::{AxisSolver, Event, EventKind};
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;

/// The robot axis with banded Karnopp friction, by RK4.
#[derive(Clone, Debug)]
pub struct Rk4Axis {
    gain: f64,
    viscous: f64,
    band: f64,
    step_s: f64,
    position: f64,
    velocity: f64,
    in_band: bool,
    evaluations: u64,
}

impl Rk4Axis {
    /// Creates the axis at rest at zero, with steps of at most `step_s` and the velocity band D_v
    /// `band`, deg/s.
    pub fn at_rest(axis: &RobotAxis, band: f64, step_s: f64) -> Self {
        Self {
            gain: axis.gain,
            viscous: axis.viscous,
            band,
            step_s,
            position: 0.0,
            velocity: 0.0,
            in_band: true,
            evaluations: 0,
        }
    }

    /// Returns the axis with another position (deg) and velocity (deg/s).
    pub fn with_state(self, position: f64, velocity: f64) -> Self {
        Self { position, velocity, in_band: velocity.abs() <= self.band, ..self }
    }

    fn acceleration(&self, velocity: f64, v: f64, friction: &Coulomb) -> f64 {
        let opposing = if velocity.abs() > self.band {
            friction.slip * velocity.signum()
        } else {
            v.clamp(-friction.stick, friction.stick)
        };
        self.gain * (v - opposing - self.viscous * velocity)
    }

    fn step(&mut self, v: f64, h: f64, friction: &Coulomb) {
        let v0 = self.velocity;
        let a1 = self.acceleration(v0, v, friction);
        let v2 = v0 + 0.5 * h * a1;
        let a2 = self.acceleration(v2, v, friction);
        let v3 = v0 + 0.5 * h * a2;
        let a3 = self.acceleration(v3, v, friction);
        let v4 = v0 + h * a3;
        let a4 = self.acceleration(v4, v, friction);
        self.position += h / 6.0 * (v0 + 2.0 * v2 + 2.0 * v3 + v4);
        self.velocity += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        self.evaluations += 4;
    }
}

impl AxisSolver for Rk4Axis {
    fn advance(&mut self, v: f64, duration_s: f64, friction: &Coulomb, on: &mut impl FnMut(Event)) {
        // Rounding above a whole number of steps must not add a step.
        let steps = (duration_s / self.step_s - 1e-9).ceil().max(1.0);
        let h = duration_s / steps;
        for i in 1..=steps as u64 {
            let before = self.velocity;
            self.step(v, h, friction);
            let in_band = self.velocity.abs() <= self.band;
            let kind = match (self.in_band, in_band) {
                (true, false) => Some(EventKind::Break),
                (false, true) => Some(EventKind::Stick),
                (false, false) if before * self.velocity < 0.0 => Some(EventKind::Reverse),
                _ => None,
            };
            self.in_band = in_band;
            if let Some(kind) = kind {
                on(Event { time_s: i as f64 * h, kind });
            }
        }
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn stuck(&self) -> bool {
        self.in_band
    }

    fn derivative_evaluations(&self) -> u64 {
        self.evaluations
    }
}
