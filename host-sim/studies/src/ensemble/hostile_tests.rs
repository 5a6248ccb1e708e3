//! Random commands to the ensemble's joints, whose encoder's lines are cut, pick up noise and are
//! repaired: duty, heat and travel stay within bounds that were stated before the first run.
//!
//! Travel is the true travel of the encoder's side beyond the range of the set points since arming,
//! which includes the place of arming. The servo is configured with the bounds of the family's
//! friction, the nominal inertia and the derived limits, so it is wrong about each joint. Families
//! whose load is more than their friction are left out: nothing holds such a joint while its
//! encoder is dead.
//!
//! ```text
//! sound lines   following_error + encoder_jump
//! cut lines     v (T - J/b (1 - e^(-T b/J))),   v = (F - C + |load|) / b,   T = 4 s
//! ```
//!
//! F is `stall_v`; C, b and J are the true slip level, viscous friction and inertia. The bound is
//! the distance from rest under the stall threshold, in twice the time after which a silent encoder
//! has to prove itself. The bound of the first run left viscous friction out and was wider; T is
//! the same.
//!
//! Negative result: below the highest friction of the file, noise that counts looks like a living
//! encoder. The travel under it has no bound here and is printed.

use stiction::control::drive::Drive;
use stiction::control::reference::{Reference, Step};
use stiction::safety::encoder_proof::BY_HAND;
use stiction::servo::{Boot, Input, Output, State};
use stiction::units::position::Position;
use stiction::{Course, Motion, Parameters, Servo};

use super::assemble::parameters;
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use super::identified::TrueJoint;
use dynamics::joint::{AnyJoint, DiscSide, Joint as _, OpenLineDecoder, OpenLines};
use files::hardware::STM32F405;
use simulator::plant::DelayLine;
use simulator::rules::{GainRule, RULES};

/// Families whose friction holds their load.
const FAMILIES: [Family; 8] = [
    Family::Rigid,
    Family::Loaded,
    Family::Gravity,
    Family::LuGre,
    Family::FlexibleMotor,
    Family::FlexibleBacklash,
    Family::FlexibleLoad,
    Family::ThesisAxis,
];

/// Number of commands to a joint. They are 0.2 to 1.7 s apart, but one of eight lasts 8 s, so that
/// a silent encoder can be detected.
const COMMANDS: u32 = 60;

/// T in the bound of cut lines, s.
const SILENT_S: f64 = 4.0;

/// Largest ratio of the rms effort to `continuous_v`, which the motor tolerates forever. The model
/// of the servo and the sum here differ by a tick.
const HEAT: f64 = 1.005;

/// State of the encoder's lines.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lines {
    Sound,
    Cut,
    Noisy(OpenLineDecoder, i64),
}

/// A joint with its servo, and a record of what they did.
struct Hostile<'a> {
    case: &'a Case,
    parameters: Parameters,
    servo: Box<Servo>,
    joint: AnyJoint,
    delay: DelayLine,
    drive: Drive,
    random: chacha20::ChaCha8Rng,
    lines: Lines,
    /// True count at the last tick, and the decoder's count.
    disc: i64,
    counter: i64,
    /// Mean square of the effort over `thermal_s`, V^2, computed independently of the servo.
    heat: f64,
    /// Range of the set points since arming, relative to the place of arming, and that place, deg.
    span: [f64; 2],
    place: f64,
    was_armed: bool,
    /// Worst state of the lines since arming: 0 sound, 1 cut, 2 noisy.
    worst: usize,
    /// Largest travel outside of the set points for each worst state of the lines, deg.
    outside: [f64; 3],
    armed: u32,
    trips: u32,
}

impl<'a> Hostile<'a> {
    fn new(case: &'a Case, rule: &GainRule, seed: u64) -> Self {
        use chacha20::rand_core::SeedableRng as _;
        let mut parameters = parameters(&case.bounds, &rule.gains(&case.bounds));
        // The encoder has to prove itself, as in a file that `new` writes.
        parameters.limits.breakaway_min = 0.5 * case.bounds.breakaway[0] as f32;
        parameters.device.autostart = false;
        parameters.check().unwrap();
        let servo = Box::new(Servo::new(Ok(&parameters), Boot::at_zero(), &STM32F405));
        let drive = Drive::new(&parameters.controller.drive, &STM32F405).unwrap();
        let joint = case.joint.build().unwrap();
        let disc = case.encoder.read(&joint);
        Self {
            case,
            parameters,
            servo,
            joint,
            delay: DelayLine::new(case.delay),
            drive,
            random: chacha20::ChaCha8Rng::seed_from_u64(seed),
            lines: Lines::Sound,
            disc,
            counter: disc,
            heat: 0.0,
            span: [0.0; 2],
            place: 0.0,
            was_armed: false,
            worst: 0,
            outside: [0.0; 3],
            armed: 0,
            trips: 0,
        }
    }

