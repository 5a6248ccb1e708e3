//! `robust` in a loop of 1 kHz leaves the swings of a motor against its gear to its own guard. So
//! its monitors have wider limits there than under another law: how late they see a fault, and how
//! far the joint goes until then.
//!
//! Two joints have 5 V at full scale, 0.4 V that start them and 0.38 V that keep them moving: the
//! thesis's, and a light one. The encoder is on either side of the transmission, which is rigid.

use std::f64::consts::TAU;

use simulator::device::client::Client;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use stiction::control::reference::Corner;
use stiction::control::signal::Tick;
use stiction::safety::monitor::Limits;
use stiction::servo::{Output, State};
use stiction::units::position::Position;
use stiction::{Fault, Motion};

use crate::fixture::{parameters, plans};

const TICK_S: f64 = 0.001;
const FULL_SCALE: f64 = 5.0;
const SLIP: f64 = 0.38;
/// The volts of a code, and the largest code within 0.4 V.
const LSB: f64 = 0.00488;
const BREAKAWAY: f64 = 81.0;
/// The law's largest configured breakaway effort, V.
const HIGHEST: f64 = 1.03;

struct Joint {
    name: &'static str,
    /// Deg/s^2 for a volt.
    gain: f64,
    /// V s/deg.
    viscous: f64,
    /// Deg.
    count: f64,
}

const JOINTS: [Joint; 2] = [
    Joint { name: "the thesis's", gain: 27.0, viscous: 0.02, count: 0.00242 },
    Joint { name: "a light one", gain: 1800.0, viscous: 0.005, count: 0.018 },
];

/// The side of the encoder, and the time over which the speed is a mean, ticks.
const SIDES: [(&str, f64); 2] = [("motor", 50.0), ("load", 100.0)];

/// Each joint with each side.
fn cases() -> impl Iterator<Item = (&'static Joint, &'static str, f64)> {
    JOINTS.iter().flat_map(|joint| SIDES.map(|(side, mean)| (joint, side, mean)))
}

/// The limit of the following error by the rules of the law, deg.
fn following_error(joint: &Joint, side: &str) -> f64 {
    // 8 Hz with the encoder on the motor, 2 Hz on the load.
    let bandwidth = TAU * if side == "motor" { 8.0 } else { 2.0 };
    let error_of = |effort: f64| effort * joint.gain / (bandwidth * bandwidth);
    // The profile accelerates with a quarter of the full scale to 0.15 of that without friction,
    // or to 3 rad/s.
    let speed = (0.15 * FULL_SCALE / joint.viscous).min(3.0f64.to_degrees());
    let way = speed * speed / (2.0 * 0.25 * FULL_SCALE * joint.gain);
    let swings = if side == "motor" { 2.0 } else { 1.0 };
    swings * way.max(error_of(HIGHEST)).min(error_of(FULL_SCALE))
}

struct Device {
    client: Client<SimulatedWire>,
    limits: Limits,
}

impl Device {
    /// A joint at rest under the law, armed by a client.
    fn armed(joint: &Joint, side: &str, set: &[&str]) -> Self {
        let keys = [
            "loop.controller=robust".into(),
            "reference.steps_deg=[5.0]".into(),
            format!("loop.sample_time_s={TICK_S}"),
            format!("joint.gain_deg_per_s2_per_v={}", joint.gain),
            format!("joint.viscous_v_per_deg_per_s={}", joint.viscous),
            format!("encoder.resolution_deg={}", joint.count),
            format!("controller.robust.inertia_v_s2_per_deg={}", 1.0 / joint.gain),
            format!("controller.robust.viscous_v_s_per_deg={}", joint.viscous),
            format!("controller.robust.breakaway_high_v={HIGHEST}"),
            format!("controller.robust.encoder_side={side}"),
        ];
        let keys: Vec<&str> = keys.iter().map(String::as_str).chain(set.iter().copied()).collect();
        let plan = &plans("step-response", &keys)[0];
        let limits = parameters(plan).limits;
        let simulated = SimulatedDevice::new(plan).unwrap();
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        client.arm().unwrap();
        let mut device = Self { client, limits };
        device.pass(100);
        device
    }

    /// The same after a first move, which has proven the wires.
    fn moved(joint: &Joint, side: &str, set: &[&str]) -> Self {
        let mut device = Self::armed(joint, side, set);
        device.client.step_to(3.0).unwrap();
        device.pass(3000);
        device
    }

    fn simulated(&mut self) -> &mut SimulatedDevice {
        &mut self.client.wire().simulated
    }

    fn position(&mut self) -> f64 {
        self.simulated().position_deg()
    }

    fn speed(&mut self) -> f64 {
        self.simulated().velocity_deg_per_s().abs()
    }

