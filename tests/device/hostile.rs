//! Random commands to a device whose wires pick up noise, or whose file is wrong: travel, heat and
//! duty stay within bounds that were stated before the first run.
//!
//! Travel is true travel outside of the set points since arming, with the place of the arming
//! itself. `chaos.rs` has silent wires, load, supply and faults of the board.

use dynamics::joint::{OpenLineDecoder, OpenLines};
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::experiment::RunPlan;
use stiction::control::reference::{Reference, Step};
use stiction::safety::encoder_proof::BY_HAND;
use stiction::servo::{Boot, State};
use stiction::units::position::Position;
use stiction::{Course, Motion};

use crate::fixture::{parameters, plans};
use crate::fuzz::Random;
pub use crate::noisy_encoder::COUNT;
use crate::noisy_encoder::coasting;
use experiments::controllers;

/// Commands in a run of one law.
const COMMANDS: u32 = 1500;

/// With open lines, the bound of noisy_encoder.rs: deg in one arming.
const NOISY_DEG: f64 = 90.0;

/// With an encoder against the motor: 8 counts end the first move, at full effort in a tick.
const REVERSED_DEG: f64 = 5.0;

/// The motor bears `continuous_v`, three quarters of 5 V; its model and the sum here differ by a
/// tick.
const CONTINUOUS_V: f64 = 3.75 * 1.005;

const TICK_S: f64 = 0.02;

/// A device and what it did.
pub struct Hostile {
    pub device: SimulatedDevice,
    pub random: Random,
    lines: Option<(OpenLineDecoder, f64)>,
    /// Mean square of the effort over 10 s, V^2: a second computation.
    heat: f64,
    /// Set points since arming, deg from there, and the place of the arming or the disarming, with
    /// the speed there.
    span: [f64; 2],
    place: f64,
    speed: f64,
    was_armed: bool,
    /// Whether the wires were sound in every tick since arming.
    is_sound: bool,
    pub armed: u32,
    pub trips: u32,
    pub hottest: f64,
    outside: f64,
    pub outside_sound: f64,
}

impl Hostile {
    pub fn new(device: SimulatedDevice, seed: u64) -> Self {
        Self {
            device,
            random: Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1),
            lines: None,
            heat: 0.0,
            span: [0.0; 2],
            place: 0.0,
            speed: 0.0,
            was_armed: false,
            is_sound: true,
            armed: 0,
            trips: 0,
            hottest: 0.0,
            outside: 0.0,
            outside_sound: 0.0,
        }
    }

    /// One tick, with what holds whatever goes wrong. Returns the travel outside of the set points
    /// of an armed joint, deg.
    pub fn tick(&mut self, name: &str) -> Option<f64> {
        let (before, speed) = (self.device.position_deg(), self.device.velocity_deg_per_s());
        if let Some((lines, from)) = &mut self.lines {
            let disc = ((before - *from) / COUNT).round() as i64;
            self.device.jump(lines.move_to(disc) as i32);
        }
        let output = self.device.tick();
        let is_armed = output.state == State::Armed;
        if is_armed != self.was_armed {
            (self.place, self.speed, self.span) = (before, speed, [0.0; 2]);
            self.is_sound = true;
            self.was_armed = is_armed;
            self.trips += u32::from(matches!(output.state, State::Faulted(_)));
        }
        let effort = f64::from(output.tick.v_applied) * f64::from(u8::from(output.enable));
        assert!(effort.abs() <= 5.0 && output.tick.code.abs() <= 1024, "{name}: {effort} V");
        self.heat += (effort * effort - self.heat) * (1.0 - (-TICK_S / 10.0).exp());
        self.hottest = self.hottest.max(self.heat.sqrt());
        assert!(self.heat.sqrt() <= CONTINUOUS_V, "{name}: {} V", self.heat.sqrt());
        let travel = self.device.position_deg() - self.place;
        if !is_armed {
            let bound = coasting(self.speed) + 1e-9;
            assert!(travel.abs() <= bound, "{name}: {travel} deg of {bound} with the output off");
            return None;
        }
        self.armed += 1;
        self.is_sound &= self.lines.is_none();
        let set = f64::from(output.tick.reference_counts) * COUNT;
        self.span = [self.span[0].min(set), self.span[1].max(set)];
        Some((self.span[0] - travel).max(travel - self.span[1]).max(0.0))
    }

    /// A client asks for something, or arms again.
    fn command(&mut self) {
        let sign = [-1.0, 1.0][self.random.below(2) as usize];
        let to_deg = sign * [0.1, 0.4, 1.0, 5.0, 20.0][self.random.below(5) as usize];
        let to = Position::from_counts((to_deg / COUNT) as i32);
        let course = {
            let parameters = self.device.device.parameters().unwrap();
            Motion::Profiled(to).course(&parameters.controller, &parameters.profile).unwrap()
        };
        let Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
        let kind = self.random.below(10);
        let servo = self.device.device.servo();
        if servo.state() != State::Armed {
            // Refusals are answers, too.
            let _ = servo.clear();
            let _ = servo.arm_for_link(None);
            return;
        }
        let _ = match kind {
            0..=3 => {
                servo.follow(Reference::Step(Step { from: Position::default(), to, at_tick: 0 }))
            }
            4..=6 => servo.go_to(profile),
            7 => servo.hold(),
            8 => {
                servo.come_to_rest();
                Ok(())
            }
            _ => {
                servo.stop();
                Ok(())
            }
        };
    }

    /// A person turns the joint to and fro, if its encoder is in doubt and its wires are sound.
    pub fn turn_by_hand(&mut self, name: &str) {
        if self.lines.is_some() || !self.device.device.servo().is_encoder_in_doubt() {
            return;
        }
        for counts in [0, BY_HAND as i32, -(BY_HAND as i32)] {
            self.device.jump(counts);
            for _ in 0..10 {
                self.device.device.servo().heard();
                self.tick(name);
            }
        }
    }

    /// The lines break or are repaired.
    fn disturb(&mut self) {
        let open = [OpenLines::One, OpenLines::Both(1), OpenLines::Both(4), OpenLines::Both(16)];
        let open = open[self.random.below(4) as usize];
        if self.lines.take().is_some() {
            self.device.wires = Wires::Sound;
        } else {
            self.device.wires = Wires::Cut;
            self.lines =
                Some((OpenLineDecoder::new(open, self.random.next()), self.device.position_deg()));
        }
    }
}