    fn below(&mut self, end: u32) -> u32 {
        use chacha20::rand_core::Rng as _;
        ((u64::from(self.random.next_u32()) * u64::from(end)) >> 32) as u32
    }

    /// Returns the true position of the encoder's side, deg.
    fn at(&self) -> f64 {
        let turn = match self.case.encoder.side {
            DiscSide::Motor => self.joint.motor(),
            DiscSide::Load => self.joint.load(),
        };
        turn.position / self.case.scale.angle
    }

    fn count_deg(&self) -> f64 {
        self.case.count() / self.case.scale.angle
    }

    /// Runs one tick.
    fn tick(&mut self, name: &str) {
        let (disc, before) = (self.case.encoder.read(&self.joint), self.at());
        self.counter += match &mut self.lines {
            Lines::Sound => disc - self.disc,
            Lines::Cut => 0,
            Lines::Noisy(decoder, from) => decoder.move_to(disc - *from),
        };
        self.disc = disc;
        self.servo.heard();
        let supply = STM32F405.supply_top / 2;
        let output = self.servo.tick(Input {
            counter: self.counter as u32,
            supply,
            lines: 0,
            ..Input::default()
        });
        self.judge(&output, before, name);
        let code = self.delay.put(if output.enable { output.tick.code } else { 0 });
        let per_code = self.case.bounds.sampled.lsb * self.case.scale.effort;
        self.joint.hold(f64::from(code) * per_code, self.case.bounds.sampled.sample_time);
    }

    /// Checks the bounds that hold in every tick.
    fn judge(&mut self, output: &Output, before: f64, name: &str) {
        let is_armed = output.state == State::Armed;
        if is_armed != self.was_armed {
            (self.place, self.span, self.worst, self.was_armed) = (before, [0.0; 2], 0, is_armed);
            self.trips += u32::from(matches!(output.state, State::Faulted(_)));
        }
        let effort = f64::from(output.tick.v_applied) * f64::from(u8::from(output.enable));
        let largest = self.case.bounds.sampled.largest_effort;
        assert!(effort.abs() <= largest * (1.0 + 1e-6), "{name}: {effort} of {largest} V");
        assert!(output.tick.code.abs() <= self.drive.max_code(), "{name}: {}", output.tick.code);
        let limits = &self.parameters.limits;
        let thermal_s = f64::from(limits.thermal_time);
        let tick_s = self.case.bounds.sampled.sample_time;
        self.heat += (effort * effort - self.heat) * (1.0 - (-tick_s / thermal_s).exp());
        let bearable = f64::from(limits.continuous_effort) * HEAT;
        assert!(self.heat.sqrt() <= bearable, "{name}: {} of {bearable} V", self.heat.sqrt());
        if !is_armed {
            return;
        }
        self.armed += 1;
        let kind = match self.lines {
            Lines::Sound => 0,
            Lines::Cut => 1,
            Lines::Noisy(..) => 2,
        };
        self.worst = self.worst.max(kind);
        let set = f64::from(output.tick.reference_counts) * self.count_deg();
        self.span = [self.span[0].min(set), self.span[1].max(set)];
        let travel = before - self.place;
        let outside = (self.span[0] - travel).max(travel - self.span[1]);
        self.outside[self.worst] = self.outside[self.worst].max(outside);
        let bound = match self.worst {
            0 => f64::from(limits.following_error + limits.encoder_jump),
            1 => self.silent_deg(),
            _ => return,
        };
        assert!(outside <= bound, "{name}: {outside} of {bound} deg, lines {kind}");
    }

