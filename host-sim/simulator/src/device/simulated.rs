//! A simulated device: the core of the firmware around the joint of a machine's file. No motor
//! moves or stops.
//!
//! It steps the same [`Plant`] as a [`Target`](crate::target::Target), in a loop of its own. A
//! target ends with its motion and returns a code. A device runs whether armed or not, answers a
//! link between two ticks, and has encoder wires, a supply and an enable pin that can fail.

use std::collections::VecDeque;

use stiction::link::DeviceKind;
use stiction::parameters::store::Store;
use stiction::servo::{Boot, EncoderReading, Input, Output};
use stiction::{Device, Parameters};

pub use super::holding_brake::HoldingBrake;
use crate::current_periods::{CurrentPeriods, PlantMotor, RegulatedTick};
use crate::dc_link::DcLink;
use crate::experiment::RunPlan;
use crate::flash::{SECTOR, SimulatedFlash};
use crate::home_sensors::{IndexModel, SwitchModel};
use crate::motor_ntc::Ntc;
pub use crate::plant::MotorWires;
use crate::plant::Plant;
pub use crate::shunt::{Shunt, ShuntState};
use crate::winding_heat::Temperatures;
use dynamics::joint::RunJoint;
use dynamics::solver::AxisSolver as _;
pub use files::encoder::Wires;
use files::error::Error;
use files::hardware::STM32F405;

/// Flash addresses of the parameters.
const SLOTS: [u32; 2] = [0, SECTOR];

/// Reading of the supply converter in the middle of its range.
const SUPPLY: u16 = 2048;

/// Largest number of stored differences between the angles of load and encoder's side: one minute
/// of motion at 10 kHz.
const REMEMBERED: usize = 600_000;

/// Largest change that counts as rounding, deg.
const SAME_DEG: f64 = 1e-9;

/// Counter of an encoder whose wires can fail.
#[derive(Clone, Copy, Debug)]
struct WiredCounter {
    /// Counter reading.
    counter: u32,
    /// Counter reading with intact wires.
    sound: u32,
    /// Whether the resistors of the input pull down since the last tick.
    pulled_down: bool,
}

impl WiredCounter {
    const fn at(counter: u32) -> Self {
        Self { counter, sound: counter, pulled_down: false }
    }

    /// Returns the reading, given the one with intact wires.
    fn read(&mut self, sound: u32, wires: Wires, pulls_down: bool) -> EncoderReading {
        let edges = sound.wrapping_sub(std::mem::replace(&mut self.sound, sound));
        let pulls = u32::from(std::mem::replace(&mut self.pulled_down, pulls_down) != pulls_down);
        let flicker = (edges & 1) ^ pulls;
        self.counter = match wires {
            Wires::Sound => self.counter.wrapping_add(edges),
            // Line A follows its resistor before line B does.
            Wires::Cut => self.counter.wrapping_add(2 * pulls),
            Wires::OneCut => self.counter ^ flicker,
            Wires::Swapped => self.counter.wrapping_sub(edges),
        };
        let lines = wires.lines(sound, !pulls_down);
        EncoderReading { counter: self.counter, lines, is_missing: false }
    }
}

/// A simulated device with its joint and injected faults.
#[derive(Debug)]
pub struct SimulatedDevice {
    /// Firmware core.
    pub device: Device<SimulatedFlash>,
    /// State of the encoder's wires: of two encoders, that of the motor's.
    pub wires: Wires,
    /// State of the wires of the load's encoder, if there are two.
    pub load_wires: Wires,
    /// Reading of the supply converter.
    pub supply: u16,
    /// Friction in addition to that of the machine, V: a hand on the joint, a hard stop.
    pub brake_v: f64,
    /// Whether the motor has no supply; the reading of the converter stays as it is.
    pub is_unpowered: bool,
    /// External load on the joint, V: a spring, a bumper.
    pub load_v: f64,
    /// Shunt amplifier of the motor, if it has a sensor of its current.
    pub shunt: Option<Shunt>,
    /// Temperature sensor of the motor, if it has one.
    pub ntc: Option<Ntc>,
    /// State of the wires between bridge and motor.
    pub motor_wires: MotorWires,
    /// Ratio of the bridge's supply to that for which a code has its volts; the reading of the
    /// converter stays as it is.
    pub supply_ratio: f64,
    /// Supply of the bridge, if it has a capacitor: it sets `supply` and `supply_ratio` then.
    pub dc_link: Option<DcLink>,
    /// Duty of the brake resistor of the last tick, in steps of the core.
    pub brake_steps: u16,
    /// Reading of the supply that the last tick has started.
    converting: Option<u16>,
    /// Reading of the temperature sensor that the last tick has started.
    converting_ntc: Option<u16>,
    /// Whether the contact of the emergency stop is open.
    pub is_contact_open: bool,
    /// Homing switch of the joint.
    pub home_switch: SwitchModel,
    /// Index of the encoder: of two, of the motor's; `None` without one.
    pub index: Option<IndexModel>,
    /// Count of its disc in the last tick.
    disc: i64,
    /// Holding brake on the joint; `None` without one.
    pub holding_brake: Option<HoldingBrake>,
    /// Limits of the converter's watchdog since the last tick; none with the bridge off.
    window: Option<[u16; 2]>,
    /// The current loop, if the effort is a current.
    periods: CurrentPeriods,
    plant: Plant<RunJoint>,
    encoder: WiredCounter,
    /// Counter of the load's encoder, if there are two.
    load_encoder: Option<WiredCounter>,
    /// Load's angle minus that of the encoder's side, deg, with the tick of its last change.
    load_ahead: VecDeque<(u32, f64)>,
}

