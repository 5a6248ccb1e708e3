//! Random messages to a device with a joint, with faults of wires, supply, load and board at random
//! times: nothing moves that no command has asked for, and the joint stays within what was asked.
//!
//! What is asked is the span of the set points since arming, with the place of the arming itself.
//! The bounds are those of the monitors, and of a joint that coasts.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::fault::Latched;
use stiction::identification;
use stiction::jog::Asked;
use stiction::link::{PROTOCOL, Request, encode_request};
use stiction::position::Position;
use stiction::servo::State;
use stiction::{Fault, Motion};

use crate::fixture::plans;
use crate::fuzz::Random;
use experiments::controllers;

// Tables 20 and 21 of the thesis: kappa, deg/s^2 per V; b, V s/deg; T_d, V; a count, deg.
const GAIN: f64 = 27.0;
const VISCOUS: f64 = 0.02;
const SLIP: f64 = 0.38;
const FULL_SCALE: f64 = 5.0;
const COUNT: f64 = 0.00242;
const TICK_S: f64 = 0.02;
/// The bounds of motions without a loop, which stay on their default of effort and time: deg and
/// deg/s.
const TRAVEL: f32 = 2.0;
const SPEED: f32 = 4.0;
/// The largest codes within 0.4 V, which start the joint, and within twice that.
const BREAKAWAY: u16 = 81;
const STALL: u16 = 163;

/// How far a joint coasts from a speed (deg/s) against its own friction, deg, in closed form.
fn coasting(speed: f64) -> f64 {
    coasting_against(SLIP, speed)
}

/// The same against what an effort leaves of the dry friction, V.
fn coasting_against(friction: f64, speed: f64) -> f64 {
    let tau = 1.0 / (GAIN * VISCOUS);
    let steady = friction / VISCOUS;
    tau * (speed.abs() - steady * (1.0 + speed.abs() / steady).ln())
}

fn request(random: &mut Random) -> Request {
    match random.below(18) {
        0 => Request::Stop,
        1 => Request::Clear,
        2..=5 => Request::Arm,
        6 => Request::Move(Motion::Hold),
        7..=10 => {
            let reach = [200, 2000, 8000][random.below(3) as usize];
            let counts = random.below(2 * reach) as i32 - reach as i32;
            Request::Move(Motion::Step(Position { counts, fraction: 0.0 }))
        }
        11 => Request::Hello { protocol: PROTOCOL, session: random.below(3) as u32 },
        12 => Request::Fault { index: random.next() as u8 },
        16 => Request::Jog(Asked { travel: Some(TRAVEL), speed: Some(SPEED), ..Asked::default() }),
        17 => Request::IdentifyJoint(identification::Asked {
            travel: Some(TRAVEL),
            speed: Some(SPEED),
            ..identification::Asked::default()
        }),
        13 => Request::Subscribe { signals: random.next(), every: random.below(20) as u16 },
        _ => Request::Status,
    }
}

/// A device, and what it may do.
struct Chaos {
    device: SimulatedDevice,
    /// The following error that is allowed, counts, and a jump of the encoder.
    beyond: [i32; 2],
    /// Set points since arming, in counts from there.
    span: [i32; 2],
    /// True position at the last arming or disarming, deg, and the speed there.
    place: f64,
    speed: f64,
    /// The largest effort since then, V.
    effort: f64,
    was_armed: bool,
    was_open: bool,
    /// Whether the wires have been sound since arming.
    is_sound: bool,
    /// Ticks with a dead encoder and an effort beyond the breakaway, and beyond any friction.
    dead: [u32; 2],
    armed: u64,
    trips: u64,
    moved: u64,
    /// Ticks of motions without a loop, and the farthest way in one, deg.
    open: u64,
    strayed: f64,
    outside: f64,
    coasted: f64,
}

