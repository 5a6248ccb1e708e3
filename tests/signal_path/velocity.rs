//! Measured velocity is held against the slope of the regression line.

use std::iter::repeat_n;

use proptest::collection::vec;
use proptest::prelude::*;
use stiction::control::velocity::{MAX_WINDOW, Velocity, VelocityState};

use super::{HALF_ULP, RESOLUTION, SAMPLE_TIME, config};

/// The bound, in counts per tick, at which an increment is clamped.
const MAX_INCREMENT: i32 = 1 << 21;

/// Computes the slope of the regression line through equally spaced samples by the textbook's two
/// sums.
fn slope(samples: &[f64]) -> f64 {
    let n = samples.len() as f64;
    let mean_k = (n - 1.0) / 2.0;
    let mean_x = samples.iter().sum::<f64>() / n;
    let centred = || samples.iter().enumerate().map(|(k, x)| (k as f64 - mean_k, x - mean_x));
    let covariance: f64 = centred().map(|(k, x)| k * x).sum();
    let variance: f64 = centred().map(|(k, _)| k * k).sum();
    covariance / variance
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn velocity_is_the_slope_of_the_regression_line(
        window in 2..=MAX_WINDOW,
        resolution in 1e-4f32..1.0,
        sample_time in 1e-4f32..0.1,
        increments in vec(
            prop_oneof![Just(0), -3..=3, -3000..=3000, -MAX_INCREMENT..=MAX_INCREMENT],
            1..40,
        ),
    ) {
        let velocity = Velocity::new(window as u32, resolution, sample_time);
        let mut state = VelocityState::default();
        let mut positions = vec![0.0; window];
        for increment in increments {
            positions.push(positions[positions.len() - 1] + f64::from(increment));
            let measured = f64::from(velocity.update(&mut state, increment));
            let slope = slope(&positions[positions.len() - window..]);
            let expected = slope * f64::from(resolution) / f64::from(sample_time);
            // Seven roundings at most, and what cancels in the regression itself.
            let count = f64::from(resolution / sample_time);
            let tolerance = 7.0 * HALF_ULP * expected.abs() + 1e-6 * count;
            prop_assert!((measured - expected).abs() <= tolerance, "{measured}, not {expected}");
        }
    }
}

#[test]
fn velocity_forgets_a_movement_with_the_window_and_not_before() {
    for window in 2..=MAX_WINDOW {
        let velocity = Velocity::new(window as u32, RESOLUTION, SAMPLE_TIME);
        let mut state = VelocityState::default();
        velocity.update(&mut state, 1);
        for _ in 2..window {
            assert!(velocity.update(&mut state, 0) > 0.0, "{window}");
        }
        assert_eq!(velocity.update(&mut state, 0), 0.0, "{window}");
    }
}

#[test]
fn velocity_is_clamped_before_it_could_overflow() {
    for window in 2..=MAX_WINDOW {
        let velocity = Velocity::new(window as u32, RESOLUTION, SAMPLE_TIME);
        let steady = |increment: i32| {
            let mut state = VelocityState::default();
            repeat_n(increment, window)
                .map(|increment| velocity.update(&mut state, increment))
                .last()
                .unwrap()
        };
        let bound = f64::from(MAX_INCREMENT) * f64::from(RESOLUTION) / f64::from(SAMPLE_TIME);
        assert!(
            (f64::from(steady(i32::MAX)) / bound - 1.0).abs() < 1e-6,
            "{window}: {}",
            steady(i32::MAX)
        );
        assert_eq!(steady(i32::MIN), -steady(i32::MAX), "{window}");
        assert_eq!(steady(MAX_INCREMENT + 1), steady(MAX_INCREMENT), "{window}");
        assert_eq!(steady(-MAX_INCREMENT - 1), steady(-MAX_INCREMENT), "{window}");
        // Sixteen counts are more than a float of that size rounds away.
        assert!(steady(MAX_INCREMENT - 16) < steady(MAX_INCREMENT), "{window}");
    }
}