impl SimulatedDevice {
    /// Powers the device up: the joint of a run rests at zero, the flash holds the parameters of
    /// the run, and autostart is off.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn new(plan: &RunPlan) -> Result<Self, Error> {
        let mut parameters = super::parameters(plan)?;
        parameters.device.autostart = false;
        Self::running(plan, &parameters, Boot::at_zero())
    }

    /// Powers the device up with the given parameters in its flash.
    ///
    /// # Errors
    /// Returns an error that names the invalid value of the run.
    pub fn running(plan: &RunPlan, parameters: &Parameters, boot: Boot) -> Result<Self, Error> {
        let mut store = Store::new(SimulatedFlash::new(2), SLOTS);
        // Cannot fail: the flash is new.
        let _ = store.save(parameters);
        Self::with(plan, store, boot)
    }

    /// Powers the device up with an existing flash.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn with(plan: &RunPlan, store: Store<SimulatedFlash>, boot: Boot) -> Result<Self, Error> {
        let plant = plan.plant()?;
        let Input { counter, load, .. } = plant.counters().input(SUPPLY);
        let has_two = plant.counters().motor.is_some();
        Ok(Self {
            device: Device::start(store, boot, STM32F405),
            wires: Wires::Sound,
            load_wires: Wires::Sound,
            supply: SUPPLY,
            brake_v: 0.0,
            is_unpowered: false,
            load_v: 0.0,
            shunt: plan.shunt(),
            ntc: plan.ntc(),
            motor_wires: MotorWires::Sound,
            supply_ratio: 1.0,
            dc_link: plan.dc_link()?,
            brake_steps: 0,
            converting: None,
            converting_ntc: None,
            is_contact_open: false,
            home_switch: plan.home_switch()?,
            index: plan.index()?,
            disc: plant.discs().first,
            holding_brake: None,
            window: None,
            periods: CurrentPeriods::default(),
            plant,
            encoder: WiredCounter::at(counter),
            load_encoder: has_two.then(|| WiredCounter::at(load.counter)),
            load_ahead: VecDeque::new(),
        })
    }

    /// Runs one tick: reads the encoder, runs the core, and moves the joint until the next tick.
    pub fn tick(&mut self) -> Output {
        if let Some(link) = &self.dc_link {
            self.supply_ratio = link.ratio();
            if let Some(reading) = link.reading() {
                // A tick reads the conversion that the tick before has started.
                self.supply = self.converting.replace(reading).unwrap_or(reading);
            }
        }
        self.brake_steps = self.device.brake_resistor(self.supply);
        let sound = self.plant.counters().input(self.supply);
        let ahead_deg = self.plant.solver.at_load() - self.plant.solver.at_encoder();
        let servo = self.device.servo();
        let EncoderReading { counter, lines, .. } =
            self.encoder.read(sound.counter, self.wires, servo.pulls_down());
        let lines = if self.is_contact_open { lines } else { lines | Input::CONTACT };
        let at_s = f64::from(servo.clock()) * self.plant.sample_time_s();
        let lines = lines | self.home_switch.line(self.plant.position_deg(), at_s);
        let pulls_down = servo.pulls_load_down();
        let load = match &mut self.load_encoder {
            // A chip on a bus gives no answer, or one that is rejected.
            Some(_) if self.plant.discs().is_absolute && self.load_wires != Wires::Sound => {
                EncoderReading { is_missing: true, ..EncoderReading::default() }
            }
            Some(load) => load.read(sound.load.counter, self.load_wires, pulls_down),
            None => EncoderReading::default(),
        };
        let disc = self.plant.discs().first;
        let last = std::mem::replace(&mut self.disc, disc);
        if self.device.servo().has_index() {
            let tick_s = self.plant.sample_time_s();
            let index = self.index.as_mut();
            let at = index.and_then(|index| index.capture(last, disc, tick_s));
            // Noise has shifted the counter against its disc.
            let captured = at.map(|at| counter.wrapping_sub((disc - at) as u32));
            self.device.servo().pass_index(captured);
        }
        let has_loop = self.device.servo().has_current_loop();
        let current = match &mut self.shunt {
            Some(_) if has_loop => self.periods.reading(),
            Some(shunt) => shunt.reading(self.plant.current_a()),
            None => 0,
        };
        if let Some(reading) = self.periods.take_trip() {
            self.device.servo().over_current(reading);
        } else if !has_loop
            && let Some([low, high]) = self.window
            && !(low..=high).contains(&current)
        {
            // The converter's watchdog sees it within a period of the PWM.
            self.device.servo().over_current(current);
        }
        let output = self.device.tick(Input { counter, supply: self.supply, lines, current, load });
        if let Some(ntc) = &self.ntc {
            let reading = ntc.reading(self.plant.temperatures());
            let begun = self.converting_ntc.replace(reading).unwrap_or(reading);
            self.device.servo().take_ntc(begun);
        }
        // Parameters that come before the next tick have no offset of the sensor yet.
        self.window = self.device.servo().current_window().filter(|_| output.enable);
        self.remember(output.clock, ahead_deg);
        let tick_s = self.plant.sample_time_s();
        let held_v = match &mut self.holding_brake {
            Some(brake) => brake.update(output.brake(), tick_s),
            None => 0.0,
        };
        self.plant.brake_v = self.brake_v + held_v;
        self.plant.is_unpowered = self.is_unpowered;
        self.plant.load_v = self.load_v;
        self.plant.motor_wires = self.motor_wires;
        self.plant.supply_ratio = self.supply_ratio;
        self.drive(&output);
        let drawn_j = self.plant.take_drawn_j();
        if let Some(link) = &mut self.dc_link {
            link.pass(drawn_j, self.brake_steps, tick_s);
        }
        output
    }

    /// Moves the joint until the next tick.
    fn drive(&mut self, output: &Output) {
        let voltage = self.periods.voltage();
        let regulated = RegulatedTick::of(self.device.servo(), output, voltage);
        if let Some(sums) = self.periods.sums() {
            self.device.servo().pulsed(&sums);
        }
        if let (Some(regulated), Some(shunt)) = (regulated, &mut self.shunt) {
            let sample_time_s = self.plant.sample_time_s();
            let mut motor = PlantMotor { plant: &mut self.plant, shunt, on_event: |_| {} };
            self.periods.pass(&mut motor, sample_time_s, regulated);
            return;
        }
        self.plant.put_out_and_hold(output.tick.code, output.enable, self.plant.sample_time_s());
    }

    /// Runs `count` ticks and returns the last output.
    pub fn ticks(&mut self, count: u32) -> Output {
        let mut output = self.tick();
        for _ in 1..count {
            output = self.tick();
        }
        output
    }

    /// Returns the true position of the load, deg.
    pub fn load_deg(&self) -> f64 {
        self.plant.solver.at_load()
    }

    /// Stores the load's angle minus that of the encoder's side, with its tick.
    fn remember(&mut self, clock: u32, ahead_deg: f64) {
        if self.load_ahead.back().is_some_and(|(_, last)| (last - ahead_deg).abs() < SAME_DEG) {
            return;
        }
        if self.load_ahead.len() == REMEMBERED {
            self.load_ahead.pop_front();
        }
        self.load_ahead.push_back((clock, ahead_deg));
    }

    /// Returns the load's angle minus that of the encoder's side, deg, at the last tick.
    pub fn load_ahead_deg(&self) -> f64 {
        self.load_ahead.back().map_or(0.0, |(_, deg)| *deg)
    }

    /// Returns the load's angle minus that of the encoder's side, deg, at an earlier tick of the
    /// device's clock; `None` if that tick is too long ago.
    pub fn load_ahead_at(&self, clock: u32) -> Option<f64> {
        let after = self.load_ahead.partition_point(|(since, _)| *since <= clock);
        after.checked_sub(1).and_then(|last| self.load_ahead.get(last)).map(|(_, deg)| *deg)
    }

    /// Adds a jump of the counter: noise on the wires of the encoder, of two on those of the
    /// motor's.
    pub const fn jump(&mut self, counts: i32) {
        self.encoder.counter = self.encoder.counter.wrapping_add(counts as u32);
    }

    /// Adds a jump of the counter of the load's encoder, if there are two.
    pub const fn jump_load(&mut self, counts: i32) {
        if let Some(load) = &mut self.load_encoder {
            load.counter = load.counter.wrapping_add(counts as u32);
        }
    }

    /// Returns the true current of the motor once a period of the PWM between the last two ticks,
    /// A; empty without a current loop.
    pub fn currents_a(&self) -> &[f64] {
        self.periods.currents_a()
    }

    /// Returns the true current of the motor, A.
    pub const fn current_a(&self) -> f64 {
        self.plant.current_a()
    }

    /// Returns the temperatures of the motor; `None` without a heat path of its winding.
    pub fn temperatures(&self) -> Option<Temperatures> {
        self.plant.temperatures()
    }

    /// Returns the true position of the joint, deg.
    pub fn position_deg(&self) -> f64 {
        self.plant.position_deg()
    }

    /// Returns the true velocity of the joint, deg/s.
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.plant.velocity_deg_per_s()
    }

    /// Sets position (deg) and velocity (deg/s) of the joint, as if it was moved by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.plant.push(position_deg, velocity_deg_per_s);
    }

    /// Returns the time between two ticks, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.plant.sample_time_s()
    }

    /// Returns the kind of device that it reports.
    pub const fn kind(&self) -> DeviceKind {
        DeviceKind::Simulated
    }
}
