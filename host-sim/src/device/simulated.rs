//! A simulated device: the core of the firmware around the joint of a machine's file. No motor moves or stops.

use stiction::Device;
use stiction::link::Kind;
use stiction::servo::{Boot, Input, Output};
use stiction::store::Store;

use crate::encoder::EncoderModel;
use crate::error::Error;
use crate::experiment::RunPlan;
use crate::flash::{SECTOR, SimulatedFlash};
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, ExactAxis};

/// Where the parameters lie in the flash.
const SLOTS: [u32; 2] = [0, SECTOR];

/// The converter's reading of a supply in the middle of its range.
const SUPPLY: u16 = 2048;

/// The wires of the encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wires {
    /// As they should be.
    #[default]
    Sound,
    /// Both cut: the counter stands.
    Cut,
    /// One cut: the other one's edges count up and down by turns.
    OneCut,
    /// The two exchanged.
    Swapped,
}

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
    axis: RobotAxis,
    solver: ExactAxis,
    encoder: EncoderModel,
    lsb_v: f64,
    sample_time_s: f64,
    /// The code of the tick before, if the run has a sample of computation delay.
    delayed: Option<i16>,
    ticks: u64,
    /// What the counter reads, and what it would read with sound wires.
    counter: u32,
    sound: u32,
}

impl SimulatedDevice {
    /// Power comes up: the joint of a run is at rest at zero, and the flash holds what the run says, with nothing that
    /// starts by itself.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn new(plan: &RunPlan) -> Result<Self, Error> {
        let mut parameters = super::parameters(plan)?;
        parameters.device.autostart = false;
        let mut store = Store::new(SimulatedFlash::new(2), SLOTS);
        // Cannot fail: the flash is new.
        let _ = store.save(&parameters);
        Self::with(plan, store, Boot::default())
    }

    /// The same with what is in a flash already.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn with(plan: &RunPlan, store: Store<SimulatedFlash>, boot: Boot) -> Result<Self, Error> {
        let (axis, encoder) = (plan.axis()?, plan.encoder()?);
        let sample_time_s = plan.machine.sampling.sample_time_s;
        let solver = ExactAxis::at_rest(&axis, sample_time_s);
        let counter = encoder.counter(0.0);
        Ok(Self {
            device: Device::start(store, boot),
            wires: Wires::Sound,
            supply: SUPPLY,
            brake_v: 0.0,
            axis,
            solver,
            encoder,
            lsb_v: plan.machine.drive.lsb_v,
            sample_time_s,
            delayed: (plan.machine.run.delay_samples == 1).then_some(0),
            ticks: 0,
            counter,
            sound: counter,
        })
    }

    /// One tick: the encoder is read, the core computes, and the joint moves on until the next one.
    pub fn tick(&mut self) -> Output {
        let sound = self.encoder.counter(self.solver.position());
        let edges = sound.wrapping_sub(std::mem::replace(&mut self.sound, sound));
        let flicker = edges & 1;
        self.counter = match self.wires {
            Wires::Sound => self.counter.wrapping_add(edges),
            Wires::Cut => self.counter,
            Wires::OneCut => self.counter ^ flicker,
            Wires::Swapped => self.counter.wrapping_sub(edges),
        };
        let output = self.device.tick(Input { counter: self.counter, supply: self.supply });
        let code = match &mut self.delayed {
            Some(before) => std::mem::replace(before, output.tick.code),
            None => output.tick.code,
        };
        // Off is off at once: that is the pin, not the computation.
        let v = if output.enable { f64::from(code) * self.lsb_v } else { 0.0 };
        let time_s = self.ticks as f64 * self.sample_time_s;
        let mut friction = self.axis.friction_at(time_s + 0.5 * self.sample_time_s);
        friction = friction.raised(self.brake_v);
        self.solver.advance(v, self.sample_time_s, &friction, &mut |_| {});
        self.ticks += 1;
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

    /// Noise on the encoder's wires: so many counts at once.
    pub const fn jump(&mut self, counts: i32) {
        self.counter = self.counter.wrapping_add(counts as u32);
    }

    /// True position of the joint, deg.
    pub fn position_deg(&self) -> f64 {
        self.solver.position()
    }

    /// True velocity of the joint, deg/s.
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.solver.velocity()
    }

    /// The joint is put somewhere, by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.solver = self.solver.clone().with_state(position_deg, velocity_deg_per_s);
    }

    /// Time between ticks, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// What it says it is.
    pub const fn kind(&self) -> Kind {
        Kind::Simulated
    }
}
