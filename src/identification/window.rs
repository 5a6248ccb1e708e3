//! A stretch of sliding as one equation between the joint's parameters: the equation of motion in
//! integral form.
//!
//! ```text
//! J q'' + B q' + C d + off + gravity(q) + S d g(q') = u(t - delay)        d = sense of the motion
//!
//! times phi(s) = s^3 (1 - s)^3, s = t / T, over the T of a window, by parts:
//!
//! J int phi'' q  -  B int phi' q  +  (C d + off) int phi + ..  -  delay int phi' u  =  int phi u
//! ```
//!
//! This is the method of modulating functions (Shinbrot, *On the analysis of linear and nonlinear
//! systems*, Trans. ASME 79, 1957; Preisig and Rippin, Computers chem. Engng 17, 1993). `phi` and
//! its first two derivatives are zero at both ends, so that position and velocity there drop out:
//! nothing is differentiated, and the rounding of the encoder is averaged over the whole window. In
//! the sums the derivatives are central differences, which is exact by parts: a steady speed gives
//! an acceleration of zero. All is divided by `int phi`, so that a row has the unit of an effort.
//!
//! The effort `u_k` is held from tick k - 1 to tick k. If the acceleration is constant in each, the
//! second difference of the positions is the mean of two accelerations, so that `u_k` has the
//! weight `(phi(k - 1) + phi(k)) / 2` if it acts without delay. With one tick of delay the weight
//! is `(phi(k) + phi(k + 1)) / 2`. The window uses the mean of both,
//!
//! ```text
//! w_k = (phi(k - 1) + 2 phi(k) + phi(k + 1)) / 4
//! ```
//!
//! and half a tick of `u'` either way yields each of them, exactly to second order. With phi in the
//! middle of the tick, a tick h of delay would make the inertia too large by the part `(w h)^2 / 2`
//! at the frequency w: 0.6 % at 20 ms. With the mean, the part is `(w h)^2 / 2 (d^2 - d)` for d
//! ticks of delay: zero for none and for one.
//!
//! The gear's angle changes little in a window, and is taken at the mean position over `phi`.
//! The level of the Stribeck curve is the mean of two: a standard deviation of the speed below and
//! above its mean (the quadrature of Gauss and Hermite with two points).
//!
//! Guarantees: a window costs the same at each tick, and stores six sums.
//!
//! Does badly: within a window the sense of the motion must not change; the caller ensures this.
//! Motion that is faster than about `4 / T` is smoothed away with the noise.

use core::f32::consts::{FRAC_PI_2, PI, TAU};

/// The means over a window, in volts, degrees and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegressionRow {
    /// Mean acceleration, deg/s^2.
    pub acceleration: f32,
    /// Mean velocity, deg/s.
    pub velocity: f32,
    /// Standard deviation of the velocity over phi, deg/s, if the acceleration is its mean.
    pub spread: f32,
    /// Mean effort, V.
    pub effort: f32,
    /// Mean rate of the effort, V/s: the decrease of the effort per second of delay.
    pub rate: f32,
    /// Sine and cosine of the mean position, counted from where the joint was armed.
    pub gravity: [f32; 2],
}

/// The sums of a window that is being filled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Window {
    /// Ticks since the start of the window.
    tick: u32,
    /// Position at the start of the window, counts.
    origin: i32,
    /// Sums of `phi'' q`, `phi' q`, `phi q` (counts), `phi u`, `phi' u` (V) and `phi`.
    sums: [f32; 6],
}

/// Returns phi at s.
const fn modulate(s: f32) -> f32 {
    let p = s * (1.0 - s);
    p * p * p
}

/// Returns the second and the first central difference of phi over a step `d` at s, divided by
/// `d^2` and by `d`.
///
/// phi is a polynomial of sixth order, so the series of both differences end, and are exact.
/// Derivatives would not be: at 40 ticks a window, a steady speed would appear in the sum as a
/// twentieth of the friction. Differences of rounded values of phi would lose half of the digits.
fn differences(s: f32, d: f32) -> [f32; 2] {
    let d2 = d * d;
    let second = s * (6.0 + s * (-36.0 + s * (60.0 - 30.0 * s)))
        + d2 * ((-6.0 + s * (30.0 - 30.0 * s)) - 2.0 * d2);
    let p = s * (1.0 - s);
    let first = 3.0 * p * p * (1.0 - 2.0 * s);
    let third = 6.0 + s * (-72.0 + s * (180.0 - 120.0 * s));
    [second, first + d2 * (third / 6.0 + d2 * (3.0 - 6.0 * s))]
}

