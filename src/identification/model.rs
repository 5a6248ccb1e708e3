//! The regression of an identification: its columns, and the choice of those that a joint needs.
//!
//! ```text
//! u = J a + B v + C d + off + g_s sin q + g_c cos q + S d exp(-(v / v_s)^2) + delay u'
//! ```
//!
//! Each row is the mean of this equation over a window (`window.rs`); `d` is the sense of the
//! motion. The equation is not linear in `v_s`, so the triangle has one column of the exponential
//! for each of seven speeds, from the slowest of the map to half of the fastest one, in equal
//! ratios. Between two of them, a cubic through four columns interpolates in steps of a sixteenth.
//! The search tries every fourth step, and then the steps around the best; all other parameters are
//! linear, and come from the same triangle. So the level of sliding is precise, and the Stribeck
//! curve is an outline.
//!
//! The fit includes gravity or the Stribeck term if the term lowers the sum of squares by ten times
//! as much as the same number of columns of noise would (an F ratio of 10). Gravity is included
//! only if the joint has gone through 60 degrees: within a smaller angle, it cannot be
//! distinguished from the offset.
//!
//! Standard deviations come from the largest of three variances of a row. The first is the residual
//! sum of squares over its degrees of freedom; it suffices if the errors of the rows are
//! independent and alike. The second is that of the swings alone: only they show the inertia, and
//! their errors are the larger ones. It is the mean square of the residual that each row of a swing
//! had against the triangle of all columns when it was added (recursive residuals; Brown, Durbin
//! and Evans, *J. Royal Statistical Society* B 37, 1975). The third is the lack of fit (Draper and
//! Smith, *Applied Regression Analysis*): the sum of squares that the columns left out of the fit
//! would still explain, over their number, times the square of Student's t over 1.96. The errors of
//! a model that does not fit are few and large, and there are only as many of them as columns that
//! show them.
//!
//! A constant load cannot be distinguished from a friction that differs between both senses: the
//! levels are `C + off` in the positive sense and `C - off` in the negative one.

use serde::{Deserialize, Serialize};

use super::givens::{Solution, Triangle};
use super::window::RegressionRow;

/// Number of speeds for which there is a Stribeck column.
pub const CANDIDATES: usize = 7;
/// Number of columns: seven linear ones, and the Stribeck columns.
pub const COLUMNS: usize = 7 + CANDIDATES;
const ELEMENTS: usize = COLUMNS * (COLUMNS + 1) / 2;
/// Number of columns of a fit: the seven linear ones, one Stribeck term, and the change of that
/// term from one step of the search to the next.
const FITTED: usize = 9;
type Fit = Triangle<FITTED, 45>;

/// Places of columns: constant friction, offset, Stribeck term, and the change of that term.
const COULOMB: usize = 3;
const OFFSET: usize = 4;
const STRIBECK: usize = 7;
const SPEED: usize = 8;

/// F ratio above which the fit includes a term.
const TELLING: f32 = 10.0;
/// Least angle of travel at which gravity can be distinguished from an offset, deg.
const WIDE: f32 = 60.0;
/// Steps of the search from one candidate speed to the next, the last step, and the step width of
/// the first, coarse search.
const STEPS: usize = 16;
const LAST: u8 = (STEPS * (CANDIDATES - 1)) as u8;
const COARSE: u8 = 4;
/// Steps that a piece of the coarse search tries, and number of pieces in a pass: the coarse ones,
/// and the one around the best step.
const LOOKS: u8 = 5;
const PIECES: u8 = LAST / COARSE / LOOKS + 2;
const _: () = assert!(STEPS * (CANDIDATES - 1) + LOOKS as usize * COARSE as usize <= 255);
/// Number of columns that a fit leaves out with none, one and both of its terms, and Student's t at
/// 95 % (two-sided) for that number of degrees of freedom, over the normal distribution's 1.96.
const LACK: [[f32; 2]; 3] = [[9.0, 1.154], [7.0, 1.207], [5.0, 1.312]];
/// Columns that only the swings determine: the inertia's and the delay's.
const ONLY_IN_SWINGS: u32 = 2;
/// Least part of a column's length that the other columns must not explain. `f32` has seven digits,
/// and a hundred rows cost one of them.
const TOLERANCE: f32 = 1e-4;

/// Number of passes of the search: the second one finds a term that the other term has hidden.
const PASSES: u8 = 2;

/// The search for the terms that a joint needs: gravity, and the step of the Stribeck speed.
///
/// The search runs piece by piece, since the other tasks, which the watchdog monitors, have to run.
/// All pieces at once took longer than the 15 ms watchdog timeout of an emulated board. There a
/// piece ends within a quarter of the shortest timeout (`tests/image/identification.rs`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Search {
    /// Number of pieces that are done.
    pieces: u8,
    best: Option<u8>,
    gravity: bool,
}

