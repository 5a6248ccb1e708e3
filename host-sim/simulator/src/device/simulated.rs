//! A simulated device: the core of the firmware around the joint of a machine's file. No motor
//! moves or stops.
//!
//! It steps the same [`Plant`] as a [`Target`](crate::target::Target), in a loop of its own. A
//! target ends with its motion and gives a code. A device ticks on armed or not, answers a link
//! between two ticks, and has wires, a supply and a bridge's enable pin that may go wrong: a target
//! with all of that would be this one, and the others would have to do without most of it.

use std::collections::VecDeque;

use stiction::link::Kind;
use stiction::parameters::store::Store;
use stiction::servo::{Boot, Input, Output};
use stiction::{Device, Parameters};

pub use crate::encoder::Wires;
use crate::error::Error;
use crate::experiment::RunPlan;
use crate::flash::{SECTOR, SimulatedFlash};
use crate::hardware::STM32F405;
use crate::joint::RunJoint;
use crate::plant::Plant;
use crate::solver::AxisSolver as _;

/// Where the parameters lie in the flash.
const SLOTS: [u32; 2] = [0, SECTOR];

/// The converter's reading of a supply in the middle of its range.
const SUPPLY: u16 = 2048;

/// Changes of the gear's two sides that are remembered: those of a minute of motion at 10 kHz.
const REMEMBERED: usize = 600_000;

/// Changes below this are rounding, deg.
const SAME_DEG: f64 = 1e-9;

/// The device, its joint, and what is wrong with them.
#[derive(Debug)]
pub struct SimulatedDevice {
    /// The core.
    pub device: Device<SimulatedFlash>,
    /// The encoder's wires.
    pub wires: Wires,
    /// What the converter reads.
    pub supply: u16,
    /// Friction on top of the machine's own, V: a hand on the joint, a hard stop.
    pub brake_v: f64,
    plant: Plant<RunJoint>,
    /// What the counter reads, and what it would read with sound wires.
    counter: u32,
    sound: u32,
    /// The load's angle minus that of the encoder's side, deg, with the tick since which it is so.
    load_ahead: VecDeque<(u32, f64)>,
}

impl SimulatedDevice {
    /// Power comes up: the joint of a run is at rest at zero, and the flash holds what the run
    /// says, with nothing that starts by itself.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn new(plan: &RunPlan) -> Result<Self, Error> {
        let mut parameters = super::parameters(plan)?;
        parameters.device.autostart = false;
        Self::running(plan, &parameters, Boot::default())
    }

    /// Power comes up with other parameters in the flash than those of the run.
    ///
    /// # Errors
    /// Names a value of the run that is not allowed.
    pub fn running(plan: &RunPlan, parameters: &Parameters, boot: Boot) -> Result<Self, Error> {
        let mut store = Store::new(SimulatedFlash::new(2), SLOTS);
        // Cannot fail: the flash is new.
        let _ = store.save(parameters);
        Self::with(plan, store, boot)
    }

    /// The same with what is in a flash already.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn with(plan: &RunPlan, store: Store<SimulatedFlash>, boot: Boot) -> Result<Self, Error> {
        let plant = plan.plant()?;
        let counter = plant.counter();
        Ok(Self {
            device: Device::start(store, boot, STM32F405),
            wires: Wires::Sound,
            supply: SUPPLY,
            brake_v: 0.0,
            plant,
            counter,
            sound: counter,
            load_ahead: VecDeque::new(),
        })
    }

    /// One tick: the encoder is read, the core computes, and the joint moves on until the next one.
    pub fn tick(&mut self) -> Output {
        let sound = self.plant.counter();
        let ahead_deg = self.plant.solver.at_load() - self.plant.solver.at_encoder();
        let edges = sound.wrapping_sub(std::mem::replace(&mut self.sound, sound));
        let flicker = edges & 1;
        self.counter = match self.wires {
            Wires::Sound => self.counter.wrapping_add(edges),
            Wires::Cut => self.counter,
            Wires::OneCut => self.counter ^ flicker,
            Wires::Swapped => self.counter.wrapping_sub(edges),
        };
        let output = self.device.tick(Input { counter: self.counter, supply: self.supply });
        self.remember(output.clock, ahead_deg);
        self.plant.brake_v = self.brake_v;
        let sample_time_s = self.plant.sample_time_s();
        self.plant.put_out_and_hold(output.tick.code, output.enable, sample_time_s);
        output
    }

    /// Some ticks; the last output.
    pub fn ticks(&mut self, count: u32) -> Output {
        let mut output = self.tick();
        for _ in 1..count {
            output = self.tick();
        }
        output
    }

    /// Remembers the load's angle minus that of the encoder's side from a tick on.
    fn remember(&mut self, clock: u32, ahead_deg: f64) {
        if self.load_ahead.back().is_some_and(|(_, last)| (last - ahead_deg).abs() < SAME_DEG) {
            return;
        }
        if self.load_ahead.len() == REMEMBERED {
            self.load_ahead.pop_front();
        }
        self.load_ahead.push_back((clock, ahead_deg));
    }

    /// Returns the load's angle minus the angle of the side that the encoder sits on, deg, when the
    /// last tick read the encoder.
    pub fn load_ahead_deg(&self) -> f64 {
        self.load_ahead.back().map_or(0.0, |(_, deg)| *deg)
    }

    /// Returns the same in an earlier tick of the device's clock; none of one that is too long ago.
    pub fn load_ahead_at(&self, clock: u32) -> Option<f64> {
        let after = self.load_ahead.partition_point(|(since, _)| *since <= clock);
        after.checked_sub(1).and_then(|last| self.load_ahead.get(last)).map(|(_, deg)| *deg)
    }

    /// Noise on the encoder's wires: so many counts at once.
    pub const fn jump(&mut self, counts: i32) {
        self.counter = self.counter.wrapping_add(counts as u32);
    }

    /// True position of the joint, deg.
    pub fn position_deg(&self) -> f64 {
        self.plant.position_deg()
    }

    /// True velocity of the joint, deg/s.
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.plant.velocity_deg_per_s()
    }

    /// The joint is put somewhere, by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.plant.push(position_deg, velocity_deg_per_s);
    }

    /// Time between ticks, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.plant.sample_time_s()
    }

    /// What it says it is.
    pub const fn kind(&self) -> Kind {
        Kind::Simulated
    }
}
