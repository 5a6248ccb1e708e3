//! A board with the simulated joint on its pins, in the situations that a fault may come in.

use host_sim::emulator::bench::Mishap;
use host_sim::emulator::board::Fitted;
use host_sim::emulator::parameters::watched_blob;
use host_sim::emulator::powered::Powered;
use host_sim::emulator::rig::Sample;
use host_sim::experiment::RunPlan;
use stiction::Fault;

use crate::bench::firmware;
use crate::common::plans;

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

pub use Situation::{Moving, Rest, Saturated};

pub const SITUATIONS: [Situation; 3] = [Rest, Moving, Saturated];

impl Situation {
    /// The motion that leads there by itself, under the thesis's loop of 20 ms; a slower PWM, since it costs most of
    /// the emulator's time.
    pub fn plan(self, law: &str, set: &[&str]) -> RunPlan {
        let line = "corner_times_s = [0.5, 20.5], corner_positions_deg = [0.0, 100.0], half_blend_s = 0.25";
        let trajectory = format!("reference.trajectories=[{{ {line} }}]");
        let (name, motion) = match self {
            Rest => ("step-response", "reference.steps_deg=[1.0]"),
            Moving => ("trajectory", &*trajectory),
            Saturated => ("step-response", "reference.steps_deg=[20.0]"),
        };
        plans(name, &[law], &[&["drive.pwm_hz=2000", motion], set].concat()).remove(0)
    }

    /// Samples from arming on until it is there.
    const fn samples(self) -> u32 {
        match self {
            Rest => 100,
            Moving => 75,
            Saturated => 4,
        }
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

/// A board that drives its joint.
pub struct Driven {
    pub powered: Powered,
}

impl Driven {
    /// In a situation, as its parameters lead there.
    pub fn into(situation: Situation, law: &str, set: &[&str]) -> Self {
        let mut driven = Self::boot(&situation.plan(law, set));
        driven.arm();
        let sample = driven.samples(situation.samples());
        assert!(sample.bridge.is_on(), "{law}, {situation:?}: {sample:?}");
        if situation == Saturated {
            assert_eq!(sample.code.abs(), 1024, "{law}");
        }
        driven
    }

    /// Power comes up.
    pub fn boot(plan: &RunPlan) -> Self {
        let record = watched_blob(plan).unwrap();
        let powered = Powered::on(&firmware(), [Some(&record), None], Fitted::default(), plan).unwrap();
        Self { powered }
    }

    /// Waits for the bridge.
    pub fn arm(&mut self) -> Sample {
        let armed = (0..10).map(|_| self.samples(1)).find(|sample| sample.bridge.is_on());
        armed.unwrap_or_else(|| panic!("not armed: {:?}", self.log()))
    }

    pub fn samples(&mut self, count: u32) -> Sample {
        self.powered.samples(count).unwrap()
    }

    pub fn log(&mut self) -> Vec<String> {
        let lines = self.powered.act(|held| held.rig.log.lines.clone()).unwrap();
        lines.into_iter().map(|line| line.text).collect()
    }

    /// What would be told after a reset.
    pub fn kept(&mut self) -> Kept {
        let [(address, _)] = firmware().variable("KEPT")[..] else { panic!("KEPT is not in one piece") };
        // Magic, fault, place, status.
        let words = self.powered.act(move |held| held.words(address, 4)).unwrap().unwrap();
        let fault = u8::try_from(words[1]).ok().and_then(Fault::from_code);
        Kept { fault, tick: words[2], value: f32::from_bits(words[3]) }
    }

    pub fn mishap(&mut self, mishap: Mishap) {
        self.powered.act(move |held| held.mishap(mishap)).unwrap();
    }

    pub fn pass(&mut self, ns: u64) {
        self.powered.pass(ns).unwrap();
    }

    /// The end of the last span of time in which the bridge was on, and now.
    pub fn off_and_now(&mut self) -> (u64, u64) {
        self.powered
            .act(|held| (held.spans().on_ns.last().map_or(0, |[_, until]| *until), held.now()))
            .unwrap()
    }
}