/// The regression of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Model {
    triangle: Triangle<COLUMNS, ELEMENTS>,
    /// The first of the candidates' speeds, deg/s, and the ratio from one to the next.
    first: f32,
    ratio: f32,
    /// Residual sum of squares of all columns after the last row of a leg, and the number of rows
    /// until then.
    legs: (f32, u32),
}

/// The parameters of a joint with their standard deviations, in volts, degrees and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelEstimate {
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
    /// Gravity load, V: the factors of the sine and of the cosine of the position; zero: not found.
    pub gravity: [[f32; 2]; 2],
    /// Rise of the level of sliding towards standstill, V; zero: not found.
    pub stribeck: [f32; 2],
    /// Speed at which that rise has fallen to 1/e, deg/s; zero: not found.
    pub stribeck_velocity: f32,
    /// Relative residual: root of the ratio of the residual sum of squares to that of the efforts.
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
        Self { triangle: Triangle::new(), first: slow, ratio, legs: (0.0, 0) }
    }

    /// Returns the number of rows.
    pub const fn rows(&self) -> u32 {
        self.triangle.rows()
    }

    /// Adds a row of sliding: of a leg at a constant speed, or of a swing.
    pub fn add(&mut self, row: &RegressionRow, is_of_leg: bool) {
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
        if is_of_leg {
            self.legs = (self.triangle.unexplained(), self.rows());
        }
    }

    /// Returns the fit with or without a Stribeck term, which is at a step of the search, and with
    /// or without gravity. An absent term is held at zero. With `speed`, the fit also has a column
    /// for a small error of the step (Gauss and Newton).
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

    fn freedom(&self) -> f32 {
        self.rows().saturating_sub(FITTED as u32) as f32
    }

    /// Returns whether the two additional parameters of `more` explain more than chance would.
    fn is_significant(&self, more: &Fit, less: &Fit) -> bool {
        let gained = less.unexplained() - more.unexplained();
        gained * self.freedom() > TELLING * 2.0 * more.unexplained()
            && more.values(TOLERANCE).is_some()
    }

    /// Returns the sum of squares from which the standard deviations follow: `freedom` times the
    /// largest of the three variances of a row.
    fn uncertain(&self, fit: &Fit, terms: usize, freedom: f32) -> f32 {
        let left = fit.unexplained();
        let [columns, widened] = LACK[terms.min(LACK.len() - 1)];
        let unexplained = self.triangle.unexplained();
        let lack = (left - unexplained) / columns * widened * widened;
        let (of_legs, before) = self.legs;
        let swings = self.rows().saturating_sub(before + ONLY_IN_SWINGS) as f32;
        let of_swings = if swings > 0.0 { (unexplained - of_legs) / swings } else { 0.0 };
        left.max(lack.max(of_swings) * freedom)
    }

    /// Returns the parameters, if the rows determine them. `range` is the angle that the joint has
    /// gone through, deg.
    #[cfg(test)]
    fn estimate(&self, range: f32) -> Option<ModelEstimate> {
        self.estimate_at(&Search::whole(self, range))
    }

    /// Returns the parameters at the end of a search, if the rows determine them.
    #[inline(never)]
    pub fn estimate_at(&self, search: &Search) -> Option<ModelEstimate> {
        let Search { gravity, .. } = *search;
        let step = search.best.map(usize::from);
        let mut fit = self.fit(step, gravity, false);
        // The Stribeck speed is one more parameter, which widens the deviations of the others.
        if let Some(step) = step {
            let with = self.fit(Some(step.min(usize::from(LAST) - 1)), gravity, true);
            if with.values(TOLERANCE).is_some() {
                fit = with;
            }
        }
        let relative_residual = fit.relative_residual();
        let terms = usize::from(gravity) + usize::from(step.is_some());
        fit.suppose_unexplained(self.uncertain(&fit, terms, self.freedom()));
        let solution = fit.solve(TOLERANCE)?;
        let of_step = libm::expf(libm::logf(self.ratio) / STEPS as f32);
        let estimate = ModelEstimate::of(&solution);
        let found = |is_found: bool, value: [f32; 2]| if is_found { value } else { [0.0; 2] };
        let speed = |step: usize| (0..step).fold(self.first, |speed, _| speed * of_step);
        Some(ModelEstimate {
            stribeck_velocity: step.map_or(0.0, speed),
            relative_residual,
            rows: self.rows(),
            gravity: estimate.gravity.map(|value| found(gravity, value)),
            stribeck: found(step.is_some(), estimate.stribeck),
            ..estimate
        })
    }
}

impl Search {
    /// Runs a whole search at once, and returns it.
    pub fn whole(model: &Model, range: f32) -> Self {
        let mut search = Self::default();
        while !search.go_on(model, range) {}
        search
    }

