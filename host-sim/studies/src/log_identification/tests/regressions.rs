//! Least squares and its standard deviations against closed forms.

use super::machine::LinearCongruence;
use crate::log_identification::least_squares::{Fit, MOST, RegressionRow};

fn row(values: &[f64]) -> RegressionRow {
    let mut row = [0.0; MOST];
    row[..values.len()].copy_from_slice(values);
    row
}

#[test]
fn a_straight_line_is_fitted_by_the_formula_of_school() {
    let points = [(0.0, 1.0), (1.0, 2.9), (2.0, 5.2), (3.0, 6.9), (4.0, 9.1)];
    // Normal equations by hand: n = 5, sum x = 10, x^2 = 30, y = 25.1, x y = 70.4.
    let slope = (5.0 * 70.4 - 10.0 * 25.1) / (5.0 * 30.0 - 100.0);
    let fit = Fit::of(2, || points.iter().map(|(x, y)| (row(&[*x, 1.0]), *y))).unwrap();
    assert!((fit.values[0] - slope).abs() < 1e-12, "{:?}", fit.values);
    assert!((fit.values[1] - (25.1 - slope * 10.0) / 5.0).abs() < 1e-12, "{:?}", fit.values);
    let residual: f64 =
        points.iter().map(|(x, y)| (y - fit.values[0] * x - fit.values[1]).powi(2)).sum();
    assert!((fit.residual - residual).abs() < 1e-12);
}

#[test]
fn a_column_that_is_a_sum_of_others_is_named() {
    let rows = || (0..50).map(|i| (row(&[f64::from(i), 1.0, 2.0 * f64::from(i) + 3.0]), 1.0));
    assert_eq!(Fit::of(3, rows).unwrap_err(), 2);
}

/// If n values have the correlation a from one to the next, the variance of their mean is that of
/// independent values times (1 + a)/(1 - a).
#[test]
fn the_deviation_of_a_mean_takes_the_correlation_of_its_residuals_into_account() {
    const N: usize = 4000;
    for a in [0.0, 0.9] {
        let mut random = LinearCongruence(3);
        let mut values = vec![0.0; N];
        let mut estimated = 0.0;
        const LOGS: usize = 40;
        for _ in 0..LOGS {
            let mut error = 0.0;
            for value in &mut values {
                error = a * error + random.normal();
                *value = 5.0 + error;
            }
            let fit = Fit::of(1, || values.iter().map(|value| (row(&[1.0]), *value))).unwrap();
            estimated += fit.covariance[0][0] / LOGS as f64;
        }
        let expected = 1.0 / (1.0 - a * a) * (1.0 + a) / (1.0 - a) / N as f64;
        let ratio = (estimated / expected).sqrt();
        // The largest of three estimates, each widened by Student's t, is above 1 and below 1.5.
        assert!((1.0..1.5).contains(&ratio), "correlation {a}: {ratio} of the closed form");
    }
}
