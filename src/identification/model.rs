//! The regression of an identification: which columns there are, and which of them a joint needs.
//!
//! ```text
//! u = J a + B v + C d + off + g_s sin q + g_c cos q + S d exp(-(v / v_s)^2) + delay u'
//! ```
//!
//! Each row is the mean of this over a window (`window.rs`); `d` is the sense of the motion. `v_s`
//! is not linear, so the triangle has the exponential for seven speeds, from the slowest of the map
//! to half of the fastest one, in equal ratios. What lies between two of them is interpolated by a
//! cubic through four, in steps of a sixteenth. The search is over every fourth of these, and then
//! around the best; all else is linear, and comes from the same triangle.
//! So the level of sliding is precise, and the Stribeck curve is an outline.
//!
//! Gravity and the Stribeck term are taken if they explain more than chance would: if they lower
//! the sum of squares by ten times what as many columns of noise would lower it (an F ratio of 10),
//! and gravity only where the joint has gone through 60 degrees. A smaller angle does not tell it
//! from the offset.
//!
//! The standard deviations suppose that the errors of the rows are independent and alike. The
//! errors of a model that does not fit are neither.
//!
//! A constant load and a friction that differs between both senses are the same two numbers: the
//! levels either way are `C + off` and `C - off`.

use serde::{Deserialize, Serialize};

use super::givens::{Solution, Triangle};
use super::window::Row;

/// Number of speeds for which there is a Stribeck column.
pub const CANDIDATES: usize = 7;
/// Number of columns: seven that are linear, and these.
pub const COLUMNS: usize = 7 + CANDIDATES;
const ELEMENTS: usize = COLUMNS * (COLUMNS + 1) / 2;
/// Number of the columns of a fit: seven, one Stribeck term, and what that changes by from one step
/// of the search to the next.
const FITTED: usize = 9;
type Fit = Triangle<FITTED, 45>;

/// The places of the columns.
const COULOMB: usize = 3;
const OFFSET: usize = 4;
const STRIBECK: usize = 7;
const SPEED: usize = 8;

/// The F ratio beyond which a term is taken.
const TELLING: f32 = 10.0;
/// The angle from which on gravity is told from an offset, deg.
const WIDE: f32 = 60.0;
/// Steps of the search from one candidate to the next, and of the first, coarse search.
const STEPS: usize = 16;
const COARSE: usize = 4;
/// The part of a column that others have to leave of it. `f32` has seven digits, and a hundred rows
/// cost one of them.
const TOLERANCE: f32 = 1e-4;

/// The regression of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Model {
    triangle: Triangle<COLUMNS, ELEMENTS>,
    /// The first of the candidates' speeds, deg/s, and the ratio from one to the next.
    first: f32,
    ratio: f32,
}

/// The parameters of a joint with their standard deviations, in volts, degrees and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// J, V/(deg/s^2).
    pub inertia: [f32; 2],
    /// B, V/(deg/s).
    pub viscous: [f32; 2],
    /// Delay of the effort, s.
    pub delay: [f32; 2],
    /// Level of sliding in the positive sense, load included, V.
    pub coulomb_positive: [f32; 2],
    /// Level of sliding in the negative sense, V, without its sign.
    pub coulomb_negative: [f32; 2],
    /// Level of sliding without the load: the mean of both senses, V.
    pub coulomb: [f32; 2],
    /// Constant load, V.
    pub offset: [f32; 2],
    /// Load of the sine and of the cosine of the position, V; zero: not found.
    pub gravity: [[f32; 2]; 2],
    /// What the level rises by towards standstill, V; zero: not found.
    pub stribeck: [f32; 2],
    /// The speed at which it has fallen to 1/e, deg/s; zero: not found.
    pub stribeck_velocity: f32,
    /// Root of the sum of squares that is left, as a share of that of the efforts.
    pub relative_residual: f32,
    /// Number of rows.
    pub rows: u32,
}

/// Returns the weights of values at 0, 1, 2 and 3 in the cubic through them, at x (Lagrange).
fn cubic(x: f32) -> [f32; 4] {
    let [a, b, c] = [x - 1.0, x - 2.0, x - 3.0];
    [-a * b * c / 6.0, 0.5 * x * b * c, -0.5 * x * a * c, x * a * b / 6.0]
}

impl Model {
    /// Returns a regression without a row, for speeds of sliding from `slow` to `fast`, deg/s.
    pub fn new(slow: f32, fast: f32) -> Self {
        let steps = (CANDIDATES - 1) as f32;
        let ratio = libm::expf(libm::logf((0.5 * fast / slow).max(1.1)) / steps);
        Self { triangle: Triangle::new(), first: slow, ratio }
    }

    /// Returns the number of rows.
    pub const fn rows(&self) -> u32 {
        self.triangle.rows()
    }

