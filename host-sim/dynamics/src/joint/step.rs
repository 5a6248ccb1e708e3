//! Step size control and location of switches, for the joints that locate their switches.

use super::runge_kutta::growth;
use crate::solver::roots::first_falling_zero;

/// Shortest step, s, whatever its error.
pub const SHORTEST_S: f64 = 1e-10;

/// Errors allowed in a step: of a position in counts, of a velocity in counts per second.
const ALLOWED_COUNTS: f64 = 1e-4;
const ALLOWED_COUNTS_PER_S: f64 = 1e-2;

/// Accuracy to which a switch is located, as a part of the allowed error.
pub const LOCATED: f64 = 1e-3;

/// Largest number of switches in a sample; the rest of the sample is skipped.
pub const MOST_SWITCHES: usize = 200;

/// Length of the next step, and the allowed errors of a step.
#[derive(Clone, Debug)]
pub struct Pace {
    /// Allowed error of a position, rad.
    pub position: f64,
    /// Allowed error of a velocity, rad/s.
    pub velocity: f64,
    /// Proposed length of the next step, s.
    pub step_s: f64,
}

impl Pace {
    /// Allows errors far below a count (rad).
    pub const fn of_count(count: f64) -> Self {
        let (position, velocity) = (ALLOWED_COUNTS * count, ALLOWED_COUNTS_PER_S * count);
        Self { position, velocity, step_s: 1.0 }
    }

    /// Allows the same error of a position, for a body on a bristle that swings at `frequency`
    /// (rad/s): the allowed error of the velocity is `frequency` times that of the position.
    pub const fn of_bristle(count: f64, frequency: f64) -> Self {
        let pace = Self::of_count(count);
        Self { velocity: frequency * pace.position, ..pace }
    }

    /// Compares the errors of a step, which alternate between positions and velocities, with the
    /// allowed ones. Returns a shorter length (s) if they are too large; `None` accepts the step.
    #[inline]
    pub fn shorter<const N: usize>(
        &mut self,
        errors: &[f64; N],
        h: f64,
        longest_s: f64,
    ) -> Option<f64> {
        let allowed = [self.position, self.velocity];
        let mut error: f64 = 0.0;
        for (i, part) in errors.iter().enumerate() {
            // Unlike `max`, this keeps an error that is not a number.
            let part = (part / allowed[i % 2]).abs();
            error = if part <= error { error } else { part };
        }
        if error <= 1.0 || h <= SHORTEST_S {
            if h < longest_s {
                self.step_s = h * growth(error);
            } else if error < 1e-2 {
                // The step was cut short: its error does not predict that of a longer one.
                self.step_s = self.step_s.max(2.0 * h);
            }
            return None;
        }
        self.step_s = (h * growth(error).min(0.9)).max(SHORTEST_S);
        Some(self.step_s)
    }
}

/// Switch function: a value that is positive until a switch, and its slope over time.
pub type SwitchFunction = [f64; 2];

/// Returns the share of a step at which a switch function falls through zero, by a cubic.
#[inline]
pub fn first_fall(begin: SwitchFunction, end: SwitchFunction, h: f64) -> Option<f64> {
    if end[0] > 0.0 && (begin[1] >= 0.0 || end[1] <= 0.0) {
        return None;
    }
    // At a switch that was just located, the value can be slightly negative.
    let from = begin[0].max(0.0);
    if from == 0.0 && end[0] <= 0.0 && begin[1] <= 0.0 {
        return Some(0.0);
    }
    let (s0, s1, rise) = (h * begin[1], h * end[1], end[0] - from);
    let cubic = [from, s0, 3.0 * rise - 2.0 * s0 - s1, -2.0 * rise + s0 + s1, 0.0];
    first_falling_zero(&cubic).or((end[0] <= 0.0).then_some(1.0))
}