    fn tick(&mut self) -> Output {
        self.simulated().device.servo().heard();
        self.simulated().tick()
    }

    fn pass(&mut self, ticks: u32) {
        assert!((0..ticks).all(|_| self.tick().state == State::Armed));
    }

    /// The fault that comes within a time, and the ticks until then; before each, `done` is done.
    fn fault(&mut self, time_s: f64, done: impl Fn(&mut Self)) -> Option<(Fault, f64)> {
        let ticks = (time_s / TICK_S) as u32;
        (1..=ticks).find_map(|k| {
            done(self);
            match self.tick().state {
                State::Faulted(fault) => Some((fault, f64::from(k))),
                _ => None,
            }
        })
    }

    /// The way until the joint is at rest with the output off, deg.
    fn coast(&mut self) -> f64 {
        let from = self.position();
        while self.speed() > 0.0 {
            self.tick();
        }
        (self.position() - from).abs()
    }
}

#[test]
fn an_encoder_that_is_reversed_in_motion_leads_as_far_as_the_limit_of_the_error_says() {
    // With the monitor of progress it is detected earlier.
    let off = ["limits.progress_gain_deg_per_s2_per_v=off"];
    for (joint, side, _) in cases() {
        let limit = following_error(joint, side);
        for motion in ["a step", "a line"] {
            let name = format!("{}, encoder on the {side}, {motion}", joint.name);
            let mut device = Device::armed(joint, side, &off);
            let found = f64::from(device.limits.following_error);
            assert!((found - limit).abs() < 1e-4 * limit, "{name}: {found}, not {limit} deg");
            if motion == "a step" {
                device.client.step_to(90.0).unwrap();
                device.pass(120);
            } else {
                let at = |deg: f64| Position::from_counts((deg / joint.count) as i32);
                let corners = [(500, 0.0), (10_500, 50.0)]
                    .map(|(tick, deg)| Corner { tick, position: at(deg) });
                let corners = corners.into_iter().collect();
                device.client.move_along(Motion::Trajectory { corners, half_blend: 0.25 }).unwrap();
                device.pass(1500);
            }
            let (from, before) = (device.position(), device.speed());
            device.simulated().wires = Wires::Swapped;
            let (fault, ticks) = device.fault(3.0, |_| {}).unwrap();
            let travel = (device.position() - from).abs();
            // The faults of both turn the output off in their tick.
            let coast = device.coast();
            let wire = (joint.name, side, motion);
            reliability!(
                "fast-reversed",
                joint = wire.0,
                side = wire.1,
                motion = wire.2,
                fault = fault.describe(),
                ms = ticks,
                travel_deg = format!("{travel:.2}"),
                coast_deg = format!("{coast:.1}")
            );
            if fault == Fault::EncoderReversed {
                // No push had come to eight counts, or the wires had been proven. So it is seen
                // after eight counts and the seven at most of the last push, and the joint goes on
                // for the tick of the reading and the next.
                let most = (8.0 + 7.0) * joint.count + 2.0 * TICK_S * before.max(5.0);
                assert!(motion == "a line" && travel < most, "{name}: {travel} of {most} deg");
                continue;
            }
            assert_eq!(fault, Fault::FollowingError, "{name}");
            // What is read goes back by the limit, less what a line goes on meanwhile. All of the
            // effort may have gone with the motion, and the joint goes on for two ticks.
            let due = if motion == "a line" { limit - 5.0 * ticks * TICK_S } else { limit };
            let fastest = (before.powi(2) + 2.0 * joint.gain * FULL_SCALE * travel).sqrt();
            let expected =
                due - 4.0 * joint.count..due + 2.0 * TICK_S * fastest + 4.0 * joint.count;
            assert!(expected.contains(&travel), "{name}: {travel} of {expected:?} deg");
        }
    }
}