    /// Takes a row of sliding.
    pub fn add(&mut self, row: &Row) {
        let sense = if row.velocity < 0.0 { -1.0 } else { 1.0 };
        let [sin, cos] = row.gravity;
        let mut x = [0.0; COLUMNS];
        let linear = [row.acceleration, row.velocity, row.rate, sense, 1.0, sin, cos];
        x.iter_mut().zip(linear).for_each(|(to, from)| *to = from);
        let mut speed = self.first;
        for column in x.iter_mut().skip(STRIBECK) {
            let level = |velocity: f32| libm::expf(-(velocity / speed) * (velocity / speed));
            let both = level(row.velocity - row.spread) + level(row.velocity + row.spread);
            *column = 0.5 * sense * both;
            speed *= self.ratio;
        }
        self.triangle.add(x, row.effort);
    }

    /// Returns the fit with a Stribeck term at a step of the search, or none, with or without
    /// gravity. An absent term is held at zero. With `speed`, the step may be off by a little
    /// (Gauss and Newton).
    #[inline(never)]
    fn fit(&self, stribeck: Option<usize>, gravity: bool, speed: bool) -> Fit {
        let mut fit: Fit = self.triangle.chosen(|x| {
            let [j, b, delay, c, off, sin, cos, candidates @ ..] = x;
            let term = |step: usize| {
                let first = (step / STEPS).clamp(1, CANDIDATES - 3) - 1;
                let x = step as f32 / STEPS as f32 - first as f32;
                candidates.iter().skip(first).zip(cubic(x)).map(|(c, weight)| c * weight).sum()
            };
            let [here, change]: [f32; 2] = stribeck.map_or([0.0; 2], |step| {
                let next = if speed { term(step + 1) } else { 0.0 };
                let here = term(step);
                [here, if speed { next - here } else { 0.0 }]
            });
            let [sin, cos] = if gravity { [*sin, *cos] } else { [0.0; 2] };
            [*j, *b, *delay, *c, *off, sin, cos, here, change]
        });
        if !gravity {
            fit.hold_at_zero(5);
            fit.hold_at_zero(6);
        }
        if stribeck.is_none() {
            fit.hold_at_zero(STRIBECK);
        }
        if stribeck.is_none() || !speed {
            fit.hold_at_zero(SPEED);
        }
        fit
    }

    /// Returns the parameters, if the rows tell them. `range` is the angle that the joint has gone
    /// through, deg.
    pub fn estimate(&self, range: f32) -> Option<Estimate> {
        let freedom = self.rows().saturating_sub(FITTED as u32) as f32;
        let tells = |more: &Fit, less: &Fit, columns: f32| {
            let gained = less.unexplained() - more.unexplained();
            gained * freedom > TELLING * columns * more.unexplained()
                && more.solve(TOLERANCE).is_some()
        };
        let mut best = (None, self.fit(None, false, false));
        let mut gravity = false;
        if range >= WIDE {
            let with = self.fit(None, true, false);
            if tells(&with, &best.1, 2.0) {
                (best.1, gravity) = (with, true);
            }
        }
        let without = best.1;
        let last = STEPS * (CANDIDATES - 1);
        let mut look = |step: usize| {
            let with = self.fit(Some(step), gravity, false);
            let falls = with.solve(TOLERANCE).is_some_and(|fit| fit.values[STRIBECK] > 0.0);
            // Two numbers are found: the level and its speed.
            if falls && tells(&with, &without, 2.0) && with.unexplained() < best.1.unexplained() {
                best = (Some(step), with);
            }
            best.0
        };
        let mut coarse = None;
        for step in (0..=last).step_by(COARSE) {
            coarse = look(step);
        }
        if let Some(around) = coarse {
            for step in around.saturating_sub(COARSE - 1)..=(around + COARSE - 1).min(last) {
                look(step);
            }
        }
        let (step, fit) = best;
        let solution = fit.solve(TOLERANCE)?;
        let of_step = libm::expf(libm::logf(self.ratio) / STEPS as f32);
        let estimate = Estimate::of(&solution);
        let found = |is_found: bool, value: [f32; 2]| if is_found { value } else { [0.0; 2] };
        let speed = |step: usize| (0..step).fold(self.first, |speed, _| speed * of_step);
        Some(Estimate {
            stribeck_velocity: step.map_or(0.0, speed),
            relative_residual: fit.relative_residual(),
            rows: self.rows(),
            gravity: estimate.gravity.map(|value| found(gravity, value)),
            stribeck: found(step.is_some(), estimate.stribeck),
            ..estimate
        })
    }
}

