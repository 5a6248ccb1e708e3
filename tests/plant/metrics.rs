//! The metrics against signals whose values are known.

use files::machine::{SineTable, TrajectoryTable};
use simulator::closed_loop::LoopSample;
use simulator::experiment::Task;
use simulator::metrics::{RunMetrics, is_unstable};
use stiction::Tick;

const SAMPLE_S: f64 = 0.02;
const COUNT: f64 = 0.00242;

/// Moments of a joint that moves along a given course under a constant reference.
fn motion(duration_s: f64, reference: f64, position: impl Fn(f64) -> f64) -> Vec<LoopSample> {
    let samples = (duration_s / SAMPLE_S).round() as u32;
    let moment = |k| {
        let time_s = f64::from(k) * SAMPLE_S;
        LoopSample {
            time_s,
            tick: Tick::default(),
            reference_deg: reference,
            position_deg: position(time_s),
            at_encoder_deg: position(time_s),
            at_load_deg: position(time_s),
            motor_counts: None,
            velocity_deg_per_s: 0.0,
            applied_v: 0.0,
            stuck: false,
        }
    };
    (0..=samples).map(moment).collect()
}

#[test]
fn a_first_order_response_rises_and_settles_in_its_textbook_times() {
    // 10-90 % of 1 - e^(-t/tau) takes tau ln 9; within 0.05 of 2.5 deg after tau ln 50.
    let tau = 0.7;
    let moments = motion(10.0, 2.5, |t| 2.5 * (1.0 - (-t / tau).exp()));
    let metrics = RunMetrics::of(&moments, &Task::Step(2.5), COUNT);
    assert!((metrics.rise_time_s.unwrap() - tau * 9f64.ln()).abs() < 1e-4);
    let settled = metrics.settling_time_s.unwrap() - tau * 50f64.ln();
    assert!((0.0..SAMPLE_S).contains(&settled), "{settled}");
    assert_eq!(metrics.overshoot_deg, Some(0.0));
    // Mean square of 2.5 e^(-t/tau) over 10 s, as a sum over samples.
    let (r, n) = ((-2.0 * SAMPLE_S / tau).exp(), 501.0);
    let rms = (6.25 * (1.0 - r.powf(n)) / (1.0 - r) / n).sqrt();
    assert!((metrics.rms_error_deg.unwrap() / rms - 1.0).abs() < 1e-9);
    assert_eq!(metrics.max_error_deg, Some(2.5));
    assert_eq!(metrics.cruise_error_deg, None);
    assert_eq!(metrics.hunting_peak_to_peak_deg, None);
}