/// A joint that a load drives, with nothing to see it but its speed.
#[test]
fn a_speed_beyond_its_limit_is_seen_within_one_and_a_half_times_the_mean_of_a_swing() {
    for (joint, side, mean) in cases() {
        let mut slowest = 0.0f64;
        for faster in [1.05, 1.5, 4.0] {
            for phase in (0..mean as u32).step_by(7) {
                let name = format!("{}, {side}, {faster} times, after {phase}", joint.name);
                let off = ["limits.following_error_deg=off"];
                let mut device = Device::moved(joint, side, &off);
                device.pass(phase + 1);
                let speed = faster * f64::from(device.limits.overspeed);
                let (fault, ticks) = device
                    .fault(1.0, |device| {
                        let position = device.position();
                        device.simulated().push(position, speed);
                    })
                    .unwrap();
                assert_eq!(fault, Fault::Overspeed, "{name}");
                // It is beyond the limit when the travel in two halves of the mean is, and a half
                // that it does not fill may come before. Effort and friction slow it down in each
                // tick, from which it is pushed again.
                let against = FULL_SCALE + SLIP + joint.viscous * speed;
                let lost = 0.5 * joint.gain * against * TICK_S / speed * faster;
                let latest = mean * (0.5 + 1.0 / (faster - lost)) + 1.0;
                let expected = mean / faster - 1.0..=latest;
                assert!(expected.contains(&ticks), "{name}: {ticks} of {expected:?}");
                slowest = slowest.max(ticks);
            }
        }
        // With the limits that the law derives, another monitor is sooner.
        let mut device = Device::moved(joint, side, &[]);
        let (from, limit) = (device.position(), f64::from(device.limits.overspeed));
        let speed = 1.05 * limit;
        let found = device.fault(1.0, |device| {
            let position = device.position();
            device.simulated().push(position, speed);
        });
        let (fault, ticks) = found.unwrap();
        let travel = device.position() - from;
        let within = following_error(joint, side) + 2.0 * speed * TICK_S + 4.0 * joint.count;
        assert!(fault == Fault::FollowingError && travel < within, "{fault:?}: {travel} deg");
        reliability!(
            "fast-speed",
            joint = joint.name,
            side,
            limit = format!("{limit:.0}"),
            slowest,
            fault = fault.describe(),
            ms = ticks,
            travel_deg = format!("{travel:.2}")
        );
    }
}

/// Counts that come or go in one tick at rest, by noise.
#[test]
fn counts_that_appear_in_a_tick_pass_up_to_the_smaller_of_two_limits() {
    for (joint, side, _) in cases() {
        // Six times the overspeed in a tick, and four counts; or the error.
        let overspeed = 2.0 * (0.15 * FULL_SCALE / joint.viscous).min(3.0f64.to_degrees());
        let jump = ((6.0 * overspeed * TICK_S / joint.count + 4.0).round()) as i32;
        let error = (following_error(joint, side) / joint.count).round() as i32;
        let state = |counts: i32, set: &[&str]| {
            let mut device = Device::moved(joint, side, set);
            device.simulated().jump(counts);
            device.tick().state
        };
        let off = ["limits.following_error_deg=off"];
        for sign in [1, -1] {
            assert_eq!(state(sign * jump, &off), State::Armed, "{} {side}", joint.name);
            let seen = state(sign * (jump + 1), &off);
            assert_eq!(seen, State::Faulted(Fault::EncoderJump), "{} {side}", joint.name);
            // A joint in HOLD is up to two counts off its target.
            let least = jump.min(error) - 2;
            assert_eq!(state(sign * least, &[]), State::Armed, "{} {side}", joint.name);
            assert_ne!(state(sign * (least + 5), &[]), State::Armed, "{} {side}", joint.name);
        }
        let unseen = jump.min(error);
        let deg = format!("{:.2}", f64::from(unseen) * joint.count);
        reliability!("fast-jump", joint = joint.name, side, jump, error, unseen, deg);
    }
}

#[test]
fn a_law_that_has_given_up_says_so_until_the_next_motion_which_may_go_to_the_same_target() {
    let off = ["limits.stall_impulse_vs=off", "limits.stall_v=off"];
    let mut device = Device::moved(&JOINTS[0], "motor", &off);
    let is_reported = |device: &mut Device| {
        let output = device.tick();
        let gave_up = device.client.status().unwrap().gave_up;
        assert_eq!(output.tick.status & Tick::GAVE_UP != 0, gave_up);
        (gave_up, output.tick.v_applied)
    };
    assert!(!is_reported(&mut device).0);
    // A brake that no effort moves.
    device.simulated().brake_v = 100.0;
    device.client.move_to(3.1).unwrap();
    let time_s = (1..=5000).find(|_| is_reported(&mut device).0).unwrap();
    assert!(time_s > 100, "{time_s} ms: there was no time for three pulses");
    let held = is_reported(&mut device).1;
    assert!((0..500).all(|_| is_reported(&mut device) == (true, held)), "it goes on with {held} V");
    device.client.move_to(3.1).unwrap();
    assert!(!is_reported(&mut device).0, "the same target again is a motion");
    device.simulated().brake_v = 0.0;
    device.pass(2000);
    let counts = (device.position() - 3.1).abs() / JOINTS[0].count;
    assert!(counts <= 2.0 && !is_reported(&mut device).0, "{counts} counts");
    device.client.move_to(3.2).unwrap();
    device.simulated().brake_v = 100.0;
    (1..=5000).find(|_| is_reported(&mut device).0).unwrap();
    device.client.stop().unwrap();
    assert!(!device.client.status().unwrap().gave_up, "a servo that is off has no law");
}

