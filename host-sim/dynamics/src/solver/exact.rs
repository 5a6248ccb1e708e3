//! The robot axis between two switches, in closed form.
//!
//! While the axis slips in direction `s` under a constant effort, with `lambda = kappa b` and
//! `a = kappa (v - s F_d)`:
//!
//! ```text
//! velocity(t) = velocity_0 e^(-lambda t) + a phi1(t)
//! position(t) = position_0 + velocity_0 phi1(t) + a phi2(t)
//! phi1 = (1 - e^(-lambda t)) / lambda,   phi2 = (t - phi1) / lambda
//! ```
//!
//! It comes to a halt at `t* = ln(1 - lambda velocity_0 / a) / lambda`. There it sticks if `|v| <=
//! F_s`, and turns otherwise. A stuck axis has velocity exactly zero and does not creep. This form
//! has no division by `b`: as `lambda` goes to zero it goes to `t` and `t^2/2`, that of an axis
//! without viscous friction.
//!
//! Guarantees: exact to rounding, whatever the sample time; every switch inside a sample is found.
//! Limits: only this one mechanism.

use super::{AxisSolver, Event, EventKind};
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;

/// The three functions of time in the closed form.
#[derive(Clone, Copy, Debug)]
struct Decay {
    duration_s: f64,
    exp: f64,
    phi1: f64,
    phi2: f64,
}

impl Decay {
    #[inline]
    fn over(duration_s: f64, lambda: f64) -> Self {
        let x = lambda * duration_s;
        // Below this the differences lose digits, and five terms of the series are exact: x^5/720 <
        // 2e-18.
        if x < 1e-3 {
            let phi1 = duration_s
                * (1.0 + x * (-1.0 / 2.0 + x * (1.0 / 6.0 + x * (-1.0 / 24.0 + x / 120.0))));
            let phi2 = duration_s
                * duration_s
                * (1.0 / 2.0
                    + x * (-1.0 / 6.0 + x * (1.0 / 24.0 + x * (-1.0 / 120.0 + x / 720.0))));
            return Self { duration_s, exp: 1.0 - lambda * phi1, phi1, phi2 };
        }
        let phi1 = -libm::expm1(-x) / lambda;
        Self { duration_s, exp: 1.0 - lambda * phi1, phi1, phi2: (duration_s - phi1) / lambda }
    }
}

/// The robot axis with exact Karnopp friction (velocity zero while stuck).
#[derive(Clone, Debug)]
pub struct ExactAxis {
    gain: f64,
    /// `kappa b` with the winding as it is, and with a closed one, 1/s.
    lambda: f64,
    closed: f64,
    position: f64,
    velocity: f64,
    /// Functions of the usual interval, computed once.
    sample: Decay,
}

impl ExactAxis {
    /// Creates the axis at rest at zero. `sample_time_s` is the most frequent interval, s.
    pub fn at_rest(axis: &RobotAxis, sample_time_s: f64) -> Self {
        let lambda = axis.gain * axis.viscous;
        let sample = Decay::over(sample_time_s, lambda);
        Self { gain: axis.gain, lambda, closed: lambda, position: 0.0, velocity: 0.0, sample }
    }

    /// Returns the axis with another position (deg) and velocity (deg/s).
    pub fn with_state(self, position: f64, velocity: f64) -> Self {
        Self { position, velocity, ..self }
    }

    /// Returns the time until an axis with acceleration `a` halts, s; negative or not a number if
    /// it never halts.
    #[inline]
    fn time_to_halt(&self, a: f64) -> f64 {
        let ratio = -self.velocity / a;
        if self.lambda * ratio < 1e-9 {
            ratio * (1.0 - 0.5 * self.lambda * ratio)
        } else {
            libm::log1p(self.lambda * ratio) / self.lambda
        }
    }
}

impl AxisSolver for ExactAxis {
    #[inline]
    fn advance(&mut self, v: f64, duration_s: f64, friction: &Coulomb, on: &mut impl FnMut(Event)) {
        let mut remaining = duration_s;
        // Slip, halt, slip the other way: a constant effort allows no more than one halt and one
        // break.
        for _ in 0..3 {
            let mut direction = self.velocity.signum();
            if self.velocity == 0.0 {
                if v.abs() <= friction.stick {
                    return;
                }
                direction = v.signum();
                // After a halt inside this interval the event was a reversal, reported there.
                if remaining == duration_s {
                    on(Event { time_s: 0.0, kind: EventKind::Break });
                }
            }
            let a = self.gain * (v - direction * friction.slip);
            let decay = if remaining == self.sample.duration_s {
                self.sample
            } else {
                Decay::over(remaining, self.lambda)
            };
            let velocity = self.velocity * decay.exp + a * decay.phi1;
            if velocity * direction > 0.0 || !velocity.is_finite() {
                self.position += self.velocity * decay.phi1 + a * decay.phi2;
                self.velocity = velocity;
                return;
            }
            // Without a deceleration, the velocity can only have decayed to zero: the halt is then
            // at the end of the interval.
            let halt = self.time_to_halt(a);
            let halt = if halt.is_finite() { halt.max(0.0).min(remaining) } else { remaining };
            let to_halt = Decay::over(halt, self.lambda);
            self.position += self.velocity * to_halt.phi1 + a * to_halt.phi2;
            self.velocity = 0.0;
            let kind =
                if v.abs() <= friction.stick { EventKind::Stick } else { EventKind::Reverse };
            on(Event { time_s: duration_s - remaining + halt, kind });
            remaining -= halt;
            if remaining <= 0.0 {
                return;
            }
        }
    }

    #[inline]
    fn position(&self) -> f64 {
        self.position
    }

    #[inline]
    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn open_winding(&mut self, back_emf: f64) {
        // A file can have less viscous friction than back-EMF.
        let lambda = (self.closed - self.gain * back_emf).max(0.0);
        if lambda != self.lambda {
            self.lambda = lambda;
            self.sample = Decay::over(self.sample.duration_s, lambda);
        }
    }

    #[inline]
    fn stuck(&self) -> bool {
        self.velocity == 0.0
    }

    fn derivative_evaluations(&self) -> u64 {
        0
    }
}
