//! The positioner, compared with the controller of a device, and with a simulated joint.

use super::*;
use crate::control::controller::{Controller, ControllerConfig, Reading};
use crate::control::drive::DriveConfig;
use crate::control::encoder::Encoder;
use crate::control::hardware::Hardware;
use crate::control::laws::Gains;
use crate::control::pd::PdGains;
use crate::units::value::Table;

/// A joint of 0.12 N m s^2/rad, say, with a step of the effort that is exact in `f32`.
pub(super) const CONFIG: PositionerConfig = PositionerConfig {
    sample_time: 1e-3,
    counts_per_turn: 100_000.0,
    largest_effort: 16.0,
    effort_step: 0.015_625,
    inertia: 0.12,
    viscous: 0.9,
    breakaway: [0.9, 3.0],
    load: 0.0,
    hold_effort: 0.0,
    jitter: 0.0,
    speed: 0.0,
    acceleration: 0.0,
    encoder_side: EncoderSide::Motor,
};

/// A rigid joint with static and dynamic friction, 2.4 and 2, and a wall. It is a fifth lighter
/// than configured.
#[derive(Clone, Copy)]
pub(super) struct Joint {
    /// Position, rad, and speed, rad/s.
    pub(super) position: f64,
    speed: f64,
    wall: f64,
}

impl Joint {
    pub(super) const AT_ZERO: Self = Self { position: 0.0, speed: 0.0, wall: f64::INFINITY };

    pub(super) fn counts(&self) -> i32 {
        let counts = self.position / core::f64::consts::TAU * 1e5;
        // The nearest one below.
        let whole = counts as i32;
        whole - i32::from(f64::from(whole) > counts)
    }

    /// Moves for 1 ms in steps of 10 us.
    pub(super) fn advance(&mut self, effort: f32) {
        for _ in 0..100 {
            let force = f64::from(effort) - 0.9 * self.speed;
            let before = self.speed;
            if before == 0.0 && force.abs() <= 2.4 {
                continue;
            }
            let direction = if before == 0.0 { force } else { before };
            self.speed += (force - 2.0 * direction.signum()) / 0.1 * 1e-5;
            if before != 0.0 && self.speed * before <= 0.0 {
                self.speed = 0.0;
            }
            self.position += self.speed * 1e-5;
            if self.position >= self.wall {
                (self.position, self.speed) = (self.wall, 0.0);
            }
        }
    }
}

const HARDWARE: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

/// Returns the configuration of the same loop in a device.
fn device(config: &PositionerConfig) -> ControllerConfig {
    let (gains, around) = config.prepared().unwrap();
    let drive = DriveConfig {
        full_scale: around.full_scale,
        lsb: around.lsb,
        duty_max: 1.0,
        ..DriveConfig::EXAMPLE
    };
    ControllerConfig {
        sample_time: around.sample_time,
        encoder: Encoder { resolution: around.resolution, ..Encoder::EXAMPLE },
        drive,
        compensator: [Gains::Robust(gains)].into_iter().collect(),
        ..ControllerConfig::EXAMPLE
    }
}

/// A step, a slow ramp and the way back, in each tick the same bits as in a device.
#[test]
fn efforts_are_those_of_a_device_to_the_last_bit() {
    let positioner = Positioner::new(&CONFIG).unwrap();
    let controller = Controller::new(&device(&CONFIG), &HARDWARE).unwrap();
    let (mut state, mut other) = (positioner.start(), controller.start(0));
    let mut joint = Joint::AT_ZERO;
    let (mut moved, mut pulses) = (0, 0);
    for tick in 0..8000u32 {
        // 20 counts a second from 3 to 6 s.
        let ramp = 0.02 * tick.clamp(3000, 6000).saturating_sub(3000) as f32;
        let velocity = if (3000..6000).contains(&tick) { 20.0 / 1e5 * 6.283_185_5 } else { 0.0 };
        let position = match tick {
            0..6000 => positioner.position(0.3).displaced(ramp),
            _ => positioner.position(-0.1),
        };
        let counts = joint.counts();
        let effort =
            positioner.tick(&mut state, counts, Target { position, velocity, acceleration: 0.0 });
        let setpoint =
            Setpoint { position, velocity: velocity.to_degrees(), ..Setpoint::default() };
        let reading = Reading::position(counts);
        let expected = controller.follow(&mut other, reading, setpoint).v_applied;
        assert_eq!(effort.to_bits(), expected.to_bits(), "{tick}: {effort} {expected}");
        joint.advance(effort);
        moved += u32::from(effort.abs() > 3.0);
        pulses += u32::from((3000..6000).contains(&tick) && positioner.mode(&state) == Mode::Coast);
    }
    assert!(moved > 50 && pulses > 100, "{moved} {pulses}");
    assert!((joint.position + 0.1).abs() < 2.0 * core::f64::consts::TAU / 1e5);
}

