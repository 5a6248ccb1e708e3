//! The sine reference: a motion to and fro that starts from rest.
//!
//! ```text
//! theta_d(t)   = p + a (1 - cos w t) = p + 2 a s^2,   s = sin(w t / 2),  c = cos(w t / 2)
//! theta_d'(t)  = a w sin w t         = 2 a w s c
//! theta_d''(t) = a w^2 cos w t       = a w^2 (1 - 2 s^2)
//!
//! w t / 2 pi = k D / 2^32 mod 1,  D = floor(2^32 f h),  w = 2 pi D / (2^32 h)
//! ```
//!
//! Phases are integers that wrap (direct digital synthesis: J. Tierney, C. M. Rader and B. Gold, *A
//! digital frequency synthesizer*, IEEE Trans. Audio Electroacoustics 19 (1971), 48). So the sine
//! is as exact after a year as in its first period. Its frequency is low by 1.2e-7 of its value and
//! `1 / (2^32 h)` at most, 2.3e-7 Hz at 1 kHz.
//!
//! Why this form: `cos` leaves the position at rest, where the joint is; `sin` would jump to its
//! largest speed. `1 - cos` by `s^2` keeps the digits of a small angle. A sine of `libm` computes
//! in f64.
//!
//! Guarantees: velocity and acceleration are the derivatives of the position. Does badly: the
//! acceleration jumps to `a w^2` in the first tick. A position is exact to 3e-7 of the amplitude:
//! half a count for one of 2 million counts.

use core::f32::consts::PI;

use super::Setpoint;
use crate::control::controller::SAMPLE_TIME;
use crate::control::encoder::RESOLUTION;
use crate::units::error::{HUGE, InvalidValue, above, between};
use crate::units::position::Position;
use crate::units::value::Key;

/// Keys of the configured values `amplitude_deg` and `frequency_hz`.
pub(crate) const AMPLITUDE: Key = Key(0x060A);
pub(crate) const FREQUENCY: Key = Key(0x060B);

/// Largest amplitude, counts: the travel, twice the amplitude, is a quarter of the range of counts.
const MOST: f32 = 536_870_912.0;

/// Largest frequency in periods a tick: two set points to a side.
const FASTEST: f32 = 0.25;

/// A sine, ready to be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    from: Position,
    /// 2 a, counts.
    travel: f32,
    /// The phase of a tick D, in 2^-32 of a period.
    step: u32,
    /// 2 a w, deg/s.
    speed: f32,
    /// a w^2, deg/s^2.
    acceleration: f32,
}

impl Sine {
    /// Prepares a sine that sets out from a position, with an amplitude a (counts; below zero it
    /// sets out backwards) and a frequency f (Hz), for a loop with `sample_time` (s) and an encoder
    /// of `resolution` (deg).
    ///
    /// # Errors
    /// Returns an error that names the amplitude unless it is within 2^29 counts, and one that
    /// names the frequency unless it is above zero and a quarter of the sample rate at most.
    // Compiled once, to save flash: it is called to check and to prepare.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn new(
        from: Position,
        amplitude: f32,
        frequency: f32,
        sample_time: f32,
        resolution: f32,
    ) -> Result<Self, InvalidValue> {
        above(SAMPLE_TIME, sample_time, 0.0, 1.0)?;
        above(RESOLUTION, resolution, 0.0, HUGE)?;
        between(AMPLITUDE, amplitude, -MOST, MOST)?;
        above(FREQUENCY, frequency, 0.0, FASTEST / sample_time)?;
        let step = (4_294_967_296.0 * frequency * sample_time) as u32;
        let angular = PI / 2_147_483_648.0 * step as f32 / sample_time;
        let speed = amplitude * resolution * angular;
        Ok(Self {
            from,
            travel: 2.0 * amplitude,
            step,
            speed: 2.0 * speed,
            acceleration: speed * angular,
        })
    }

    /// Returns the set point at a tick.
    ///
    /// ```
    /// use stiction::{units::position::Position, control::reference::Sine};
    /// // 100 counts of 0.1 deg, in 8 ticks of 0.5 s.
    /// let sine = Sine::new(Position::from_counts(7), 100.0, 0.25, 0.5, 0.1).unwrap();
    /// let counts = |tick| sine.at(tick).position.ahead_of(0).round();
    /// assert_eq!([0, 2, 4, 6, 8].map(counts), [7.0, 107.0, 207.0, 107.0, 7.0]);
    /// // a w = 10 deg * 1.571 / s
    /// let speed = |tick| (10.0 * sine.at(tick).velocity).round();
    /// assert_eq!([0, 2, 4, 6, 8].map(speed), [0.0, 157.0, 0.0, -157.0, 0.0]);
    /// ```
    // Not inlined, so that other references do not pay for it.
    #[inline(never)]
    pub fn at(&self, tick: u32) -> Setpoint {
        let half = tick.wrapping_mul(self.step) >> 1;
        let (s, c) = (sine(half), sine(half.wrapping_add(QUARTER)));
        let square = s * s;
        Setpoint {
            position: self.from.displaced(self.travel * square),
            velocity: self.speed * s * c,
            acceleration: self.acceleration * (1.0 - 2.0 * square),
        }
    }

    /// Returns the two positions at which the motion turns.
    pub(crate) fn turns(&self) -> [Position; 2] {
        [self.from, self.from.displaced(self.travel)]
    }
}