    /// Runs one piece of the search, nine fits at most, and returns whether the search is over.
    /// `range` is the angle that the joint has gone through, deg.
    #[inline(never)]
    pub fn go_on(&mut self, model: &Model, range: f32) -> bool {
        let (pass, piece) = (self.pieces / PIECES, self.pieces % PIECES);
        if pass == PASSES {
            return true;
        }
        let mut best = model.fit(self.best.map(usize::from), self.gravity, false);
        if piece == 0 {
            let mut is_new = pass == 0;
            if !self.gravity && range >= WIDE {
                let with = model.fit(self.best.map(usize::from), true, false);
                if model.is_significant(&with, &best) {
                    (best, self.gravity, is_new) = (with, true, true);
                }
            }
            if !is_new {
                return true;
            }
        }
        self.pieces += 1;
        let without = model.fit(None, self.gravity, false);
        let coarse = piece * LOOKS * COARSE;
        let (first, last, by) = match self.best {
            _ if piece < PIECES - 1 => (coarse, coarse + (LOOKS - 1) * COARSE, COARSE),
            Some(around) => (around.saturating_sub(COARSE - 1), around + COARSE - 1, 1),
            None => return false,
        };
        for step in (first..=last.min(LAST)).step_by(by.into()) {
            let with = model.fit(Some(step.into()), self.gravity, false);
            // Two numbers are found: the level and its speed.
            let falls = with.values(TOLERANCE).is_some_and(|values| values[STRIBECK] > 0.0);
            if falls
                && model.is_significant(&with, &without)
                && with.unexplained() < best.unexplained()
            {
                (self.best, best) = (Some(step), with);
            }
        }
        false
    }
}

