//! A board with the simulated joint on its pins and a client on its USART, in the situations that a
//! fault may come in.

use emulator::board_under_test::HaltedBoard;
use emulator::coupling::ImageSample;
use emulator::wire::EmulatedWire;
use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::parameters;
use simulator::experiment::RunPlan;
use stiction::control::reference::Corner;
use stiction::link::{StateCode, Status};
use stiction::units::position::Position;
use stiction::{Fault, Motion, Tick};

use crate::common::{firmware, plans};

/// What the joint is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// On target after a step, with the effort that it rests with.
    Rest,
    /// Along a line of 5 deg/s.
    Moving,
    /// At the full scale of the output, on the way to a far target.
    Saturated,
}

pub const SITUATIONS: [Situation; 3] = [Situation::Rest, Situation::Moving, Situation::Saturated];

/// Gains by which a law is saturated as the others are on the way to a far target:
/// the profile within `robust` asks for a quarter of the full scale otherwise, and for the
/// friction.
pub fn harder(law: &str, situation: Situation) -> &'static [&'static str] {
    match (law, situation) {
        ("robust", Situation::Saturated) => &["controller.robust.acceleration_deg_per_s2=135"],
        _ => &[],
    }
}

/// A fault as the image has kept it for the time after a reset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    pub fault: Option<Fault>,
    /// The control tick since the reset before, if the fault has no other place.
    pub tick: u32,
    pub value: f32,
}

/// A board that is ready to be driven.
pub struct Driven {
    /// None while a session begins anew.
    client: Option<Client<EmulatedWire>>,
}

/// The thesis's loop of 20 ms; a slower PWM, since it costs most of the emulator's time.
fn plan(law: &str, set: &[&str]) -> RunPlan {
    let motion = ["drive.pwm_hz=2000", "reference.steps_deg=[5.0]"];
    plans("step-response", &[law], &[&motion, set].concat()).remove(0)
}

impl Driven {
    /// Power comes up.
    pub fn boot() -> Self {
        let wire = EmulatedWire::with(&firmware(), &plan("pd", &[])).unwrap();
        Self { client: Some(Client::connect(wire).unwrap()) }
    }

    pub fn client(&mut self) -> &mut Client<EmulatedWire> {
        self.client.as_mut().unwrap()
    }

    /// After a reset.
    pub fn connect_anew(&mut self) {
        let wire = self.client.take().unwrap().end();
        self.client = Some(Client::connect(wire).unwrap());
    }

    /// Everything is sound, the joint rests at zero, and the board has this law and these keys.
    pub fn take(&mut self, law: &str, set: &[&str]) {
        self.client().stop().unwrap();
        self.act(sound);
        self.act(|halted| halted.push(0.0, 0.0));
        self.client().set_parameters(&parameters(&plan(law, set)).unwrap()).unwrap();
        self.samples(10);
    }

    /// Brings the joint into a situation; it has moved before. Time stands still between two ticks,
    /// nearer to the first.
    pub fn bring(&mut self, situation: Situation) {
        self.client().arm().unwrap();
        self.client().step_to(1.0).unwrap();
        self.pass(100);
        let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
        match situation {
            Situation::Rest => {}
            Situation::Moving => {
                // 1 deg, and 20 deg further in 4 s.
                let corners = [corner(25, 413), corner(225, 413 + 8_264)].into_iter().collect();
                self.client().move_along(Motion::Trajectory { corners, half_blend: 0.25 }).unwrap();
                self.pass(100);
                let velocity = self.last_tick().velocity;
                assert!((velocity - 5.0).abs() < 1.5, "{velocity}");
            }
            Situation::Saturated => {
                self.client().step_to(20.0).unwrap();
                let sample = self.pass(4);
                assert_eq!(sample.code.abs(), 1024);
            }
        }
        let sample = self.samples(1);
        assert!(sample.bridge.is_on(), "{situation:?}: {sample:?}");
        self.status();
    }

    /// Samples with a client that is there.
    pub fn pass(&mut self, samples: u32) -> ImageSample {
        for _ in 0..samples / 10 {
            self.samples(10);
            self.status();
        }
        self.samples(samples % 10 + 1)
    }

    /// Samples of silence.
    pub fn samples(&mut self, count: u32) -> ImageSample {
        self.client().wire().board.samples(count).unwrap()
    }

    pub fn status(&mut self) -> Status {
        self.client().status().unwrap()
    }

    pub fn state(&mut self) -> StateCode {
        self.status().state
    }

    /// Lets time pass, ns.
    pub fn wait(&mut self, ns: u64) {
        self.client().wire().board.pass(ns).unwrap();
    }

    /// Does something to the board.
    pub fn act<T: Send + 'static>(
        &mut self,
        act: impl for<'a> FnOnce(&mut HaltedBoard<'a>) -> T + Send + 'static,
    ) -> T {
        self.client().wire().board.act(act).unwrap()
    }

    pub fn last_tick(&mut self) -> Tick {
        self.act(|halted| halted.last_tick().unwrap())
    }

    pub fn log(&mut self) -> Vec<String> {
        self.act(|halted| halted.harness.log.lines.iter().map(|line| line.text.clone()).collect())
    }

    /// Returns the fault that a reset would report.
    pub fn kept(&mut self) -> Kept {
        let [(address, _)] = firmware().variable("KEPT")[..] else {
            panic!("KEPT is not in one piece")
        };
        // Magic, fault, place, status.
        let words = self.act(move |halted| halted.words(address, 4)).unwrap();
        let fault = u8::try_from(words[1]).ok().and_then(Fault::from_code);
        Kept { fault, tick: words[2], value: f32::from_bits(words[3]) }
    }

    /// The end of the last span of time in which the bridge was on, and now.
    pub fn off_and_now(&mut self) -> (u64, u64) {
        self.act(|halted| {
            (halted.harness.spans.on_ns.last().map_or(0, |[_, until]| *until), halted.now())
        })
    }
}

/// Nothing is wrong with the board any more.
pub fn sound(halted: &mut HaltedBoard<'_>) {
    halted.rewire(Wires::Sound);
    halted.board().supply(1650);
    halted.plant().brake_v = 0.0;
}