#[test]
fn before_a_wall_it_gives_up_and_tries_again_on_request() {
    let positioner = Positioner::new(&CONFIG).unwrap();
    let mut state = positioner.start();
    let mut joint = Joint { wall: 0.2, ..Joint::AT_ZERO };
    let target = Target::at_rest(positioner.position(0.3));
    let run = |state: &mut PositionerState, joint: &mut Joint, ticks: u32| {
        for _ in 0..ticks {
            let effort = positioner.tick(state, joint.counts(), target);
            joint.advance(effort);
        }
    };
    run(&mut state, &mut joint, 4000);
    assert_eq!(positioner.mode(&state), Mode::GiveUp);
    joint.wall = f64::INFINITY;
    run(&mut state, &mut joint, 1000);
    assert_eq!(positioner.mode(&state), Mode::GiveUp);
    positioner.try_again(&mut state);
    run(&mut state, &mut joint, 2000);
    assert_eq!(positioner.mode(&state), Mode::Hold);
    assert!((joint.position - 0.3).abs() < 2.0 * core::f64::consts::TAU / 1e5);
}

#[test]
fn a_target_that_is_no_number_gets_no_effort_and_spoils_nothing() {
    let positioner = Positioner::new(&CONFIG).unwrap();
    let good = Target::at_rest(positioner.position(0.3));
    let mut fresh = positioner.start();
    let first = positioner.tick(&mut fresh, 7, good);
    for bad in [
        Target { velocity: f32::NAN, ..good },
        Target { velocity: f32::INFINITY, ..good },
        Target::at_rest(Position { counts: 0, fraction: f32::NAN }),
    ] {
        let mut state = positioner.start();
        positioner.tick(&mut state, 7, good);
        assert_eq!(positioner.tick(&mut state, 7, bad), 0.0, "{bad:?}");
        assert_eq!(positioner.tick(&mut state, 7, good), first, "{bad:?}");
        positioner.restart(&mut state);
        assert_eq!(positioner.tick(&mut state, 7, good), first);
    }
    assert!(first > 0.9);
}

/// The observer predicts the speed from the effort. If it gets the effort that the joint really
/// had, and that is less than requested, it does not overestimate the speed, and the law requests
/// more.
#[test]
fn an_effort_that_the_amplifier_has_cut_makes_no_speed() {
    let positioner = Positioner::new(&CONFIG).unwrap();
    let target = Target::at_rest(positioner.position(3.0));
    let run = |reports: bool| {
        let (mut state, mut joint) = (positioner.start(), Joint::AT_ZERO);
        let (mut applied, mut worst) = (0.0f32, 0.0f32);
        for _ in 0..12 {
            let said = if reports { applied } else { state.applied };
            let asked = positioner.tick_applied(&mut state, joint.counts(), target, said);
            worst = worst.max(asked);
            applied = asked.clamp(-4.0, 4.0);
            joint.advance(applied);
        }
        worst
    };
    let (heard, unheard) = (run(true), run(false));
    assert!(heard > 1.1 * unheard, "{heard} {unheard}");
}