impl Chaos {
    fn new(law: &str) -> Self {
        let controller = format!("loop.controller={law}");
        let supply = ["device.nominal_supply_v=12", "device.supply_full_scale_v=24"];
        let set = [&[&*controller, "reference.steps_deg=[5.0]"][..], &supply].concat();
        let plan = &plans("step-response", &set)[0];
        let limits = crate::fixture::parameters(plan).limits;
        let counts = |deg: f32| (f64::from(deg) / COUNT) as i32;
        Self {
            device: SimulatedDevice::new(plan).unwrap(),
            beyond: [counts(limits.following_error), counts(limits.encoder_jump)],
            span: [0; 2],
            place: 0.0,
            speed: 0.0,
            effort: 0.0,
            was_armed: false,
            was_open: false,
            is_sound: true,
            dead: [0; 2],
            armed: 0,
            trips: 0,
            moved: 0,
            open: 0,
            strayed: 0.0,
            outside: 0.0,
            coasted: 0.0,
        }
    }

    fn tick(&mut self, name: &str) {
        let (before, speed) = (self.device.position_deg(), self.device.velocity_deg_per_s());
        let output = self.device.tick();
        let is_armed = output.state == State::Armed;
        let servo = self.device.device.servo();
        let is_open = is_armed && (servo.is_jogging() || servo.identification_steps().is_some());
        // A motion without a loop may be stopped and armed anew between two ticks.
        if is_armed != self.was_armed || is_open != self.was_open {
            self.was_open = is_open;
            (self.place, self.speed, self.span) = (before, speed, [0; 2]);
            self.effort = 0.0;
            self.is_sound = self.device.wires == Wires::Sound;
            self.was_armed = is_armed;
            self.trips += u64::from(matches!(output.state, State::Faulted(_)));
        }
        let travel = self.device.position_deg() - self.place;
        if !is_armed {
            // Off: it coasts from the speed that it had, and not at all from rest.
            let bound = coasting(self.speed) + 1e-9;
            assert!(travel.abs() <= bound, "{name}: {travel} deg of {bound} with the output off");
            self.coasted = self.coasted.max(travel.abs());
            return;
        }
        self.armed += 1;
        self.is_sound &= self.device.wires == Wires::Sound;
        if is_open {
            self.open += 1;
            if self.is_sound {
                // Eight counts are let pass with all of the effort, and friction ends the rest.
                let speed = f64::from(SPEED) + (16.0 * COUNT * GAIN * FULL_SCALE).sqrt();
                let bound = f64::from(TRAVEL) + coasting(speed) + speed * TICK_S;
                assert!(travel.abs() < bound, "{name}: {travel} of {bound} deg without a loop");
                self.strayed = self.strayed.max(travel.abs());
            }
            return;
        }
        let (set, counts) = (output.tick.reference_counts, output.tick.counts);
        self.span = [self.span[0].min(set), self.span[1].max(set)];
        let [least, most] = self.span;
        if [least, most] == [0, 0] {
            // No command but arming: a joint that is at rest, within two counts, stays there. With
            // swapped wires a law may push it away from a count, until eight counts tell that
            // (reversed_encoder.rs); and with dead ones, or some that were dead until now, a joint
            // that coasts is taken for one at rest. A law that sees one line's count to and fro may
            // push it on with a part of the friction: 0.1 V of 0.38 V was seen, half is allowed.
            let effort = f64::from(output.tick.code) * FULL_SCALE / 1024.0;
            self.effort = self.effort.max(effort.abs());
            let left = SLIP - if self.is_sound { 0.0 } else { self.effort.min(SLIP / 2.0) };
            let noticed = if self.is_sound { 3.0 * COUNT } else { 0.2 };
            let bound = noticed + coasting_against(left, self.speed);
            assert!(travel.abs() <= bound, "{name}: {travel} deg, and nobody asked");
        } else {
            self.moved += 1;
        }
        // What is read never is farther outside than the following error. Where the wires have been
        // sound that is the joint, which goes on for a tick.
        let [following, jump] = self.beyond;
        assert!(
            (least - following..=most + following).contains(&counts),
            "{name}: at {counts} of {least} to {most} counts"
        );
        if self.is_sound {
            let outside = (f64::from(least) * COUNT - travel).max(travel - f64::from(most) * COUNT);
            let bound = f64::from(following + jump) * COUNT;
            assert!(outside < bound, "{name}: {outside} deg outside of {least} to {most} counts");
            self.outside = self.outside.max(outside);
        }
        // A dead encoder: 4 s beyond the breakaway at most, and 0.5 s of them beyond twice of it,
        // whatever else comes, unless it counts.
        if matches!(self.device.wires, Wires::Cut) {
            let code = output.tick.code.unsigned_abs();
            self.dead[0] += u32::from(code > BREAKAWAY);
            self.dead[1] += u32::from(code > STALL);
            let [above, stall] = self.dead.map(|ticks| f64::from(ticks) * TICK_S);
            assert!(above <= 4.04 && stall <= 0.54, "{name}: {above} s, {stall} s");
        } else {
            self.dead = [0; 2];
        }
    }

