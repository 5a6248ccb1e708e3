//! Plant on the pins of an emulated board in lockstep: a joint that the bridge drives, or a disc
//! that the caller turns.

use stiction::control::drive::{Drive, DriveConfig};

use super::bridge::{BridgeInputs, code_of, nearest_code};
use dynamics::joint::RunJoint;
use files::error::Error;
use files::hardware::STM32F405;
use simulator::dc_link::DcLink;
use simulator::experiment::RunPlan;
use simulator::home_sensors::{IndexModel, SwitchModel};
use simulator::motor_ntc::Ntc;
use simulator::plant::{Discs, EffortState, Plant};
use simulator::shunt::Shunt;

/// Plant that the bridge drives, and whose position the encoders show.
pub trait PlantInterface: Send + std::fmt::Debug + 'static {
    /// Returns the positions of the discs.
    fn discs(&self) -> Discs;

    /// Returns the voltage on the pin that measures the motor's current, mV; `None` without a
    /// sensor.
    fn current_mv(&mut self) -> Option<u32> {
        None
    }

    /// Returns the voltage on the pin that measures the supply, mV; `None` if it is constant.
    fn supply_mv(&self) -> Option<u32> {
        None
    }

    /// Returns the voltage on the pin of the motor's temperature sensor, mV; `None` without one.
    fn temperature_mv(&self) -> Option<u32> {
        None
    }

    /// Returns whether the contact of the homing switch, or its wire, is open at a time, s.
    fn is_switch_open(&mut self, _at_s: f64) -> bool {
        true
    }

    /// Returns the index on the first disc; `None` without one.
    fn index(&self) -> Option<IndexModel> {
        None
    }

    /// Moves the plant by a sample under the state of the bridge, and returns the drive code of
    /// this state.
    fn hold(&mut self, bridge: &BridgeInputs, period_ns: u64) -> i16;

    /// Returns whether a current loop drives the plant: it is then moved once a period of the PWM,
    /// and not once a sample.
    fn is_regulated(&self) -> bool {
        false
    }

    /// Returns the drive code of a state of the bridge of a regulated plant.
    fn code(&mut self, _bridge: &BridgeInputs) -> i16 {
        0
    }

    /// Moves a regulated plant by half a period of the PWM under the state of the bridge.
    fn hold_half(&mut self, _bridge: &BridgeInputs) {}
}

/// Free discs. The caller turns them, the bridge does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeDiscs(pub Discs);

impl PlantInterface for FreeDiscs {
    fn discs(&self) -> Discs {
        self.0
    }

    fn hold(&mut self, _: &BridgeInputs, _: u64) -> i16 {
        0
    }
}

/// Power stage behind the bridge, which converts duties to drive codes.
#[derive(Clone, Copy, Debug)]
pub struct PowerStage {
    config: DriveConfig,
    drive: Drive,
}

impl PowerStage {
    /// Creates the power stage of a plan.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn of(plan: &RunPlan) -> Result<Self, Error> {
        let config = plan.controller_config()?.drive;
        Ok(Self { config, drive: *plan.closed_loop()?.controller.drive() })
    }

    /// Returns the drive code of the bridge's state: `near` if it has the same duty, 0 if the
    /// bridge is off. A duty that no code has, from a program other than the plan's, has the code
    /// of the nearest duty.
    pub fn code(&mut self, bridge: &BridgeInputs, near: i16) -> i16 {
        if !bridge.is_on() {
            return 0;
        }
        if bridge.top != self.drive.pwm_top() {
            let pwm_hz = STM32F405.pwm_clock_hz / (2.0 * f32::from(bridge.top));
            let config = DriveConfig { pwm_hz, ..self.config };
            if let Ok(drive) = Drive::new(&config, &STM32F405) {
                *self = Self { config, drive };
            }
        }
        let duty = bridge.duty(self.drive.mode());
        code_of(duty, &self.drive, near).unwrap_or_else(|| nearest_code(duty, &self.drive))
    }
}

/// The joint of a plan, driven by the board's bridge.
#[derive(Debug)]
pub struct DrivenPlant {
    /// Joint, with encoder and amplifier.
    pub plant: Plant<RunJoint>,
    /// Shunt amplifier of the motor, if it has a sensor of its current.
    pub shunt: Option<Shunt>,
    /// Temperature sensor of the motor, if it has one.
    pub ntc: Option<Ntc>,
    /// Supply of the bridge, if it has a capacitor. It is constant under a current loop.
    pub dc_link: Option<DcLink>,
    /// Homing switch of the joint.
    pub home_switch: SwitchModel,
    /// Index of the encoder: of two, of the motor's; `None` without one.
    pub index: Option<IndexModel>,
    stage: PowerStage,
    code: i16,
    /// Half a period of the PWM, s, if a current loop drives the motor.
    half_s: Option<f64>,
}

impl DrivenPlant {
    /// Creates the joint of a plan, at rest at zero.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn at_rest(plan: &RunPlan) -> Result<Self, Error> {
        let sample_s = plan.machine.sampling.sample_time_s();
        let half_s = plan.pwm_periods()?.map(|number| 0.5 * sample_s / f64::from(number));
        Ok(Self {
            plant: plan.plant()?,
            shunt: plan.shunt(),
            ntc: plan.ntc(),
            dc_link: plan.dc_link()?,
            home_switch: plan.home_switch()?,
            index: plan.index_on_wires()?,
            stage: PowerStage::of(plan)?,
            code: 0,
            half_s,
        })
    }
}

impl PlantInterface for DrivenPlant {
    fn discs(&self) -> Discs {
        self.plant.discs()
    }

    fn current_mv(&mut self) -> Option<u32> {
        Some(self.shunt.as_mut()?.pin_mv(self.plant.current_a()))
    }

    fn is_switch_open(&mut self, at_s: f64) -> bool {
        self.home_switch.is_high(self.plant.position_deg(), at_s)
    }

    fn index(&self) -> Option<IndexModel> {
        self.index
    }

    fn supply_mv(&self) -> Option<u32> {
        self.dc_link.as_ref()?.pin_mv()
    }

    fn temperature_mv(&self) -> Option<u32> {
        self.ntc.map(|ntc| ntc.pin_mv(self.plant.temperatures()))
    }

    fn hold(&mut self, bridge: &BridgeInputs, period_ns: u64) -> i16 {
        self.code = self.stage.code(bridge, self.code);
        let usual_s = self.plant.sample_time_s();
        let is_usual = period_ns == nanoseconds(usual_s);
        let sample_s = if is_usual { usual_s } else { period_ns as f64 * 1e-9 };
        if let Some(link) = &self.dc_link {
            self.plant.supply_ratio = link.ratio();
        }
        self.plant.put_out_and_hold(self.code, bridge.is_on(), sample_s);
        let drawn_j = self.plant.take_drawn_j();
        if let Some(link) = &mut self.dc_link {
            link.pass(drawn_j, bridge.brake_steps, sample_s);
        }
        self.code
    }

    fn is_regulated(&self) -> bool {
        self.half_s.is_some()
    }

    fn code(&mut self, bridge: &BridgeInputs) -> i16 {
        self.stage.code(bridge, self.code)
    }

    fn hold_half(&mut self, bridge: &BridgeInputs) {
        self.code = self.stage.code(bridge, self.code);
        if let Some(half_s) = self.half_s {
            let effort = EffortState { volts: self.plant.volts(self.code), is_on: bridge.is_on() };
            self.plant.hold_driven(effort, half_s);
        }
    }
}

/// Rounds a time to whole nanoseconds.
pub fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}