/// What an encoder that is dead comes to.
struct End {
    fault: bool,
    time_s: f64,
    travel: f64,
    /// Effort beyond the breakaway times its time as the monitor adds it up, V s; and the most of
    /// it between two turns of its sign.
    impulse: f64,
    impulse_one_way: f64,
    /// As far as the effort beyond the slip level leads by itself, and the speed at the begin, deg.
    bound: f64,
}

/// Lets a minute pass, or until a fault, or until a joint at rest has had the same effort for three
/// seconds: the law is content, or has given up.
fn end(joint: &Joint, device: &mut Device) -> End {
    let (from, speed) = (device.position(), device.speed());
    let (mut impulse, mut beyond, mut ticks, mut fault) = (0.0, 0.0, 0, false);
    let [mut sign, mut one_way, mut impulse_one_way] = [0.0f64; 3];
    let (mut code, mut still) = (0, 0);
    while ticks < 60_000 && !fault && still < 3000 {
        let output = device.tick();
        fault = output.state != State::Armed;
        ticks += 1;
        still = if output.tick.code == code && device.speed() == 0.0 { still + 1 } else { 0 };
        code = output.tick.code;
        let effort = f64::from(output.tick.v_applied).abs();
        beyond += (effort - SLIP).max(0.0) * TICK_S;
        let excess = (effort / LSB).round() - BREAKAWAY;
        if excess > 0.0 {
            let added = excess.clamp((BREAKAWAY / 8.0).floor(), 4.0 * BREAKAWAY) * LSB * TICK_S;
            let signum = f64::from(output.tick.v_applied).signum();
            one_way = if signum == sign { one_way + added } else { added };
            (sign, impulse) = (signum, impulse + added);
            impulse_one_way = one_way.max(impulse_one_way);
        }
    }
    // The joint is linear while it moves, b x = integral of u - F_d, less J v.
    let bound = (beyond + speed / joint.gain) / joint.viscous;
    let travel = (device.position() - from).abs();
    End { fault, time_s: f64::from(ticks) * TICK_S, travel, impulse, impulse_one_way, bound }
}

/// Both wires or one are cut at rest or on the way of steps. In each case a stall ends it, or the
/// law gives up, and the joint is at rest.
#[test]
fn an_encoder_that_dies_leads_no_farther_than_the_impulse_lets_it() {
    for (joint, side, _) in cases() {
        for wires in [Wires::Cut, Wires::OneCut] {
            let [mut furthest, mut longest, mut one_way] = [0.0f64; 3];
            let [mut moments, mut rests] = [0; 2];
            let steps = [3.0 * joint.count, 0.1, 1.0, 5.0];
            for (step, moment) in steps.iter().flat_map(|step| (0..40).map(move |k| (step, k))) {
                let mut device = Device::armed(joint, side, &[]);
                if moment == 0 {
                    device.simulated().wires = wires;
                }
                device.client.step_to(*step).unwrap();
                device.pass(moment * 23);
                device.simulated().wires = wires;
                let end = end(joint, &mut device);
                let name = format!("{}, {side}, {wires:?}, {step} deg, {moment}", joint.name);
                moments += 1;
                assert!(end.travel <= end.bound + 1e-6, "{name}: {} of {}", end.travel, end.bound);
                // 0.2 V s, and what a tick adds: some may have been there before the cut.
                let most = 0.2 + 4.0 * BREAKAWAY * LSB * TICK_S;
                if wires == Wires::Cut {
                    assert!(end.impulse < most, "{name}: {}", end.impulse);
                }
                // The other wire flickers between two counts. It clears the impulse once if the
                // first of them was beside where the encoder lived last, and after that only with
                // an effort whose sign has turned, once a turn. Never both between two turns.
                let of_one_way = end.impulse_one_way;
                assert!(of_one_way < 2.0 * most, "{name}: {of_one_way} V s one way");
                one_way = one_way.max(of_one_way);
                if !end.fault {
                    rests += 1;
                    assert_eq!(device.speed(), 0.0, "{name}: it moves for ever");
                }
                furthest = furthest.max(end.travel);
                longest = longest.max(if end.fault { end.time_s } else { 0.0 });
            }
            reliability!(
                "fast-dead",
                joint = joint.name,
                side,
                wires = if wires == Wires::Cut { "both" } else { "one" },
                moments,
                furthest = format!("{furthest:.1}"),
                longest_s = format!("{longest:.1}"),
                one_way = format!("{one_way:.2}"),
                rests
            );
        }
    }
}