impl Estimate {
    fn of(solution: &Solution<FITTED>) -> Self {
        let Solution { values, deviations, .. } = solution;
        let [inertia, viscous, delay, coulomb, offset, sin, cos, stribeck, _] = *values;
        let [d_j, d_b, d_delay, d_c, d_off, d_sin, d_cos, d_s, _] = *deviations;
        let both = |sign: f32| {
            let mut weights = [0.0; FITTED];
            (weights[COULOMB], weights[OFFSET]) = (1.0, sign);
            solution.deviation_of(&weights)
        };
        Self {
            inertia: [inertia, d_j],
            viscous: [viscous, d_b],
            delay: [delay, d_delay],
            coulomb_positive: [coulomb + offset, both(1.0)],
            coulomb_negative: [coulomb - offset, both(-1.0)],
            coulomb: [coulomb, d_c],
            offset: [offset, d_off],
            gravity: [[sin, d_sin], [cos, d_cos]],
            stribeck: [stribeck, d_s],
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f32; 5] = [5e-4, 2e-3, 1.5e-3, 0.35, 0.04];

    /// Rows of a joint with errors of `noise` V, with a Stribeck term (V, deg/s) and gravity (V).
    fn model([drop, speed]: [f32; 2], gravity: f32, noise: f32) -> Model {
        let mut model = Model::new(1.0, 60.0);
        let mut state = 11u32;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state as i32 as f32 / (1u32 << 31) as f32
        };
        for index in 0..240 {
            let sense = if index % 2 == 0 { 1.0 } else { -1.0 };
            let velocity = sense * libm::powf(60.0, (index % 12) as f32 / 11.0);
            let [acceleration, rate] = [400.0 * random(), 4.0 * random()];
            let angle = 1.5 * random();
            let [j, b, delay, c, off] = TRUTH;
            let level = c + drop * libm::expf(-(velocity / speed).powi(2));
            let effort = j * acceleration
                + b * velocity
                + delay * rate
                + sense * level
                + off
                + gravity * angle.sin()
                + noise * random();
            let gravity = [angle.sin(), angle.cos()];
            model.add(&Row { acceleration, velocity, spread: 0.0, effort, rate, gravity });
        }
        model
    }

    fn close(found: [f32; 2], truth: f32) -> bool {
        (found[0] - truth).abs() < 5.0 * found[1] + 1e-5
    }

    #[test]
    fn what_is_not_there_is_not_found_and_what_is_there_lies_within_its_deviations() {
        let estimate = model([0.0, 1.0], 0.0, 0.003).estimate(90.0).unwrap();
        let [j, b, delay, c, off] = TRUTH;
        for (found, truth) in [
            (estimate.inertia, j),
            (estimate.viscous, b),
            (estimate.delay, delay),
            (estimate.coulomb, c),
            (estimate.offset, off),
            (estimate.coulomb_positive, c + off),
            (estimate.coulomb_negative, c - off),
        ] {
            assert!(close(found, truth), "{found:?} {truth} {estimate:?}");
            assert!(found[1] < 0.2 * truth, "{found:?} {truth}");
        }
        assert_eq!((estimate.gravity, estimate.stribeck_velocity), ([[0.0; 2]; 2], 0.0));
        // Uniform errors of 0.003 V have a deviation of 0.00173 V; efforts are about 0.4 V.
        assert!((0.002..0.008).contains(&estimate.relative_residual), "{estimate:?}");
    }

    #[test]
    fn the_weights_are_exact_for_a_cubic() {
        let f = |x: f32| 0.3 + x * (1.0 - x * (0.7 - 0.2 * x));
        for x in [-0.25, 0.0, 0.5, 1.75, 3.0] {
            let sum: f32 =
                cubic(x).iter().enumerate().map(|(i, weight)| weight * f(i as f32)).sum();
            assert!((sum - f(x)).abs() < 1e-5, "{x}");
        }
    }

    #[test]
    fn a_stribeck_curve_and_gravity_are_found_where_they_are() {
        for speed in [2.0, 5.0, 9.0] {
            let model = model([0.3, speed], 0.1, 0.003);
            let estimate = model.estimate(90.0).unwrap();
            assert!((estimate.coulomb[0] / 0.35 - 1.0).abs() < 0.03, "{estimate:?}");
            assert!((estimate.stribeck[0] / 0.3 - 1.0).abs() < 0.15, "{estimate:?}");
            assert!((estimate.stribeck_velocity / speed - 1.0).abs() < 0.35, "{estimate:?}");
            assert!(close(estimate.gravity[0], 0.1), "{estimate:?}");
            // Within a narrow angle, gravity is not asked for, and shows as what does not fit.
            let narrow = model.estimate(59.0).unwrap();
            assert_eq!(narrow.gravity, [[0.0; 2]; 2]);
            assert!(narrow.relative_residual > 2.0 * estimate.relative_residual);
        }
    }

    #[test]
    fn rows_of_one_sense_tell_nothing() {
        let mut model = Model::new(1.0, 60.0);
        for index in 0..50 {
            let velocity = 1.0 + index as f32;
            let acceleration = (index * index % 17) as f32;
            let gravity = [0.0, 1.0];
            let row = Row { acceleration, velocity, spread: 0.0, effort: 0.4, rate: 0.0, gravity };
            model.add(&row);
        }
        assert_eq!(model.estimate(90.0), None);
    }
}
