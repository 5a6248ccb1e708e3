//! Random messages to a device with a joint, with faults of wires, supply, load and board at random
//! times: nothing moves that no command has asked for, and the joint stays within what was asked.
//!
//! What is asked is the span of the set points since arming, with the place of the arming itself.
//! The bounds are those of the monitors, and of a joint that coasts.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::control::reference::Corner;
use stiction::identification;
use stiction::link::{CHUNK, PROTOCOL, Request, encode_request};
use stiction::motion::jog::JogRequest;
use stiction::parameters::{DeviceConfig, ROOM, record};
use stiction::safety::encoder_proof::BY_HAND;
use stiction::safety::fault::LatchedFault;
use stiction::servo::State;
use stiction::units::position::Position;
use stiction::units::value::{Key, Table, key};
use stiction::{Fault, Motion, Parameters, ProfileLimits};

use crate::fixture::plans;
use crate::fuzz::Random;
use experiments::controllers;

// Tables 20 and 21 of the thesis: kappa, deg/s^2 per V; b, V s/deg; T_d, V; a count, deg.
const GAIN: f64 = 27.0;
const VISCOUS: f64 = 0.02;
const SLIP: f64 = 0.38;
const FULL_SCALE: f64 = 5.0;
const COUNT: f64 = 0.00242;
const LSB: f64 = 0.00488;
const TICK_S: f64 = 0.02;
/// The converter's reading of the nominal supply.
const SUPPLY: u16 = 2048;
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

/// Ramps of the effort: rate, V/s, and time between rise and fall, s. Each is over within three
/// seconds on a free joint.
const RAMPS: [(f64, f64); 3] = [(0.5, 0.0), (1.0, 0.1), (2.0, 0.2)];

/// The largest effort of a ramp at the nominal supply, V. Until two counts stop it, it
/// rises for as long as its impulse beyond 0.4 V is no more than 0.2 V s. Three of these: a place
/// beside the one that was counted last clears it, and so does a sign that has turned since.
fn ramp_effort(rate: f64) -> f64 {
    0.4 + (2.0 * 3.0 * 0.2 * rate).sqrt() + 2.0 * rate * TICK_S
}

/// How far a ramp moves a joint whose encoder counts, given the largest effort that it had, deg,
/// without viscous friction. Over three counts the joint gains speed under all of that effort. Two
/// counts are seen a tick later, and the next one applies what follows from them.
fn ramp_travel(effort: f64, (rate, hold): (f64, f64), speed: f64) -> f64 {
    // What is applied is rounded to codes.
    let excess = (effort + LSB - SLIP).max(0.0);
    let mut way = 3.0 * COUNT;
    let mut speed = speed.abs() + (2.0 * GAIN * excess * way).sqrt();
    let held = hold + 2.0 * TICK_S;
    way += speed * held + 0.5 * GAIN * excess * held * held;
    speed += GAIN * excess * held;
    // The effort falls in a straight line: to the slip level, and from there to zero or to rest.
    let fall = excess / rate;
    way += speed * fall + GAIN * excess * fall * fall / 3.0;
    speed += 0.5 * GAIN * excess * fall;
    let fall = (SLIP / rate).min((2.0 * speed / (GAIN * rate)).sqrt());
    way += speed * fall - GAIN * rate * fall.powi(3) / 6.0;
    speed -= 0.5 * GAIN * rate * fall * fall;
    way + speed * speed / (2.0 * GAIN * SLIP)
}

/// Corners that begin where the joint is, or beside it, and lead anywhere.
fn trajectory(random: &mut Random, here: i32) -> Motion {
    let near = random.below(400) as i32 - 200;
    let (mut tick, mut counts) = (13 + random.below(30) as u32, here.saturating_add(near));
    let corners = (0..2 + random.below(4)).map(|_| {
        let corner = Corner { tick, position: Position::from_counts(counts) };
        // Up to 100 counts a tick, which are 12 deg/s.
        let ticks = 60 + random.below(100) as i32;
        tick += ticks as u32;
        counts += (random.below(201) as i32 - 100) * ticks;
        corner
    });
    Motion::Trajectory { corners: corners.collect(), half_blend: 0.25 }
}

/// Other values for what no bound of this test depends on: how fast a profile goes, and how long
/// the soft start takes. Gains would do as well, but that a joint at rest stays there with wires
/// that are cut is known for the file's own gains only.
fn change(random: &mut Random) -> Request {
    let any = |random: &mut Random, some: [f32; 3]| some[random.below(3) as usize].to_bits();
    let of_profile = |name| key(ProfileLimits::ABOUT, name);
    let mut values: [(Key, u32); 3] = [
        (key(DeviceConfig::ABOUT, "soft_start"), any(random, [0.0, 0.1, 0.5])),
        (of_profile("velocity"), any(random, [2.0, 10.0, 20.0])),
        (of_profile("acceleration"), any(random, [10.0, 20.0, 35.0])),
    ];
    values.sort_unstable_by_key(|(key, _)| *key);
    let (mut room, mut length) = ([0; CHUNK], 0);
    for (key, bits) in values {
        record::put(&mut room, &mut length, key, bits).unwrap();
    }
    Request::Change { entries: room.into_iter().take(length).collect() }
}