    /// Something goes wrong, or is mended.
    fn disturb(&mut self, random: &mut Random) {
        match random.below(12) {
            0 => self.device.wires = Wires::Cut,
            1 => self.device.wires = Wires::OneCut,
            2 => self.device.wires = Wires::Swapped,
            3 => self.device.brake_v = 0.1 * random.below(20) as f64,
            4 => self.device.supply = random.next() as u16,
            5 => {
                let fault = Fault::ALL[random.below(Fault::ALL.len() as u64) as usize];
                if fault.is_clearable() {
                    self.device.device.servo().latch(Latched::from(fault));
                }
            }
            _ => {
                (self.device.wires, self.device.brake_v) = (Wires::Sound, 0.0);
                self.device.supply = 2048;
            }
        }
    }
}

#[test]
fn nothing_moves_unasked_and_the_joint_stays_within_what_was_asked_whatever_goes_wrong() {
    let messages: u64 =
        std::env::var("STICTION_FUZZ").ok().and_then(|count| count.parse().ok()).unwrap_or(100_000);
    let each = (messages / 30).min(40_000);
    for law in controllers() {
        let mut chaos = Chaos::new(law);
        let mut random = Random(0x5713_C710_0000_0001 ^ law.len() as u64);
        let mut number = 0u16;
        let mut send = |chaos: &mut Chaos, request| {
            number = number.wrapping_add(1);
            chaos.device.device.receive(&encode_request(number, request).unwrap());
        };
        send(&mut chaos, Request::Hello { protocol: PROTOCOL, session: 0 });
        for message in 0..each {
            let mut content = request(&mut random);
            // After a fault, whoever is there clears it in the end and arms again.
            if message % 16 == 15 {
                chaos.device.supply = 2048;
                content = Request::Clear;
            }
            let opens = matches!(content, Request::Jog(_) | Request::IdentifyJoint(_));
            send(&mut chaos, content);
            // A motion without a loop takes a second or more to set out, and a client that is
            // there.
            for _ in 0..if opens { 12 } else { 0 } {
                for _ in 0..12 {
                    chaos.tick(&format!("{law}, message {message}"));
                }
                send(&mut chaos, Request::Status);
                chaos.device.device.transmit(&mut [0; 512]);
            }
            if random.below(8) == 0 {
                chaos.disturb(&mut random);
            }
            for _ in 0..random.below(40) {
                chaos.tick(&format!("{law}, message {message}"));
            }
            chaos.device.device.transmit(&mut [0; 512]);
        }
        let Chaos { armed, moved, open, strayed, trips, outside, coasted, .. } = chaos;
        let [outside_deg, strayed_deg, coasted_deg] =
            [outside, strayed, coasted].map(|deg| format!("{deg:.2}"));
        reliability!(
            "chaos",
            law,
            messages = each,
            armed,
            moved,
            open,
            trips,
            outside_deg,
            strayed_deg,
            coasted_deg
        );
        // What is to be tested has been reached.
        assert!(armed > each && moved > each / 4 && trips > each / 100, "{armed} {moved} {trips}");
        assert!(open > each / 20 && strayed > 0.1, "{open} {strayed}");
    }
}
