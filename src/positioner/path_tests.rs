//! The profile of a move and the counter, each compared with a second calculation.

use super::*;
use crate::control::profile::{Profile, ProfileLimits};

const LIMITS: MoveConfig = MoveConfig {
    sample_time: 1e-3,
    counts_per_turn: 100_000.0,
    speed: 2.0,
    acceleration: 20.0,
    jerk: 625.0,
};

/// A move of a turn: the differences of its positions stay within the three limits, and the move
/// ends on its target. Speed and acceleration reach their limits.
#[test]
fn a_move_in_rad_keeps_its_limits_and_lands_on_its_end() {
    let mut path = MoveProfile::new(&LIMITS, Position::from_counts(-300)).unwrap();
    assert!(!path.is_moving());
    path.aim(Position::from_counts(99_700));
    // Exact: an f32 of all counts would have no digits left for the jerk.
    let of = |Target { position, .. }: Target| {
        (f64::from(position.counts) + f64::from(position.fraction)) * core::f64::consts::TAU / 1e5
    };
    let (mut before, mut ticks) = (path.target(), 0);
    let (mut speed, mut gain, mut most) = (0.0f64, 0.0f64, [0.0f64; 3]);
    while path.is_moving() {
        let now = path.update();
        let moved = (of(now) - of(before)) / 1e-3;
        let faster = (moved - speed) / 1e-3;
        for (most, found) in most.iter_mut().zip([moved, faster, (faster - gain) / 1e-3]) {
            *most = most.max(found.abs());
        }
        assert!((f64::from(now.velocity) - moved).abs() < 1e-4, "{ticks}: {now:?} {moved}");
        (before, speed, gain, ticks) = (now, moved, faster, ticks + 1);
    }
    // 2 pi / 2 + 2 / 20 + 2 * 20 / 625 s.
    assert!((3305..=3308).contains(&ticks), "{ticks}");
    // A long move turns no acceleration into its opposite: its jerk is a / T = 20 / 0.064.
    for (most, limit) in most.into_iter().zip([2.0, 20.0, 312.5]) {
        assert!(most > 0.98 * limit && most < 1.001 * limit, "{most} {limit}");
    }
    assert_eq!(path.target(), Target::at_rest(Position::from_counts(99_700)));
}

/// The same limits in degrees, as in a device.
#[test]
fn a_move_in_rad_is_that_of_a_device_in_degrees() {
    let limits = ProfileLimits {
        velocity: 2f32.to_degrees(),
        acceleration: 20f32.to_degrees(),
        jerk: 625f32.to_degrees(),
    };
    let end = Position::from_counts(5000);
    let mut path = MoveProfile::new(&LIMITS, Position::default()).unwrap();
    path.aim(end);
    let mut device = Profile::new(end, &limits, 1e-3, 360.0 / 1e5).unwrap();
    for tick in 0..600 {
        let (one, other) = (path.update(), device.update());
        let apart = one.position.ahead_of(0) - other.position.ahead_of(0);
        assert!(apart.abs() < 0.01, "{tick}: {one:?} {other:?}");
        assert!((one.velocity.to_degrees() - other.velocity).abs() < 0.01);
        assert!((one.acceleration.to_degrees() - other.acceleration).abs() < 1.0);
    }
    assert!(!path.is_moving() && !device.is_moving());
}

#[test]
fn a_move_can_be_stopped_and_started_again_elsewhere() {
    let mut path = MoveProfile::new(&LIMITS, Position::default()).unwrap();
    path.aim(Position::from_counts(50_000));
    for _ in 0..400 {
        path.update();
    }
    let at = path.target();
    path.stop();
    let mut ticks = 0;
    while path.is_moving() {
        path.update();
        ticks += 1;
    }
    // 2 rad/s ends after 0.1 s and half of the 64 ticks: (0.1 + 0.064) s, and 0.132 rad on.
    let way = path.target().position.ahead_of(at.position.counts) * core::f32::consts::TAU / 1e5;
    assert!((160..=167).contains(&ticks), "{ticks}");
    assert!((way - 0.164).abs() < 0.003, "{way}");
    path.restart(Position::from_counts(7));
    assert!(!path.is_moving());
    assert_eq!(path.update(), Target::at_rest(Position::from_counts(7)));
}

#[test]
fn a_limit_of_a_move_is_refused_by_the_name_of_its_field() {
    let of = |change: fn(&mut MoveConfig, f32), value: f32| {
        let mut config = LIMITS;
        change(&mut config, value);
        MoveProfile::new(&config, Position::default()).err()
    };
    type Case = (&'static str, fn(&mut MoveConfig, f32), [f32; 2], [f32; 2]);
    let cases: [Case; 5] = [
        ("sample_time", |c, x| c.sample_time = x, [1e-3, 2e-3], [1e-6, 0.2]),
        ("counts_per_turn", |c, x| c.counts_per_turn = x, [1e3, 1e7], [3.0, 2e7]),
        ("speed", |c, x| c.speed = x, [0.01, 100.0], [1e-7, 1e6]),
        ("acceleration", |c, x| c.acceleration = x, [1.0, 70.0], [1e-5, 2e6]),
        // At least 2 a / (256 h) = 156.25, so that the averages fit.
        ("jerk", |c, x| c.jerk = x, [156.26, 1e9], [156.2, f32::NAN]),
    ];
    for (field, change, good, bad) in cases {
        for value in good {
            assert_eq!(of(change, value), None, "{field} {value}");
        }
        for value in bad {
            let why = of(change, value).unwrap();
            assert_eq!(why.field, field, "{value}: {why}");
            assert!(!(why.low..=why.high).contains(&value), "{why}");
        }
    }
}

/// A timer of 16 bits, and a joint that moves to and fro across the ends of the timer and of an
/// `i32`.
#[test]
fn a_counter_keeps_its_position_across_the_ends_of_its_range() {
    for (direction, sign) in [(Direction::Forward, 1i64), (Direction::Reverse, -1)] {
        let mut counter = Counter::new(CounterBits::Sixteen, direction, 65_000);
        counter.set_position(i32::MAX - 40_000);
        let mut truth = 0i64;
        for step in 0..2000i64 {
            truth += if step < 1500 { 30_011 } else { -29_000 };
            let reading = (65_000 + truth).rem_euclid(65_536) as u32;
            let expected = i64::from(i32::MAX - 40_000) + sign * truth;
            assert_eq!(counter.update(reading), expected as i32, "{step}");
        }
        assert_eq!(counter.position(), counter.update((65_000 + truth).rem_euclid(65_536) as u32));
    }
}