/// Returns the sine of an angle (rad), to 4e-6: the Taylor series up to the ninth power, within a
/// quarter of a turn. `libm::sinf` computes in `f64`, for which the microcontroller has no unit.
fn sin(angle: f32) -> f32 {
    let within = angle - TAU * libm::roundf(angle / TAU);
    let x = if within > FRAC_PI_2 {
        PI - within
    } else if within < -FRAC_PI_2 {
        -PI - within
    } else {
        within
    };
    let z = x * x;
    x * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0))))
}

impl Window {
    /// Returns an empty window that begins with the joint at `counts`.
    pub const fn begin(counts: i32) -> Self {
        Self { tick: 0, origin: counts, sums: [0.0; 6] }
    }

    /// Adds a tick: its position, and the effort (V) that was held since the tick before. After the
    /// last of `length` ticks, returns the row of the window, and a new window begins. `tick` is
    /// the time of a tick (s), and `count` the angle of a count (deg).
    pub fn update(
        &mut self,
        counts: i32,
        effort: f32,
        length: u32,
        [tick, count]: [f32; 2],
    ) -> Option<RegressionRow> {
        self.tick = self.tick.saturating_add(1);
        let per_tick = 1.0 / length as f32;
        let s = self.tick as f32 * per_tick;
        let q = counts.wrapping_sub(self.origin) as f32;
        let phi = modulate(s);
        // Beyond the end phi is zero.
        let [second, first] = if self.tick < length {
            differences(s, per_tick)
        } else {
            let rest = 1.0 - per_tick;
            let last = per_tick * rest * rest * rest;
            [last, -0.5 * per_tick * last]
        };
        // The quarter of phi before and behind, and half of it here.
        let held = phi + 0.25 * per_tick * per_tick * second;
        let added = [second * q, first * q, phi * q, held * effort, first * effort, phi];
        self.sums.iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        if self.tick < length {
            return None;
        }
        let [acceleration, velocity, position, effort, rate, area] = self.sums;
        let per_second = per_tick / tick;
        // The mean position is counted from the zero of the arming, as the gravity is.
        let angle = (position / area + self.origin as f32) * count * (PI / 180.0);
        let acceleration = acceleration / area * count * per_second * per_second;
        let rate = -rate / area * per_second;
        let row = RegressionRow {
            acceleration,
            // phi is the density of Beta(4, 4), whose variance is 1/36.
            spread: acceleration.abs() / per_second / 6.0,
            velocity: -velocity / area * count * per_second,
            // From the tick back to the middle of the time for which the effort was held.
            effort: effort / area + 0.5 * tick * rate,
            rate,
            gravity: [sin(angle), sin(angle + FRAC_PI_2)],
        };
        *self = Self::begin(counts);
        Some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: f32 = 1e-3;
    const LENGTH: u32 = 200;

    /// The row of a motion `q(t)` (deg) and an effort `u(t)`, with counts of `count` deg.
    fn row(q: impl Fn(f64) -> f64, u: impl Fn(f64) -> f64, count: f64) -> RegressionRow {
        let counts = |k: u32| (q(f64::from(k) * 1e-3) / count).round() as i32;
        let mut window = Window::begin(counts(0));
        let mut row = None;
        for k in 1..=LENGTH {
            // Held from the last tick on.
            let held = u((f64::from(k) - 1.0) * 1e-3);
            row = window.update(counts(k), held as f32, LENGTH, [TICK, count as f32]);
            assert_eq!(row.is_some(), k == LENGTH);
        }
        row.unwrap()
    }

    /// Means over phi of a power of t, in closed form: `int s^(n+3) (1-s)^3 / int s^3 (1-s)^3`,
    /// which is B(n+4, 4) / B(4, 4).
    fn mean_of_power(n: u32) -> f64 {
        (0..n).map(|i| f64::from(4 + i) / f64::from(8 + i)).product()
    }

    #[test]
    fn means_of_a_parabola_are_those_of_the_closed_form() {
        // q = 2 + 30 t + 200 t^2, so q'' = 400 and the mean of q' is 30 + 400 T E[s].
        let found = row(|t| 2.0 + 30.0 * t + 200.0 * t * t, |t| 0.3 + 2.0 * t, 1e-5);
        let length = 0.2;
        let velocity = 30.0 + 400.0 * length * mean_of_power(1);
        assert!((f64::from(found.acceleration) / 400.0 - 1.0).abs() < 1e-4, "{found:?}");
        assert!((f64::from(found.velocity) / velocity - 1.0).abs() < 1e-4, "{found:?}");
        // E[s^2] - E[s]^2 of the velocity 400 T s.
        let variance = mean_of_power(2) - mean_of_power(1).powi(2);
        let spread = 400.0 * length * variance.sqrt();
        assert!((f64::from(found.spread) / spread - 1.0).abs() < 1e-3, "{found:?} {spread}");
        // Held for a tick, the effort is that of half a tick before, but phi is taken there.
        let effort = 0.3 + 2.0 * (length * mean_of_power(1) - 0.5e-3);
        assert!((f64::from(found.effort) - effort).abs() < 1e-4, "{found:?}");
        assert!((f64::from(found.rate) / 2.0 - 1.0).abs() < 1e-3, "{found:?}");
        let angle =
            (2.0 + 30.0 * length * mean_of_power(1) + 200.0 * length * length * mean_of_power(2))
                .to_radians();
        assert!((f64::from(found.gravity[0]) - angle.sin()).abs() < 1e-4, "{found:?}");
        assert!((f64::from(found.gravity[1]) - angle.cos()).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn a_steady_speed_is_no_acceleration_in_a_short_window() {
        let mut window = Window::begin(-3);
        let rows = (1..=40).filter_map(|k| window.update(1000 * k - 3, 0.5, 40, [0.02, 0.001]));
        let mut last = None;
        rows.for_each(|row| last = Some(row));
        let row = last.unwrap();
        // 1 deg a tick is 50 deg/s; the rounding of f32 is what is left.
        assert!((row.velocity / 50.0 - 1.0).abs() < 1e-5, "{row:?}");
        assert!(row.acceleration.abs() < 0.01, "{row:?}");
        assert!((row.effort - 0.5).abs() < 1e-4 && row.rate.abs() < 1e-3, "{row:?}");
    }

    /// If the effort is held, the acceleration is held as well, and the positions at the ticks are
    /// exact sums. A row should satisfy `effort - d h rate = J acceleration` for d ticks of delay.
    #[test]
    fn none_and_one_tick_of_delay_leave_the_inertia_as_it_is_and_two_do_not() {
        const H: f64 = 0.02;
        const INERTIA: f64 = 0.037;
        // As fast as a swing's window of 40 ticks lets through.
        let frequency = 6.0f64;
        let wanted = |k: i32| 0.4 * (frequency * H * f64::from(k) + 0.3).sin();
        let excess = |delay: i32| {
            let (mut q, mut v) = (0.0, 5.0);
            let mut window = Window::begin(0);
            let mut row = None;
            for k in 1..=40 {
                let acceleration = wanted(k - delay) / INERTIA;
                q += v * H + 0.5 * acceleration * H * H;
                v += acceleration * H;
                let counts = (q / 1e-5).round() as i32;
                row = window.update(counts, wanted(k) as f32, 40, [H as f32, 1e-5]);
            }
            let row = row.unwrap();
            let late = f64::from(delay) * H * f64::from(row.rate);
            let moved = INERTIA * f64::from(row.acceleration);
            assert!(moved.abs() > 0.05, "{row:?}");
            (f64::from(row.effort) - late) / moved - 1.0
        };
        assert!(excess(0).abs() < 3e-4 && excess(1).abs() < 3e-4, "{} {}", excess(0), excess(1));
        // (w h)^2 / 2 (d^2 - d) is 1.4 %; of a row that is not one frequency alone, about that.
        assert!((0.007..0.03).contains(&excess(2)), "{}", excess(2));
    }

    #[test]
    fn the_sine_is_that_of_the_library() {
        for k in -400..400 {
            let angle = 0.0371 * k as f32;
            let expected = f64::from(angle).sin();
            assert!((f64::from(sin(angle)) - expected).abs() < 1e-5, "{angle}");
        }
    }

    #[test]
    fn a_coarse_encoder_costs_no_more_than_its_rounding_over_the_window() {
        // sigma = q/sqrt(12) for each sample: the sum of phi''^2 over 200 of them gives 12 q/s^2
        // and that of phi'^2 0.16 q/s (to 10 %); five of these are the limit.
        for phase in 0..20 {
            let q = |t: f64| f64::from(phase) * 0.0017 + 33.7 * t;
            let found = row(q, |_| 0.0, 0.036);
            assert!(found.acceleration.abs() < 5.0 * 12.0 * 0.036, "{found:?}");
            assert!((found.velocity - 33.7).abs() < 5.0 * 0.16 * 0.036, "{found:?}");
        }
    }
}
