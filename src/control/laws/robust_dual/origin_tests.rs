//! The law counts from origins that move: the readings of the counters have no effect on it.

use super::super::{FIRST_LAW, Gains, Law, LawInput, Loop};
use super::{Mode, RobustDual, RobustDualGains, RobustDualState};
use crate::control::controller::{Controller, ControllerConfig};
use crate::control::hardware::Hardware;
use crate::control::motor_encoder::MotorEncoder;
use crate::control::reference::Setpoint;
use crate::units::error::Allowed;
use crate::units::position::Position;
use crate::units::value::Table;

const HARDWARE: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

/// Motor counts for each count of the load.
const FINER: i32 = 64;

/// Angle of a count of the load, deg.
const COUNT: f32 = 0.0036;

const AROUND: Loop = Loop {
    sample_time: 0.001,
    resolution: COUNT,
    full_scale: 5.0,
    lsb: 0.001,
    kp: 0.0,
    motor: MotorEncoder { count: COUNT / FINER as f32, ..MotorEncoder::NONE },
};

/// Runs the law on a rigid joint that follows its set point at 40 counts a tick, and rests there.
/// Its motor is wound up by a constant twist, motor counts. Calls `see` after each tick.
fn follow(
    from: [i32; 2],
    to_counts: i32,
    twist: i32,
    mut see: impl FnMut(&RobustDual, &RobustDualState, f32),
) {
    let law = RobustDual::new(&RobustDualGains::EXAMPLE, &AROUND);
    let mut state = RobustDualState::default();
    let moving = to_counts / 40;
    for tick in 0..moving + 400 {
        let at = 40 * tick.min(moving);
        let [motor, load] = [from[0].wrapping_add(FINER * at + twist), from[1].wrapping_add(at)];
        let velocity = if tick < moving { 40.0 * COUNT / AROUND.sample_time } else { 0.0 };
        let position = Position { counts: load, fraction: 0.0 };
        let setpoint = Setpoint { position, velocity, acceleration: 0.0 };
        let input = LawInput {
            counts: load,
            motor_counts: motor,
            travel: 0,
            setpoint,
            error: 0.0,
            velocity,
            velocity_error: 0.0,
            v_pd: 0.0,
            applied: 0.0,
            saturated: false,
        };
        let effort = law.update(&mut state, &input);
        see(&law, &state, effort);
    }
}

#[test]
fn a_long_way_with_a_fine_encoder_moves_the_origins_and_no_level() {
    // 2^16 counts of the load are 2^22 of the motor, eight times the distance of a new origin.
    let (mut origins, mut modes) = (std::vec::Vec::new(), std::vec::Vec::new());
    follow([0, 0], 65_560, 0, |_, state, effort| {
        if origins.last() != Some(&state.origins) {
            origins.push(state.origins);
        }
        modes.push(state.mode());
        let levels = &state.supervisor.levels;
        assert!(levels.neutral.abs() < 0.05 * COUNT, "{} deg", levels.neutral);
        assert!(levels.half_width() < 4.1 * COUNT, "{} deg", levels.half_width());
        assert!(effort.is_finite());
    });
    assert!((8..=11).contains(&origins.len()), "{origins:?}");
    // Each has the motor's origin at the twist of the load's, which is none.
    assert!(origins.iter().all(|[motor, load]| *motor == FINER * load), "{origins:?}");
    // The set point stops at once. The inner profile stops within v/a of 144 deg/s and 2528
    // deg/s^2, and takes 1.41 times as long to come back: 138 ticks.
    let rested = modes.len() - 400;
    let held = modes.iter().skip(rested).position(|mode| *mode == Mode::Hold);
    assert!(held.is_some_and(|ticks| (120..160).contains(&ticks)), "{held:?}");
    assert!(modes.iter().rev().take(200).all(|mode| *mode == Mode::Hold));
}

#[test]
fn counters_that_wrap_are_the_same_to_the_law() {
    let run = |from| {
        let mut seen = std::vec::Vec::new();
        follow(from, 4000, 100, |law, state, effort| seen.push((effort, law.signals(state))));
        seen
    };
    let from_zero = run([0, 0]);
    assert!(from_zero.iter().any(|(effort, _)| *effort != 0.0));
    for from in [[i32::MAX - 1000, 0], [0, i32::MAX - 100], [i32::MIN, i32::MAX]] {
        assert!(run(from) == from_zero, "from {from:?}");
    }
}

#[test]
fn loop_with_one_encoder_refuses_the_law() {
    let with = |motor| ControllerConfig {
        motor,
        compensator: [Gains::RobustDual(RobustDualGains::EXAMPLE)].into_iter().collect(),
        ..ControllerConfig::EXAMPLE
    };
    let refused = Controller::new(&with(MotorEncoder::NONE), &HARDWARE).unwrap_err();
    assert_eq!((refused.key, refused.allowed), (FIRST_LAW, Allowed::AnotherLaw));
    assert!(Controller::new(&with(AROUND.motor), &HARDWARE).is_ok());
}

#[test]
fn state_has_384_bytes_at_most() {
    assert!(size_of::<RobustDualState>() <= 384, "{}", size_of::<RobustDualState>());
}

extern crate std;
