//! The ramp that identifies friction: its effort, its levels, and its end.

use stiction::identification::{MAX_TICKS, Ramp, RampState};
use stiction::parameters::names::ValuePath;

/// A ramp of 0.25 V/s at 2 ms, which has rungs of 0.0005 V up to 1 V and is held for 0.1 s.
fn ramp() -> Ramp {
    Ramp::new(0.25, 0.1, 0.002, 1.0).unwrap()
}

/// Runs a ramp on a joint whose counts are a function of the tick, with a limit of ticks.
/// Returns its state, the efforts and the ticks that it took.
fn run(ramp: &Ramp, ticks: u32, counts: impl Fn(u32) -> i32) -> (RampState, Vec<f32>) {
    let mut state = RampState::start(counts(0));
    let mut efforts = Vec::new();
    for tick in 0..ticks {
        efforts.push(ramp.update(&mut state, counts(tick)));
        if state.is_over() {
            break;
        }
    }
    (state, efforts)
}

#[test]
fn the_effort_rises_until_the_joint_moves_is_held_and_falls_until_it_rests() {
    // The joint moves a count at ticks 100, 104, 108, and so on up to tick 250, where it halts.
    let counts = |tick: u32| -7 + if tick < 100 { 0 } else { (tick.min(250) - 100) as i32 / 4 + 1 };
    let (state, efforts) = run(&ramp(), 10_000, counts);
    // The effort that has moved it is that of tick 99, the hundredth.
    assert_eq!(state.findings().stick, Some(100));
    // Two counts are seen at tick 104, at rung 104. 50 ticks of hold, then it falls from tick 154
    // on: the last count, at tick 248, follows 93 steps down.
    assert_eq!(efforts[104..=154], [ramp().volts(104); 51]);
    assert_eq!(efforts[155], ramp().volts(103));
    assert_eq!((state.findings().slip, state.findings().fall), (Some(104 - 93), 94));
    // The ramp is over after a second without a count, and its effort is never below zero.
    assert_eq!(efforts.len(), 248 + 501 + 1);
    assert!(efforts.iter().all(|effort| *effort >= 0.0));
    assert_eq!(efforts.last(), Some(&0.0));
}

#[test]
fn a_joint_that_does_not_move_gets_the_full_scale_once() {
    let (state, efforts) = run(&ramp(), 10_000, |_| 3);
    assert_eq!((state.findings().stick, state.findings().slip), (None, None));
    assert_eq!(efforts.len(), 2001);
    assert_eq!((efforts[1999], efforts[2000]), (1.0, 0.0));
}

#[test]
fn a_joint_that_does_not_stop_ends_the_ramp_after_twice_its_longest_fall() {
    let (state, efforts) = run(&ramp(), 100_000, |tick| tick as i32);
    assert_eq!((state.findings().stick, state.findings().slip), (Some(1), None));
    // The joint moves at tick 2, the effort is held for 50 ticks, and then come 2 x 2000 rungs and
    // a second.
    assert_eq!(efforts.len(), 2 + 50 + 4000 + 500 + 1 + 1);
}

#[test]
fn a_disc_that_flickers_on_an_edge_has_not_moved() {
    let flicker = |tick: u32| i32::from(tick < 40 && tick % 2 == 1);
    let counts = |tick: u32| if tick < 200 { flicker(tick) } else { 5 };
    let (state, _) = run(&ramp(), 10_000, counts);
    assert_eq!(state.findings().stick, Some(200));
}

#[test]
fn a_position_may_wrap_while_the_joint_moves() {
    let counts = |tick: u32| i32::MAX.wrapping_add(tick.saturating_sub(50).min(9) as i32);
    let (state, _) = run(&ramp(), 10_000, counts);
    // The joint halts before the effort falls.
    assert_eq!(
        (state.findings().stick, state.findings().slip, state.findings().fall),
        (Some(51), Some(52), 0)
    );
}

#[test]
fn the_effort_of_the_slowest_ramp_is_exact_to_single_precision_everywhere() {
    let (full_scale, sample_time) = (5.0, 0.02);
    let rate = 3.0 * full_scale / (MAX_TICKS * sample_time);
    let slowest = Ramp::new(rate, 0.0, sample_time, full_scale).unwrap();
    for rung in (0..33_000_000).step_by(999_983) {
        let exact = f64::from(rung) * f64::from(rate) * f64::from(sample_time);
        let error = f64::from(slowest.volts(rung)) - exact;
        // Three roundings: of the rung's effort, of a number of more than 24 bits, and of the
        // product.
        assert!(error.abs() <= 1.5 * f64::from(f32::EPSILON) * exact, "rung {rung}: {error}");
    }
}

#[test]
fn rates_and_times_without_an_end_are_refused_by_name() {
    let refused = |rate: f32, hold: f32| Ramp::new(rate, hold, 0.002, 5.0).unwrap_err();
    for rate in [0.0, -1.0, 7e-5, 2501.0, f32::NAN, f32::INFINITY] {
        let path = ValuePath(refused(rate, 0.0).key).to_string();
        assert_eq!(path, "identification.ramp_rates_v_per_s", "{rate}");
    }
    for hold in [-0.1, 200_001.0, f32::NAN, f32::INFINITY] {
        assert_eq!(
            ValuePath(refused(1.0, hold).key).to_string(),
            "identification.hold_s",
            "{hold}"
        );
    }
    for (rate, hold) in [(7.5e-5, 0.0), (2500.0, 200_000.0)] {
        assert!(Ramp::new(rate, hold, 0.002, 5.0).is_ok(), "{rate} {hold}");
    }
}