/// A whole set with another soft start, in the requests that take it.
fn set(parameters: &Parameters, random: &mut Random) -> Vec<Request> {
    let mut other = parameters.clone();
    other.device.soft_start = [0.0, 0.25, 0.5][random.below(3) as usize];
    let mut room = [0; ROOM];
    let record = other.encode(0, &mut room).unwrap();
    let mut requests = Vec::new();
    for (i, piece) in record.chunks(CHUNK).enumerate() {
        let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
        requests.push(Request::WriteParameters { offset, bytes });
    }
    requests.push(Request::TakeParameters { length: record.len() as u16 });
    requests
}

/// Makes a message; some take more than one request. `here` is where the joint is, counts.
fn requests(parameters: &Parameters, here: i32, random: &mut Random) -> Vec<Request> {
    let one = match random.below(28) {
        18..=21 => {
            let reach = [20, 2000, 20_000][random.below(3) as usize];
            let counts = random.below(2 * reach) as i32 - reach as i32;
            Request::Move(Motion::Profiled(Position::from_counts(counts)))
        }
        22 | 23 => Request::Move(trajectory(random, here)),
        24 => {
            let (rate, hold) = RAMPS[random.below(3) as usize];
            Request::Identify { rate: rate as f32, hold: hold as f32 }
        }
        25 => change(random),
        26 => return set(parameters, random),
        27 => Request::Arm,
        kind => request(kind, random),
    };
    vec![one]
}