#[test]
fn each_field_is_refused_on_either_side_of_its_range() {
    let of = |change: fn(&mut PositionerConfig, f32), value: f32| {
        let mut config = CONFIG;
        change(&mut config, value);
        Positioner::new(&config).err()
    };
    type Case = (&'static str, fn(&mut PositionerConfig, f32), f32, f32);
    let cases: [Case; 13] = [
        ("sample_time", |c, x| c.sample_time = x, 1e-5, 0.1),
        ("counts_per_turn", |c, x| c.counts_per_turn = x, 16.0, 16_777_216.0),
        ("largest_effort", |c, x| c.largest_effort = x, 3.0, 15_625.0),
        ("effort_step", |c, x| c.effort_step = x, 1.6e-5, 16.0),
        ("inertia", |c, x| c.inertia = x, 1e-6, 1e6),
        ("viscous", |c, x| c.viscous = x, 0.0, 1e6),
        ("breakaway[0]", |c, x| c.breakaway[0] = x, 1.6e-5, 3.0),
        ("breakaway[1]", |c, x| c.breakaway[1] = x, 0.9, 16.0),
        ("load", |c, x| c.load = x, 0.0, 16.0),
        ("hold_effort", |c, x| c.hold_effort = x, -16.0, 16.0),
        ("jitter", |c, x| c.jitter = x, 0.0, 100.0),
        ("speed", |c, x| c.speed = x, 0.0, 1e6),
        ("acceleration", |c, x| c.acceleration = x, 0.0, 1e6),
    ];
    for (field, change, low, high) in cases {
        for value in [low, high] {
            assert_eq!(of(change, value), None, "{field} {value}");
        }
        for value in [low - 1e-5 * low.abs().max(1e-3), high * 1.001, f32::NAN, f32::INFINITY] {
            assert!(of(change, value).is_some(), "{field} {value}");
        }
    }
    let why = of(|c, x| c.viscous = x, -1.0).unwrap();
    assert_eq!(why, Refused { field: "viscous", found: -1.0, low: 0.0, high: 1e6 });
}

/// A step and the way back under PD with a law, in each tick the same bits as in a device.
fn same_as_a_device<L: Law>(gains: L::Gains, as_gains: Gains) {
    let config = PdConfig {
        sample_time: 1e-3,
        counts_per_turn: 100_000.0,
        largest_effort: 16.0,
        effort_step: 0.015_625,
        kp: 60.0,
        kd: 9.0,
        velocity_window: 5,
    };
    let positioner = PdPositioner::<L>::new(&config, &gains).unwrap();
    let device = ControllerConfig {
        pd: PdGains { kp: 60f32.to_radians(), kd: 9f32.to_radians() },
        compensator: [as_gains].into_iter().collect(),
        ..device(&CONFIG)
    };
    let controller = Controller::new(&device, &HARDWARE).unwrap();
    let (mut state, mut other) = (positioner.start(), controller.start(0));
    let (mut joint, mut loud) = (Joint::AT_ZERO, 0);
    for tick in 0..3000u32 {
        let counts = joint.counts();
        let target = Target {
            position: Position::from_counts(if tick < 1500 { 900 } else { -400 }),
            velocity: if tick % 1000 < 100 { 0.2 } else { 0.0 },
            acceleration: if tick % 1000 < 50 { 4.0 } else { 0.0 },
        };
        let effort = positioner.tick(&mut state, counts, target);
        let reading = Reading::position(counts);
        let expected = controller.follow(&mut other, reading, target.setpoint()).v_applied;
        assert_eq!(effort, expected, "{} {tick}", as_gains.name());
        joint.advance(effort);
        loud += u32::from(effort.abs() > 2.4);
    }
    assert!(loud > 20, "{} {loud}", as_gains.name());
}

#[test]
fn each_law_of_the_thesis_beside_pd_gives_the_efforts_of_a_device() {
    use crate::control::laws::*;
    macro_rules! check {
        ($($Law:ident),+) => {$(
            let gains = <$Law as Law>::Gains::EXAMPLE;
            same_as_a_device::<$Law>(gains, Gains::$Law(gains));
        )+};
    }
    check!(
        ResetIntegral,
        RateVariableIntegral,
        ResetOffsetIntegral,
        Feedforward,
        DiscontinuousNonlinearProportional,
        SmoothRobustNonlinear,
        DisturbanceObserver,
        Robust
    );
}

#[test]
fn a_gain_of_a_law_is_refused_by_its_name() {
    use crate::control::laws::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
    let config = PdConfig {
        sample_time: 1e-3,
        counts_per_turn: 1e5,
        largest_effort: 5.0,
        effort_step: 5e-3,
        kp: 60.0,
        kd: 9.0,
        velocity_window: 5,
    };
    let refused = |config: &PdConfig, v_ms: f32| {
        let gains = SmoothRobustNonlinearGains { v_ms, alpha: 100.0 };
        PdPositioner::<SmoothRobustNonlinear>::new(config, &gains).err().map(|why| why.field)
    };
    assert_eq!(refused(&config, 0.4), None);
    assert_eq!(refused(&config, -0.1), Some("v_ms"));
    assert_eq!(refused(&PdConfig { velocity_window: 1, ..config }, 0.4), Some("velocity_window"));
    assert_eq!(refused(&PdConfig { kp: f32::NAN, ..config }, 0.4), Some("kp"));
}