impl ModelEstimate {
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
            model.add(
                &RegressionRow { acceleration, velocity, spread: 0.0, effort, rate, gravity },
                true,
            );
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
            // Within a narrow angle, gravity is not fitted, and shows in the residual.
            let narrow = model.estimate(59.0).unwrap();
            assert_eq!(narrow.gravity, [[0.0; 2]; 2]);
            assert!(narrow.relative_residual > 2.0 * estimate.relative_residual);
        }
    }

    /// The first pass cannot distinguish a small load from what a large Stribeck term leaves.
    #[test]
    fn gravity_that_a_stribeck_curve_hides_is_found() {
        let estimate = model([1.0, 5.0], 0.02, 0.003).estimate(90.0).unwrap();
        assert!(close(estimate.gravity[0], 0.02), "{estimate:?}");
        assert!(estimate.gravity[0][0] > 0.015, "{estimate:?}");
    }

    /// Friction that falls as `1 / (1 + (v / v_s)^2)` instead of the exponential. With noise alone,
    /// the lack of fit is the variance of the residual times an F ratio with 7 degrees of freedom,
    /// which is below 2.7 in 99 of 100 cases. If the columns left out explained the whole residual,
    /// it would be `(240 - 9) / 7` times as much. Both are multiplied by 1.207 squared.
    #[test]
    fn what_the_model_does_not_know_widens_the_deviations_and_noise_does_not() {
        let ratio = |drop: f32| {
            let mut model = Model::new(1.0, 60.0);
            let mut state = 5u32;
            for index in 0..240 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let random = state as i32 as f32 / (1u32 << 31) as f32;
                let sense = if index % 2 == 0 { 1.0 } else { -1.0 };
                let velocity = sense * libm::powf(60.0, (index % 12) as f32 / 11.0);
                let [j, b, delay, c, off] = TRUTH;
                let [acceleration, rate] = [400.0 * random, 4.0 * (random * 97.0).sin()];
                let level = c + drop / (1.0 + (velocity / 8.0).powi(2));
                let effort = j * acceleration + b * velocity + delay * rate + sense * level + off;
                let effort = effort + 0.001 * (random * 1013.0).sin();
                let gravity = [0.0, 1.0];
                model.add(
                    &RegressionRow { acceleration, velocity, spread: 0.0, effort, rate, gravity },
                    true,
                );
            }
            let fits = (0..LAST.into()).map(|step| model.fit(Some(step), false, true));
            let best = fits.min_by(|a, b| a.unexplained().total_cmp(&b.unexplained())).unwrap();
            model.uncertain(&best, 1, 231.0) / best.unexplained()
        };
        let [noise, foreign] = [0.0, 0.3].map(ratio);
        assert!((1.0..4.0).contains(&noise), "{noise}");
        assert!((10.0..48.1).contains(&foreign), "{foreign}");
    }

    /// Swings with ten times the noise, and the same efforts otherwise: the inertia is as uncertain
    /// as if all rows had the swings' noise, within the scatter of the mean of 118 squares (5
    /// sigma).
    #[test]
    fn the_inertia_is_as_uncertain_as_the_swings_are_noisy() {
        let deviation = |[of_legs, of_swings]: [f32; 2]| {
            let mut model = Model::new(1.0, 60.0);
            let mut state = 3u32;
            let mut random = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state as i32 as f32 / (1u32 << 31) as f32
            };
            for index in 0..240 {
                let is_of_leg = index < 120;
                let sense = if index % 2 == 0 { 1.0 } else { -1.0 };
                let velocity = sense * libm::powf(60.0, (index % 12) as f32 / 11.0);
                let [j, b, delay, c, off] = TRUTH;
                let acceleration = if is_of_leg { 0.0 } else { 400.0 * random() };
                let rate = 4.0 * random();
                let noise = random() * if is_of_leg { of_legs } else { of_swings };
                let effort =
                    j * acceleration + b * velocity + delay * rate + sense * c + off + noise;
                let gravity = [0.0, 1.0];
                let row =
                    RegressionRow { acceleration, velocity, spread: 0.0, effort, rate, gravity };
                model.add(&row, is_of_leg);
            }
            model.estimate(0.0).unwrap().inertia[1]
        };
        let ratio = deviation([1e-3, 1e-2]) / deviation([1e-2, 1e-2]);
        // The variance of the square of an even distribution is 4/5 of its mean's square, and a
        // deviation is off by half of what its square is. Noise that is the mean of all rows' would
        // give sqrt(1.01 / 2) = 0.71.
        assert!((ratio - 1.0).abs() < 5.0 * 0.5 * (0.8f32 / 118.0).sqrt(), "{ratio}");
    }

    #[test]
    fn rows_of_one_sense_show_nothing() {
        let mut model = Model::new(1.0, 60.0);
        for index in 0..50 {
            let velocity = 1.0 + index as f32;
            let acceleration = (index * index % 17) as f32;
            let gravity = [0.0, 1.0];
            let row = RegressionRow {
                acceleration,
                velocity,
                spread: 0.0,
                effort: 0.4,
                rate: 0.0,
                gravity,
            };
            model.add(&row, true);
        }
        assert_eq!(model.estimate(90.0), None);
    }

    /// The second method: all steps in one loop over both passes, as in a textbook.
    fn searched_at_once(model: &Model, range: f32) -> (Option<u8>, bool) {
        let fit = |step: Option<u8>, gravity| model.fit(step.map(usize::from), gravity, false);
        let (mut best, mut gravity) = (None, false);
        for pass in 0..2 {
            let mut is_new = pass == 0;
            if !gravity
                && range >= WIDE
                && model.is_significant(&fit(best, true), &fit(best, false))
            {
                (gravity, is_new) = (true, true);
            }
            if !is_new {
                break;
            }
            let without = fit(None, gravity);
            let look = |best: Option<u8>, step: u8| {
                let with = fit(Some(step), gravity);
                let falls = with.values(TOLERANCE).is_some_and(|fit| fit[STRIBECK] > 0.0);
                let is_better = falls
                    && model.is_significant(&with, &without)
                    && with.unexplained() < fit(best, gravity).unexplained();
                if is_better { Some(step) } else { best }
            };
            best = (0..=96).step_by(4).fold(best, look);
            if let Some(around) = best {
                best = (around.saturating_sub(3)..=(around + 3).min(96)).fold(best, look);
            }
        }
        (best, gravity)
    }

    #[test]
    fn piece_by_piece_the_search_finds_what_it_finds_at_once() {
        let (mut seen, mut with_gravity) = ([false; 97], 0);
        // Between 0.7 and 42 deg/s: the candidates go from 1 to 30.
        for speed in (0..24).map(|k| 0.7 * 1.195f32.powi(k)) {
            for (drop, load) in [(0.0, 0.0), (0.3, 0.0), (0.3, 0.1), (1.0, 0.02), (0.02, 0.02)] {
                let model = model([drop, speed], load, 0.003);
                let expected = searched_at_once(&model, 90.0);
                let search = Search::whole(&model, 90.0);
                assert_eq!((search.best, search.gravity), expected, "{drop} V, {speed} deg/s");
                if let Some(step) = search.best {
                    seen[usize::from(step)] = true;
                }
                with_gravity += u32::from(search.gravity);
                // No piece is the last one twice, and thirteen are enough.
                assert!(search.pieces <= PASSES * PIECES, "{search:?}");
            }
        }
        // From the first step to the last one, and a third of those between.
        let steps = seen.iter().filter(|seen| **seen).count();
        assert!(seen[0] && seen[96] && steps > 30, "{steps}");
        assert!((24..120).contains(&with_gravity), "{with_gravity}");
    }
}