fn request(kind: u64, random: &mut Random) -> Request {
    match kind {
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
        16 => Request::Jog(JogRequest {
            travel: Some(TRAVEL),
            speed: Some(SPEED),
            ..JogRequest::default()
        }),
        17 => Request::IdentifyJoint(identification::IdentificationRequest {
            travel: Some(TRAVEL),
            speed: Some(SPEED),
            ..identification::IdentificationRequest::default()
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
    /// Whether a message has armed it since the last tick.
    is_armed_anew: bool,
    /// The ramp that it was armed for.
    ramp: Option<(f64, f64)>,
    /// Whether the wires have been sound since arming, and the supply nominal.
    is_sound: bool,
    is_supplied: bool,
    /// Where the joint was read last, counts from its arming.
    counts: i32,
    /// Ticks with a dead encoder and an effort beyond the breakaway, and beyond any friction.
    dead: [u32; 2],
    armed: u64,
    trips: u64,
    moved: u64,
    /// Ticks of motions without a loop, and the farthest way in one, deg.
    open: u64,
    strayed: f64,
    /// The same of ramps.
    ramped: u64,
    ramp_travel: f64,
    /// Ticks in which a profile or a trajectory moved the set point.
    led: u64,
    /// Requests with other parameters that were taken.
    taken: u64,
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
            is_armed_anew: false,
            ramp: None,
            is_sound: true,
            is_supplied: true,
            counts: 0,
            dead: [0; 2],
            armed: 0,
            trips: 0,
            moved: 0,
            open: 0,
            strayed: 0.0,
            ramped: 0,
            ramp_travel: 0.0,
            led: 0,
            taken: 0,
            outside: 0.0,
            coasted: 0.0,
        }
    }

    fn tick(&mut self, name: &str) {
        let (before, speed) = (self.device.position_deg(), self.device.velocity_deg_per_s());
        let output = self.device.tick();
        let is_armed = output.state == State::Armed;
        let servo = self.device.device.servo();
        let is_bounded = servo.is_jogging() || servo.identification_steps().is_some();
        let is_open = is_armed && (is_bounded || self.ramp.is_some());
        // A motion may be stopped and another one armed between two ticks.
        let is_anew = std::mem::take(&mut self.is_armed_anew);
        if is_armed != self.was_armed || is_open != self.was_open || is_anew {
            self.was_open = is_open;
            (self.place, self.speed, self.span) = (before, speed, [0; 2]);
            self.effort = 0.0;
            self.is_sound = self.device.wires == Wires::Sound;
            self.is_supplied = self.device.supply == SUPPLY;
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
        self.is_supplied &= self.device.supply == SUPPLY;
        self.counts = output.tick.counts;
        if let Some(ramp) = self.ramp {
            self.check_ramp(name, ramp, output.tick.code, travel);
            return;
        }
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
            // swapped wires a law may push it away from a count, until eight counts show that
            // (reversed_encoder.rs); and with dead ones, or some that were dead until now, a joint
            // that coasts is taken for one at rest. A law that sees one line's count to and fro may
            // push it on with a part of the friction: 0.1 V of 0.38 V was seen, half is allowed.
            let effort = f64::from(output.tick.code) * LSB;
            self.effort = self.effort.max(effort.abs());
            let left = SLIP - if self.is_sound { 0.0 } else { self.effort.min(SLIP / 2.0) };
            let noticed = if self.is_sound { 3.0 * COUNT } else { 0.2 };
            let bound = noticed + coasting_against(left, self.speed);
            assert!(travel.abs() <= bound, "{name}: {travel} deg without a command");
        } else {
            self.moved += 1;
            self.led += u64::from(output.tick.setpoint().velocity != 0.0);
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

    /// A ramp pushes one way, and no farther than its own effort explains. That holds for sound
    /// wires; with others the effort alone is bounded, and the supply may scale it by two.
    fn check_ramp(&mut self, name: &str, ramp: (f64, f64), code: i16, travel: f64) {
        self.ramped += 1;
        let effort = f64::from(code) * LSB;
        self.effort = self.effort.max(effort);
        let scale = if self.is_supplied { 1.001 } else { 2.0 };
        let most = scale * ramp_effort(ramp.0) + LSB;
        assert!((0.0..most).contains(&effort), "{name}: {effort} of {most} V in a ramp");
        if self.is_sound && self.is_supplied {
            let bound = ramp_travel(self.effort, ramp, self.speed);
            assert!(travel.abs() < bound, "{name}: {travel} of {bound} deg in a ramp");
            self.ramp_travel = self.ramp_travel.max(travel.abs());
        }
    }

    /// The device gets a request. Remembered is what it was armed for.
    fn receive(&mut self, number: u16, request: Request) {
        let ramp = match request {
            Request::Identify { rate, hold } => Some((f64::from(rate), f64::from(hold))),
            _ => None,
        };
        let changes = matches!(request, Request::Change { .. } | Request::TakeParameters { .. });
        let before = self.device.device.parameters().cloned();
        let was_armed = self.device.device.servo().state() == State::Armed;
        let session = self.device.device.session();
        self.device.device.receive(&encode_request(session, number, request).unwrap());
        let is_armed = self.device.device.servo().state() == State::Armed;
        if is_armed && !was_armed {
            self.is_armed_anew = true;
            self.ramp = ramp;
        }
        self.taken += u64::from(changes && self.device.device.parameters().cloned() != before);
    }

    /// A person turns the joint to and fro, if its encoder is in doubt and its wires are sound.
    fn turn_by_hand(&mut self, name: &str) {
        if self.device.wires != Wires::Sound || !self.device.device.servo().is_encoder_in_doubt() {
            return;
        }
        for counts in [0, BY_HAND as i32, -(BY_HAND as i32)] {
            self.device.jump(counts);
            // 50 ms of rest, and some more of coasting.
            for _ in 0..10 {
                self.tick(name);
            }
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
                    self.device.device.servo().latch(LatchedFault::from(fault));
                }
            }
            _ => {
                (self.device.wires, self.device.brake_v) = (Wires::Sound, 0.0);
                self.device.supply = SUPPLY;
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
            chaos.receive(number, request);
        };
        let parameters = chaos.device.device.parameters().unwrap().clone();
        send(&mut chaos, Request::Hello { protocol: PROTOCOL, session: 0 });
        for message in 0..each {
            let mut contents = requests(&parameters, chaos.counts, &mut random);
            // After a fault, the client clears it in the end and arms again.
            let clears = message % 16 == 15;
            if clears {
                chaos.device.supply = SUPPLY;
                contents = vec![Request::Clear];
            }
            let opens = matches!(
                contents[..],
                [Request::Jog(_) | Request::IdentifyJoint(_) | Request::Identify { .. }]
            );
            for content in contents {
                send(&mut chaos, content);
                chaos.device.device.transmit(&mut [0; 512]);
            }
            if clears {
                chaos.turn_by_hand(&format!("{law}, message {message}"));
            }
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
        let Chaos { armed, moved, led, open, strayed, ramped, trips, taken, .. } = chaos;
        let [outside_deg, strayed_deg, ramp_deg, coasted_deg] =
            [chaos.outside, strayed, chaos.ramp_travel, chaos.coasted]
                .map(|deg| format!("{deg:.2}"));
        reliability!(
            "chaos",
            law,
            messages = each,
            armed,
            moved,
            led,
            open,
            ramped,
            taken,
            trips,
            outside_deg,
            strayed_deg,
            ramp_deg,
            coasted_deg
        );
        // What is to be tested has been reached.
        assert!(armed > each && moved > each / 4 && trips > each / 100, "{armed} {moved} {trips}");
        assert!(open > each / 20 && strayed > 0.1, "{open} {strayed}");
        assert!(led > each / 10 && ramped > each / 20, "{led} {ramped}");
        assert!(taken > each / 200 && chaos.ramp_travel > 0.01, "{taken} {}", chaos.ramp_travel);
    }
}