    /// Returns the bound of travel with cut lines, deg.
    fn silent_deg(&self) -> f64 {
        let TrueJoint { inertia, viscous, slip, load, .. } = TrueJoint::of(self.case);
        let push = f64::from(self.parameters.limits.stall_effort) - slip + load.abs();
        let settling_s = inertia / viscous;
        push / viscous * (SILENT_S - settling_s * (1.0 - (-SILENT_S / settling_s).exp()))
    }

    /// Sends a random command; if the servo is not armed, clears its fault and arms it again.
    fn command(&mut self) {
        let to_deg = [0.1, 0.4, 1.0, 5.0, 20.0][self.below(5) as usize];
        let sign = [-1.0, 1.0][self.below(2) as usize];
        let to = Position::from_counts((sign * to_deg / self.count_deg()) as i32);
        let Parameters { controller, profile, .. } = &self.parameters;
        let course = Motion::Profiled(to).course(controller, profile).unwrap();
        let Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
        let kind = self.below(10);
        if self.servo.state() != State::Armed {
            // A refusal is a valid answer, too.
            let _ = self.servo.clear();
            let _ = self.servo.arm_for_link(None);
            return;
        }
        let step = Reference::Step(Step { from: Position::default(), to, at_tick: 0 });
        let _ = match kind {
            0..=3 => self.servo.follow(step),
            4..=6 => self.servo.go_to(profile),
            7 => self.servo.hold(),
            8 => {
                self.servo.come_to_rest();
                Ok(())
            }
            _ => {
                self.servo.stop();
                Ok(())
            }
        };
    }

    /// Breaks the lines, or repairs them. After a repair, a person turns the joint to and fro if
    /// its encoder is in doubt.
    fn disturb(&mut self, name: &str) {
        if self.lines == Lines::Sound {
            let seed = u64::from(self.below(u32::MAX));
            let disc = self.disc;
            let noisy = |open| Lines::Noisy(OpenLineDecoder::new(open, seed), disc);
            self.lines = match self.below(5) {
                0 => noisy(OpenLines::One),
                1 => noisy(OpenLines::Both(4)),
                2 => noisy(OpenLines::Both(16)),
                _ => Lines::Cut,
            };
            return;
        }
        self.lines = Lines::Sound;
        if !self.servo.is_encoder_in_doubt() {
            return;
        }
        for counts in [i64::from(BY_HAND), -2 * i64::from(BY_HAND), i64::from(BY_HAND)] {
            self.counter += counts;
            for _ in 0..10 {
                self.tick(name);
            }
        }
    }
}

#[test]
fn random_commands_to_drawn_joints_move_heat_and_drive_them_no_further_than_the_bounds() {
    for family in FAMILIES {
        let (mut trips, mut armed_s) = (0, 0.0);
        let (mut most, mut noisy_deg) = ([0.0f64; 2], 0.0f64);
        for (number, rule) in (0..).zip(RULES) {
            let case = Case::draw(9, family, number, DrawOptions::ORDINARY);
            let mut hostile = Hostile::new(&case, rule, number);
            let tick_s = case.bounds.sampled.sample_time;
            for command in 0..COMMANDS {
                let name = format!("{}, {}, command {command}", family.name(), rule.law);
                hostile.command();
                if hostile.below(6) == 0 {
                    hostile.disturb(&name);
                }
                let is_long = hostile.below(8) == 0;
                let tenths = if is_long { 80 } else { 2 + hostile.below(16) };
                for _ in 0..(f64::from(tenths) * 0.1 / tick_s) as u32 {
                    hostile.tick(&name);
                }
            }
            let limits = &hostile.parameters.limits;
            let sound_deg = f64::from(limits.following_error + limits.encoder_jump);
            let [sound, cut, noisy] = hostile.outside;
            most[0] = most[0].max(sound / sound_deg);
            most[1] = most[1].max(cut / hostile.silent_deg());
            noisy_deg = noisy_deg.max(noisy);
            trips += hostile.trips;
            armed_s += f64::from(hostile.armed) * tick_s;
        }
        let [sound, cut] = most;
        let name = family.name();
        println!(
            "{name}: {sound:.2} and {cut:.2} of the bounds of sound and of cut lines; noise moved \
             it by up to {noisy_deg:.0} deg; armed for {armed_s:.0} s, {trips} trips"
        );
        // The joints were armed long enough and tripped often enough to test the bounds.
        assert!(armed_s > 200.0 && trips > 20, "{name}: {armed_s} s, {trips} trips");
    }
}