#[test]
fn overshoot_is_beyond_the_target_on_either_side() {
    for step in [5.0, -5.0] {
        let moments = motion(4.0, step, |t| if t == 1.0 { 1.1 * step } else { 0.98 * step });
        let metrics = RunMetrics::of(&moments, &Task::Step(step), COUNT);
        assert!((metrics.overshoot_deg.unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(metrics.settling_time_s, None);
        assert!((metrics.steady_state_error_deg.unwrap() - 0.02 * step).abs() < 1e-12);
        assert!((metrics.rest_error_counts.unwrap() - 0.02 * step / COUNT).abs() < 1e-9);
    }
}

#[test]
fn a_response_that_stops_at_a_half_has_no_rise_time() {
    let moments = motion(4.0, 1.0, |t| 0.5f64.min(t));
    assert_eq!(RunMetrics::of(&moments, &Task::Step(1.0), COUNT).rise_time_s, None);
}

#[test]
fn hunting_has_the_amplitude_and_period_of_its_sine() {
    let hunting = |amplitude: f64, period_s: f64| {
        let moments =
            motion(120.0, 0.0, |t| amplitude * (std::f64::consts::TAU * t / period_s).sin());
        let metrics = RunMetrics::of(&moments, &Task::Step(1.0), COUNT);
        metrics.hunting_peak_to_peak_deg.zip(metrics.hunting_period_s)
    };
    for (amplitude, period_s) in [(0.1, 2.2), (0.003, 20.0)] {
        let (peak_to_peak, period) = hunting(amplitude, period_s).unwrap();
        assert!((peak_to_peak / (2.0 * amplitude) - 1.0).abs() < 0.01, "{peak_to_peak}");
        assert!((period / period_s - 1.0).abs() < 0.01, "{period}");
    }
    // Four reversals in the second half: 60 s hold two periods of 30 s, but not two of 41 s.
    assert!(hunting(0.1, 30.0).is_some());
    assert!(hunting(0.1, 41.0).is_none());
    // A hundredth of a count is not motion.
    assert!(hunting(0.004 * COUNT, 2.0).is_none());
}

#[test]
fn a_trajectory_is_judged_while_it_moves_and_cruises() {
    // Error 1 before the motion and after it, 3 in it, 5 while cruising.
    let moments = motion(20.0, 0.0, |t| match t {
        t if !(4.0..=16.0).contains(&t) => -1.0,
        t if (7.0..=8.0).contains(&t) => -5.0,
        _ => -3.0,
    });
    // Blends from 4 to 16 s; the cruise begins 2 s after the first corner and ends 0.5 s before the
    // second.
    let trajectory = TrajectoryTable {
        corner_times_s: vec![5.0, 8.5, 15.0],
        corner_positions_deg: vec![0.0, 1.0, 1.0],
        half_blend_s: 1.0,
    };
    let metrics = RunMetrics::of(&moments, &Task::Trajectory(trajectory), COUNT);
    assert_eq!(metrics.cruise_error_deg, Some(5.0));
    assert_eq!(metrics.max_error_deg, Some(5.0));
    let rms = ((51.0 * 25.0 + 550.0 * 9.0) / 601.0f64).sqrt();
    assert!((metrics.rms_error_deg.unwrap() / rms - 1.0).abs() < 1e-12);
    assert_eq!(
        (metrics.overshoot_deg, metrics.rise_time_s, metrics.settling_time_s),
        (None, None, None)
    );
}

/// Error 9 in the first period, then 2, and 5 for 0.05 s around a turn. The speed is below a fifth
/// of its top for 0.064 of a half period on either side of a turn.
#[test]
fn a_sine_is_judged_after_its_first_period_and_at_its_turns() {
    let sine = SineTable { amplitude_deg: 3.0, frequency_hz: 0.5 };
    let mut moments = motion(8.0, 0.0, |t| match t {
        t if t < 1.99 => 9.0,
        t if (t - 5.0).abs() < 0.05 => -5.0,
        _ => 2.0,
    });
    let speed = |time_s: f64| 3.0 * std::f64::consts::PI * (std::f64::consts::PI * time_s).sin();
    for moment in &mut moments {
        moment.tick.reference_velocity = speed(moment.time_s) as f32;
    }
    let metrics = RunMetrics::of(&moments, &Task::Sine(sine.clone()), COUNT);
    assert_eq!((metrics.max_error_deg, metrics.reversal_error_deg), (Some(5.0), Some(5.0)));
    let rms = ((5.0 * 25.0 + 296.0 * 4.0) / 301.0f64).sqrt();
    assert!((metrics.rms_error_deg.unwrap() / rms - 1.0).abs() < 1e-12, "{metrics:?}");
    assert_eq!((metrics.rest_error_counts, metrics.steady_state_error_deg), (None, None));
    // Between two turns it is no error of a reversal.
    for moment in &mut moments {
        moment.tick.reference_velocity = speed(moment.time_s - 0.5) as f32;
    }
    let metrics = RunMetrics::of(&moments, &Task::Sine(sine), COUNT);
    assert_eq!((metrics.max_error_deg, metrics.reversal_error_deg), (Some(5.0), Some(2.0)));
}

#[test]
fn chatter_is_the_total_variation_per_second() {
    let mut moments = motion(10.0, 0.0, |_| 0.0);
    for (k, moment) in moments.iter_mut().enumerate() {
        moment.applied_v = if k % 2 == 0 { 0.25 } else { -0.25 };
    }
    let metrics = RunMetrics::of(&moments, &Task::Step(1.0), COUNT);
    assert!((metrics.control_total_variation_v_per_s.unwrap() - 25.0).abs() < 1e-9);
}

#[test]
fn a_run_is_unstable_if_it_escapes_or_bangs_between_the_limits() {
    assert!(!is_unstable(&motion(10.0, 1.0, |_| -9.0), 1.0));
    assert!(is_unstable(&motion(10.0, 1.0, |_| -9.1), 1.0));
    let banging = |share: usize, alternating: bool| {
        let mut moments = motion(10.0, 0.0, |_| 0.0);
        for (k, moment) in moments.iter_mut().enumerate() {
            moment.tick.saturated = k % 100 < share;
            moment.tick.v = if alternating && k % 2 == 0 { -5.0 } else { 5.0 };
        }
        is_unstable(&moments, 1.0)
    };
    // The last second holds 51 samples, of which the last has k % 100 = 0.
    assert!(banging(100, true));
    assert!(!banging(100, false));
    assert!(!banging(50, true));
}
