//! The supervisor in motion, on a motor that is where its profile is and a load that lags.

use super::super::Loop;
use super::RobustDualGains;
use super::supervisor::{Seen, Supervisor, SupervisorState};
use crate::control::motor_encoder::MotorEncoder;
use crate::units::value::Table;

const COUNT: f32 = 0.0036;

const AROUND: Loop = Loop {
    sample_time: 0.001,
    resolution: COUNT,
    full_scale: 5.0,
    lsb: 0.001,
    kp: 0.0,
    motor: MotorEncoder { count: COUNT, ..MotorEncoder::NONE },
};

/// Runs ticks of a set point at a speed (deg/s), with a load that lags behind its motor (deg).
/// `is_step`: the set point jumps from tick to tick instead. Returns the error of the load at the
/// end, deg.
fn error_after(ticks: u32, speed: f32, lag: f32, is_step: bool) -> f32 {
    let law = Supervisor::new(&RobustDualGains::EXAMPLE, &AROUND);
    let mut state = SupervisorState::default();
    law.start(&mut state);
    let mut error = 0.0;
    for tick in 0..ticks {
        let motor = state.profile.position;
        // The load leaves its rest once the motor has gone ahead by the lag.
        let load = motor.signum() * (motor.abs() - lag).max(0.0);
        let reference = speed * AROUND.sample_time * tick as f32;
        let velocity = if is_step { 0.0 } else { speed };
        law.update(&mut state, &Seen { motor, load, reference, velocity, applied: 0.0 });
        error = reference - load;
    }
    error
}

/// 0.2 deg are 56 counts: within the bound. After nine time constants, 1e-4 of the lag are left.
#[test]
fn load_that_lags_comes_to_its_set_point_in_motion() {
    for speed in [20.0f32, -20.0] {
        let error = error_after(1500, speed, 0.2, false);
        assert!(error.abs() < 0.01, "{error}");
        let soon = error_after(60, speed, 0.2, false);
        assert!(soon * speed > 0.0 && soon.abs() > 0.1, "{soon}");
    }
}

/// The lag of a set point that jumps is left to the attempts at rest.
#[test]
fn step_does_not_move_the_twist() {
    let error = error_after(1500, 20.0, 0.2, true);
    assert!(error > 0.15, "{error}");
}

#[test]
fn joint_that_a_load_drives_starts_with_less_gain() {
    let first_gain = |load: f32| {
        let gains = RobustDualGains { load, ..RobustDualGains::EXAMPLE };
        let mut state = SupervisorState::default();
        Supervisor::new(&gains, &AROUND).start(&mut state);
        state.guarded.gain
    };
    assert_eq!([first_gain(0.0), first_gain(0.5)], [1.0, 0.7]);
}
