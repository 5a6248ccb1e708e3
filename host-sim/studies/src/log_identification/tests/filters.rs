//! Low-pass and differences against closed forms.

use std::f64::consts::TAU;

use crate::log_identification::butterworth::LowPass;
use crate::log_identification::derivative::derivatives;

/// Amplitude and phase of a sine behind the filter, by its correlation with sine and cosine over
/// whole periods.
fn response(cut_off: f64, frequency: f64) -> [f64; 2] {
    let n = 40_000;
    let series: Vec<f64> = (0..n).map(|i| (TAU * frequency * f64::from(i)).sin()).collect();
    let filtered = LowPass::new(cut_off).apply(&series);
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (i, value) in filtered.iter().enumerate().take(30_000).skip(10_000) {
        let angle = TAU * frequency * i as f64;
        sine += value * angle.sin() / 1e4;
        cosine += value * angle.cos() / 1e4;
    }
    [sine.hypot(cosine), cosine.atan2(sine)]
}

#[test]
fn both_ways_the_gain_is_the_square_of_butterworth_s_and_the_phase_is_none() {
    let cut_off = 0.02;
    for frequency in [0.002, 0.01, 0.02, 0.03, 0.05] {
        let warped = |f: f64| (TAU * f / 2.0).tan();
        let expected = 1.0 / (1.0 + (warped(frequency) / warped(cut_off)).powi(8));
        let [gain, phase] = response(cut_off, frequency);
        assert!((gain - expected).abs() < 1e-6, "{frequency}: {gain}, not {expected}");
        assert!(phase.abs() < 1e-6, "{frequency}: {phase}");
    }
}

#[test]
fn a_straight_line_passes_unchanged_to_its_ends() {
    let line: Vec<f64> = (0..500).map(|i| 1e3 + 0.3 * f64::from(i)).collect();
    for (one, other) in line.iter().zip(LowPass::new(0.01).apply(&line)) {
        assert!((one - other).abs() < 1e-4, "{one}, {other}");
    }
}

#[test]
fn differences_are_exact_on_a_polynomial_of_the_fourth_degree() {
    let h = 0.01;
    let t = |i: i32| h * f64::from(i) - 1.0;
    let series: Vec<f64> = (0..200).map(|i| t(i).powi(4) - 2.0 * t(i).powi(3) + t(i)).collect();
    let [velocity, acceleration] = derivatives(&series, h);
    for i in 2..198 {
        let t = t(i);
        let i = i as usize;
        let expected = [4.0 * t.powi(3) - 6.0 * t * t + 1.0, 12.0 * t * t - 12.0 * t];
        assert!((velocity[i] - expected[0]).abs() < 1e-10, "{i}");
        assert!((acceleration[i] - expected[1]).abs() < 1e-7, "{i}");
    }
}
