//! Step size control and location of switches, for the joints that locate their switches.

use super::runge_kutta::growth;
use crate::solver::roots::first_falling_zero;

/// Shortest step, s, whatever its error.
pub const SHORTEST_S: f64 = 1e-10;

/// Errors allowed in a step: of a position in counts, of a velocity in counts per second.
const ALLOWED_COUNTS: f64 = 1e-4;
const ALLOWED_COUNTS_PER_S: f64 = 1e-2;

/// A switch is located to this part of the error that is allowed.
pub const LOCATED: f64 = 1e-3;

/// Largest number of switches in a sample; the rest of the sample is skipped.
pub const MOST_SWITCHES: usize = 200;

/// The length of the next step, and the errors that are allowed.
#[derive(Clone, Debug)]
pub struct Pace {
    /// Of a position.
    pub position: f64,
    /// Of a velocity.
    pub velocity: f64,
    /// What the next step should be, s.
    pub step_s: f64,
}

impl Pace {
    /// Errors far below a count.
    pub const fn of_count(count: f64) -> Self {
        let (position, velocity) = (ALLOWED_COUNTS * count, ALLOWED_COUNTS_PER_S * count);
        Self { position, velocity, step_s: 1.0 }
    }

    /// The same for a body on a bristle that swings at `frequency` (rad/s).
    pub const fn of_bristle(count: f64, frequency: f64) -> Self {
        let pace = Self::of_count(count);
        Self { velocity: frequency * pace.position, ..pace }
    }

    /// Judges a step by its errors, which alternate between positions and velocities; gives a
    /// shorter one if they are not allowed.
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
            // Not a number stays, other than by `max`.
            let part = (part / allowed[i % 2]).abs();
            error = if part <= error { error } else { part };
        }
        if error <= 1.0 || h <= SHORTEST_S {
            if h < longest_s {
                self.step_s = h * growth(error);
            } else if error < 1e-2 {
                // What cut the step short says little about a longer one.
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
    // Where the last switch was located there may be less than nothing left.
    let from = begin[0].max(0.0);
    if from == 0.0 && end[0] <= 0.0 && begin[1] <= 0.0 {
        return Some(0.0);
    }
    let (s0, s1, rise) = (h * begin[1], h * end[1], end[0] - from);
    let cubic = [from, s0, 3.0 * rise - 2.0 * s0 - s1, -2.0 * rise + s0 + s1, 0.0];
    first_falling_zero(&cubic).or((end[0] <= 0.0).then_some(1.0))
}