/// A quarter of a period.
const QUARTER: u32 = 1 << 30;

/// Returns the sine of a phase in 2^-32 of a period: its Taylor series up to `x^11` within a
/// quarter of a period, of which the rest is below `(pi/2)^13 / 13! = 5.7e-8`.
// Compiled once for sine and cosine, to save flash.
#[cfg_attr(target_os = "none", inline(never))]
fn sine(phase: u32) -> f32 {
    let mut phase = phase as i32;
    if phase.unsigned_abs() > QUARTER {
        // sin x = sin(pi - x)
        phase = i32::MIN.wrapping_sub(phase);
    }
    let x = phase as f32 * (PI / 2_147_483_648.0);
    let square = x * x;
    let series = [110.0, 72.0, 42.0, 20.0, 6.0];
    x * series.iter().fold(1.0, |sum, factor| 1.0 - square * (1.0 / factor) * sum)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;

    /// The standard library's sine, in f64.
    #[test]
    fn sine_is_that_of_the_standard_library() {
        for phase in (0..=u32::MAX).step_by(65_537) {
            let expected = (f64::from(phase) * core::f64::consts::TAU / 4_294_967_296.0).sin();
            assert!((f64::from(sine(phase)) - expected).abs() < 2e-7, "{phase}");
        }
    }

    /// A difference quotient: of positions within 0.01 counts over 2 ms, so within 0.1 deg/s.
    #[test]
    fn velocity_and_acceleration_are_the_derivatives_of_the_position() {
        for amplitude in [1000.0, -1000.0] {
            let sine = Sine::new(Position::default(), amplitude, 3.0, 0.001, 0.01).unwrap();
            let angle = |tick| f64::from(sine.at(tick).position.ahead_of(0)) * 0.01;
            for tick in 1..2000 {
                let quotient = (angle(tick + 1) - angle(tick - 1)) / 0.002;
                let velocity = f64::from(sine.at(tick).velocity);
                assert!((quotient - velocity).abs() < 0.1, "{tick}: {quotient} {velocity}");
                let speeds = [tick + 1, tick - 1].map(|tick| f64::from(sine.at(tick).velocity));
                let quotient = (speeds[0] - speeds[1]) / 0.002;
                let acceleration = f64::from(sine.at(tick).acceleration);
                assert!((quotient - acceleration).abs() < 2.0, "{tick}: {quotient} {acceleration}");
            }
            assert_eq!(sine.at(0).position, Position::default());
            // 2 a at half of a period, and 2 pi f a on the way.
            let turned = sine.at(167).position.ahead_of(0) / amplitude;
            assert!((1.999..2.0).contains(&turned), "{turned}");
        }
    }

    /// 2^32 ticks later is no other phase, and 100 million ticks are 300 000 periods.
    #[test]
    fn a_long_motion_keeps_its_phase() {
        let sine = Sine::new(Position::default(), 1000.0, 3.0, 0.001, 0.01).unwrap();
        let periods = 300_000.0 * f64::from(sine.step) * 1000.0 / 3.0 / 4_294_967_296.0;
        let tick = 100_000_000;
        let expected = 1000.0 * (1.0 - (core::f64::consts::TAU * periods).cos());
        let found = f64::from(sine.at(tick).position.ahead_of(0));
        assert!((found - expected).abs() < 1e-2, "{found} {expected}");
    }

    #[test]
    fn values_out_of_their_range_are_named() {
        let new = |amplitude, frequency, sample_time, resolution| {
            Sine::new(Position::default(), amplitude, frequency, sample_time, resolution)
                .map_err(|error| error.key)
        };
        assert!(new(-MOST, 249.9, 0.001, 0.01).is_ok());
        for (found, key) in [
            (new(f32::NAN, 1.0, 0.001, 0.01), AMPLITUDE),
            (new(2.0 * MOST, 1.0, 0.001, 0.01), AMPLITUDE),
            (new(1.0, 0.0, 0.001, 0.01), FREQUENCY),
            (new(1.0, 250.1, 0.001, 0.01), FREQUENCY),
            (new(1.0, 1.0, 0.0, 0.01), SAMPLE_TIME),
            (new(1.0, 1.0, 0.001, f32::INFINITY), RESOLUTION),
        ] {
            assert_eq!(found, Err(key));
        }
    }
}
