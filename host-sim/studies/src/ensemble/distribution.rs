//! The random draws of an ensemble.
//!
//! A draw is a function of the ensemble's seed, of what is drawn (a family's joints, or the moves
//! on them), and of the number of the case. Nothing else decides: neither the number of cores, nor
//! which other cases are run, nor the laws. The generator is ChaCha with eight rounds (D. J.
//! Bernstein, "ChaCha, a variant of Salsa20", 2008). Seed and purpose are its key, and the case is
//! its stream.
//!
//! ```text
//! U(a, b)   a + (b - a) w          mean (a + b)/2,            variance (b - a)^2/12
//! L(a, b)   a (b/a)^w              mean (b - a)/ln(b/a),      mean of ln: (ln a + ln b)/2
//! w         k 2^-53, k in 0 .. 2^53 - 1
//! ```

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// Purpose of draws. The draws of one purpose do not change those of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The joint, its encoder, its loop and the step.
    Joint,
    /// A row of moves.
    Moves,
    /// The condition that a joint is run under.
    Condition,
    /// The electrics of the motor.
    Electrics,
}

/// The draws of one case, in their order.
#[derive(Debug)]
pub struct Draws(ChaCha8Rng);

impl Draws {
    /// Begins the draws of a case. `family` is the number of the family.
    pub fn new(seed: u64, family: u8, purpose: Purpose, case: u64) -> Self {
        let mut key = [0; 32];
        for (place, byte) in key.iter_mut().zip(seed.to_le_bytes()) {
            *place = byte;
        }
        (key[8], key[9]) = (family, purpose as u8);
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(case);
        Self(generator)
    }

    /// Draws w, uniform in [0, 1), a multiple of 2^-53.
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * f64::EPSILON / 2.0
    }

    /// Draws from U(a, b).
    pub fn uniform(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// Draws from L(a, b), whose logarithm is uniform. Both bounds are positive.
    pub fn log_uniform(&mut self, a: f64, b: f64) -> f64 {
        // The core's own mathematics: the same bits on every platform.
        a * libm::exp(libm::log(b / a) * self.unit())
    }

    /// Draws 1 or -1, each half of the time.
    pub fn sign(&mut self) -> f64 {
        if self.coin() { 1.0 } else { -1.0 }
    }

    /// Draws true half of the time.
    pub fn coin(&mut self) -> bool {
        self.0.next_u64() >> 63 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: u64 = 40_000;

    /// Mean and variance of a draw over many cases.
    fn moments(draw: impl Fn(&mut Draws) -> f64) -> (f64, f64) {
        let drawn: Vec<f64> =
            (0..N).map(|case| draw(&mut Draws::new(7, 3, Purpose::Joint, case))).collect();
        let mean = drawn.iter().sum::<f64>() / N as f64;
        (mean, drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / N as f64)
    }

    /// Five standard errors of a mean of N draws with this variance.
    fn tolerance(variance: f64) -> f64 {
        5.0 * (variance / N as f64).sqrt()
    }

    #[test]
    fn moments_are_those_of_the_closed_forms() {
        let (a, b) = (-1.0_f64, 3.0);
        let (mean, variance) = moments(|draws| draws.uniform(a, b));
        let expected = (b - a).powi(2) / 12.0;
        assert!((mean - 1.0).abs() < tolerance(expected), "{mean}");
        // The fourth central moment of U is (b - a)^4/80, so that of the variance is 4/5 of its
        // square.
        assert!((variance - expected).abs() < tolerance(0.8 * expected * expected), "{variance}");

        let (a, b) = (1e-3_f64, 0.5);
        let span = (b / a).ln();
        let (mean, variance) = moments(|draws| draws.log_uniform(a, b));
        let expected = (b - a) / span;
        let of_square = (b * b - a * a) / (2.0 * span);
        assert!((mean - expected).abs() < tolerance(of_square - expected * expected), "{mean}");
        assert!((variance / (of_square - expected * expected) - 1.0).abs() < 0.05, "{variance}");
        let (mean, variance) = moments(|draws| draws.log_uniform(a, b).ln());
        let expected = span * span / 12.0;
        assert!((mean - 0.5 * (a * b).ln()).abs() < tolerance(expected), "{mean}");
        assert!((variance - expected).abs() < tolerance(0.8 * expected * expected), "{variance}");

        let (mean, variance) = moments(Draws::sign);
        assert!(mean.abs() < tolerance(1.0) && variance > 0.99, "{mean} {variance}");
    }

    #[test]
    fn draws_stay_within_their_bounds_and_come_near_both() {
        let drawn: Vec<f64> = (0..N)
            .map(|case| Draws::new(1, 0, Purpose::Joint, case).log_uniform(2.0, 12.0))
            .collect();
        let low = drawn.iter().copied().fold(f64::INFINITY, f64::min);
        let high = drawn.iter().copied().fold(0.0, f64::max);
        assert!((2.0..2.001).contains(&low) && (11.99..12.0).contains(&high), "{low} {high}");
    }

    #[test]
    fn seed_family_purpose_and_case_each_make_other_draws_and_the_same_make_the_same() {
        let first =
            |seed, family, purpose, case| Draws::new(seed, family, purpose, case).uniform(0.0, 1.0);
        let base = first(1, 2, Purpose::Joint, 3);
        assert_eq!(base, first(1, 2, Purpose::Joint, 3));
        for other in [
            first(2, 2, Purpose::Joint, 3),
            first(1 << 63 | 1, 2, Purpose::Joint, 3),
            first(1, 3, Purpose::Joint, 3),
            first(1, 2, Purpose::Moves, 3),
            first(1, 2, Purpose::Joint, 4),
        ] {
            assert_ne!(base, other);
        }
        // Neighbours in the seed, the family and the case are not alike: no correlation is left.
        let pairs = |of: &dyn Fn(u64) -> (f64, f64)| {
            (0..N).map(of).map(|(x, y)| (x - 0.5) * (y - 0.5)).sum::<f64>() / N as f64
        };
        let limit = tolerance(1.0 / 144.0);
        let at = |seed, case| first(seed, 1, Purpose::Joint, case);
        assert!(pairs(&|case| (at(1, case), at(2, case))).abs() < limit);
        assert!(pairs(&|case| (at(1, case), at(1, case + 1))).abs() < limit);
    }
}