/// Returns the thesis's robot under a law, with values of its file set.
pub fn law_plan(law: &str, set: &[&str]) -> RunPlan {
    let law = format!("loop.controller={law}");
    plans("step-response", &[&[&*law, "reference.steps_deg=[5.0]"], set].concat()).swap_remove(0)
}

#[test]
fn noise_on_open_lines_moves_heats_and_drives_no_further_than_its_bounds() {
    for law in controllers() {
        let device = SimulatedDevice::new(&law_plan(law, &[])).unwrap();
        let following = {
            let limits = &device.device.parameters().unwrap().limits;
            f64::from(limits.following_error + limits.encoder_jump)
        };
        let mut hostile = Hostile::new(device, law.len() as u64);
        for command in 0..COMMANDS {
            let name = format!("{law}, command {command}");
            hostile.turn_by_hand(&name);
            hostile.command();
            if hostile.random.below(6) == 0 {
                hostile.disturb();
            }
            for _ in 0..10 + hostile.random.below(80) {
                hostile.device.device.servo().heard();
                let Some(outside) = hostile.tick(&name) else { continue };
                let bound = if hostile.is_sound { following } else { NOISY_DEG };
                assert!(outside <= bound, "{name}: {outside} of {bound} deg");
                if hostile.is_sound {
                    hostile.outside_sound = hostile.outside_sound.max(outside);
                } else {
                    hostile.outside = hostile.outside.max(outside);
                }
            }
        }
        let Hostile { armed, trips, .. } = hostile;
        assert!(armed > 5 * COMMANDS && trips > COMMANDS / 50, "{law}: {armed}, {trips}");
        let [outside_deg, outside_sound_deg, hottest_v] =
            [hostile.outside, hostile.outside_sound, hostile.hottest].map(|v| format!("{v:.1}"));
        reliability!("noisy-chaos", law, armed, trips, outside_deg, outside_sound_deg, hottest_v);
    }
}

#[test]
fn a_file_of_another_joint_moves_heats_and_drives_no_further_than_its_bounds() {
    for law in controllers() {
        for (what, key) in [
            ("half the friction", "limits.breakaway_v=0.2"),
            ("twice the friction", "limits.breakaway_v=0.8"),
            ("a third of the inertia", "joint.gain_deg_per_s2_per_v=81"),
            ("three times the inertia", "joint.gain_deg_per_s2_per_v=9"),
            ("the other direction", "encoder.direction=\"reverse\""),
        ] {
            let truth = law_plan(law, &[]);
            let wrong = parameters(&law_plan(law, &[key]));
            let limits = &wrong.limits;
            let bound = if what == "the other direction" {
                REVERSED_DEG
            } else {
                f64::from(limits.following_error + limits.encoder_jump)
            };
            let mut parameters = wrong.clone();
            parameters.device.autostart = false;
            let device = SimulatedDevice::running(&truth, &parameters, Boot::at_zero()).unwrap();
            let mut hostile = Hostile::new(device, law.len() as u64);
            for command in 0..COMMANDS / 5 {
                let name = format!("{law}, {what}, command {command}");
                hostile.turn_by_hand(&name);
                hostile.command();
                for _ in 0..10 + hostile.random.below(80) {
                    hostile.device.device.servo().heard();
                    let Some(outside) = hostile.tick(&name) else { continue };
                    assert!(outside <= bound, "{name}: {outside} of {bound} deg");
                    hostile.outside = hostile.outside.max(outside);
                }
            }
            let Hostile { armed, trips, .. } = hostile;
            let [outside_deg, hottest_v] =
                [hostile.outside, hostile.hottest].map(|v| format!("{v:.1}"));
            reliability!("wrong-file", law, what, armed, trips, outside_deg, hottest_v);
        }
    }
}
