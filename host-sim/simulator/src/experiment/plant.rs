//! Joint and plant of a run, for a device, which can run longer than the run. Unlike the
//! Runge-Kutta axis, this joint can be moved by hand.

use stiction::ControllerConfig;
use stiction::control::controller::EffortMode;
use stiction::control::motor_encoder::{self, MotorEncoder};
use stiction::control::motor_ntc::MotorNtc;
use stiction::units::value::Table as _;

use super::plan::RunPlan;
use crate::current_periods::{BareCurrentLoop, half_period_s};
use crate::dc_link::DcLink;
use crate::motor_ntc::Ntc;
use crate::plant::{Delay, Plant, Winding};
use crate::shunt::Shunt;
use crate::winding_heat::HeatPath;
use dynamics::joint::{RunJoint, Substitute};
use files::data_sheet::tables::{DrivenBy, LoadEncoderKind, SupplyTable};
use files::data_sheet::{
    DataSheet, LoopSide, Mapping, Mount, SheetAxis, SheetFactors, SheetRefusal, SheetTables,
    UnseenSlack, WrittenDrive,
};
use files::error::Error;
use files::hardware::STM32F405;
use files::machine::AxisSolverName;
use stiction::control::current_sensor::CurrentSensor;

impl RunPlan {
    /// Returns the joint of this run, or that of its [truth](Self::truth), with amplifier and
    /// encoder, at rest at zero.
    ///
    /// # Errors
    /// Returns an error that names the invalid value, or an effect that only a run simulates.
    pub fn plant(&self) -> Result<Plant<RunJoint>, Error> {
        if let Some(truth) = &self.truth {
            return truth.plant();
        }
        let (axis, encoder) = (self.axis()?, self.encoder()?);
        let sample_time_s = self.machine.sampling.sample_time_s();
        let solver = self.joint()?;
        let scale = [self.machine.drive.lsb_v(), sample_time_s];
        let plant = Plant::new(solver, axis, encoder, scale, self.delay());
        let absolute_zero = self.absolute_zero();
        let plant = plant.with_motor_encoder(self.motor_encoder()?);
        Ok(plant.with_absolute_zero(absolute_zero).with_winding(self.winding()?))
    }

    /// Returns the winding of the file's motor; `None` if its resistance is not in the file, or an
    /// amplifier sets its current. Without a data sheet, `[current_sensor]` and `[limits]` have its
    /// numbers.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn winding(&self) -> Result<Option<Winding>, Error> {
        if let Some((sheet, _)) = self.sheet()? {
            let is_bridge = sheet.motor.driven_by == DrivenBy::Voltage;
            let resistance_ohm = sheet.motor.resistance_ohm.filter(|_| is_bridge);
            let back_emf_v_per_deg_per_s =
                (sheet.gear.ratio * sheet.motor.kt_nm_per_a).to_radians();
            // The joint of a sheet with an inductance has its lag.
            let inductance_h =
                if sheet.lag_s() > 0.0 { 0.0 } else { self.sensed("inductance_h").unwrap_or(0.0) };
            return Ok(resistance_ohm.map(|resistance_ohm| Winding {
                resistance_ohm,
                back_emf_v_per_deg_per_s,
                lag_s: inductance_h / resistance_ohm,
                dead_time_v: sheet.dead_time_v(self.machine.drive.number("pwm_hz").unwrap_or(0.0)),
                heat: HeatPath::of(&sheet.motor),
            }));
        }
        let back_emf = self.machine.limits.number("back_emf_v_per_deg_per_s");
        Ok(self.sensed("resistance_ohm").map(|resistance_ohm| Winding {
            resistance_ohm,
            back_emf_v_per_deg_per_s: back_emf.unwrap_or(0.0),
            lag_s: self.sensed("inductance_h").unwrap_or(0.0) / resistance_ohm,
            dead_time_v: 0.0,
            heat: None,
        }))
    }

    /// Returns whether the winding of the file's motor heats up.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn has_heat(&self) -> Result<bool, Error> {
        Ok(self.winding()?.is_some_and(|winding| winding.heat.is_some()))
    }

    /// Returns a number of `[current_sensor]`, if it is in the file.
    fn sensed(&self, key: &str) -> Option<f64> {
        self.machine.current_sensor.as_ref()?.number(key)
    }

    /// Returns the inductance of the data sheet's winding, H; `None` without one.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub(super) fn inductance_h(&self) -> Result<Option<f64>, Error> {
        let sheet = self.sheet()?;
        Ok(sheet.map(|(sheet, _)| sheet.motor.inductance_h).filter(|henry| *henry > 0.0))
    }

    /// Returns what the bridge makes of an effort.
    fn effort_mode(&self) -> EffortMode {
        self.machine.sampling.core(ControllerConfig::EXAMPLE).effort
    }

    /// Returns whether the efforts are currents, which a current loop makes.
    pub fn has_current_loop(&self) -> bool {
        self.effort_mode() == EffortMode::Current
    }

    /// Returns the current loop of this run, without a servo around it; `None` if the effort is a
    /// voltage.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn current_loop(&self) -> Result<Option<BareCurrentLoop>, Error> {
        if !self.has_current_loop() {
            return Ok(None);
        }
        let parameters = super::for_a_device(self)?;
        parameters.prepare(&STM32F405).map_err(|why| self.explain(&why))?;
        Ok(BareCurrentLoop::of(&parameters))
    }

    /// Returns the number of the PWM's periods in a sample time; `None` without a current loop.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn pwm_periods(&self) -> Result<Option<u32>, Error> {
        match self.effort_mode() {
            EffortMode::Voltage => Ok(None),
            EffortMode::Current => {
                let parameters = super::for_a_device(self)?;
                Ok(Some(parameters.periods(&STM32F405).map_err(|why| self.explain(&why))?))
            }
        }
    }

    /// Refuses a current loop where only voltages are simulated: by runs of the flash image, and by
    /// a plant that a program moves sample by sample.
    ///
    /// # Errors
    /// Returns an error that names the key.
    pub fn refuse_current_loop(&self) -> Result<(), Error> {
        match self.effort_mode() {
            EffortMode::Voltage => Ok(()),
            EffortMode::Current => Err(Error::Input(format!(
                "{}: a current loop is not simulated here; set `loop.effort` to \"voltage\", or \
                 use `stiction run`, `ensemble`, `tune` or `device --simulated`",
                self.origin.of("loop.effort")
            ))),
        }
    }

    /// Returns the supply of the bridge, if the data sheet of this run, or of its
    /// [truth](Self::truth), has its capacitor.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn dc_link(&self) -> Result<Option<DcLink>, Error> {
        if let Some(truth) = &self.truth {
            return truth.dc_link();
        }
        let supply = self.sheet()?.and_then(|(sheet, _)| sheet.supply);
        let has_capacitor = |supply: &SupplyTable| supply.capacitance_f > 0.0;
        let (Some(supply), Some(_)) = (supply.filter(has_capacitor), self.winding()?) else {
            return Ok(None);
        };
        Ok(DcLink::of(&supply, &super::assembled(self)?))
    }

    /// Returns the shunt amplifier of the motor; `None` without `[current_sensor]`.
    pub fn shunt(&self) -> Option<Shunt> {
        let table = self.machine.current_sensor.as_ref()?;
        let sensor: CurrentSensor = table.core(CurrentSensor::NONE);
        sensor.is_there().then(|| Shunt::of(&sensor))
    }

    /// Returns the temperature sensor of the motor; `None` without `[motor_ntc]`.
    pub fn ntc(&self) -> Option<Ntc> {
        Ntc::of(&self.machine.motor_ntc.as_ref()?.core(MotorNtc::NONE))
    }

    /// Returns the joint of this run, at rest: the axis of the file, the joint of its data sheet,
    /// or the joint that replaces it.
    ///
    /// # Errors
    /// Returns an error that names the invalid value, or an effect that only a run simulates.
    pub fn joint(&self) -> Result<RunJoint, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s();
        let of_the_file = match self.sheet()? {
            Some((sheet, mapping)) if self.substitute.is_none() => {
                self.has_a_plain_drive(&sheet)?;
                sheet.substitute(
                    &mapping,
                    self.machine.encoder.resolution_deg(),
                    &SheetFactors::ONE,
                )
            }
            _ => None,
        };
        let substitute = self.substitute.as_ref().or(of_the_file.as_ref());
        // The interval for which the joint is held most often.
        let interval_s = match self.pwm_periods()? {
            Some(number) => half_period_s(sample_time_s, number),
            None => sample_time_s,
        };
        Ok(RunJoint::at_rest(&self.axis()?, interval_s, substitute)?)
    }

    /// If the data sheet has more effects than an axis in closed form, returns its joint, without
    /// the effects of drive and encoder that only a run simulates. `times` scales inertia and
    /// friction.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn beyond_an_axis(&self, times: &SheetFactors) -> Result<Option<Substitute>, Error> {
        let count_deg = self.machine.encoder.resolution_deg();
        let sheet = self.sheet()?;
        Ok(sheet.and_then(|(sheet, mapping)| sheet.substitute(&mapping, count_deg, times)))
    }

    /// Returns the slack of the gear that the encoder cannot measure; `None` without a data sheet.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn unseen_slack(&self) -> Result<Option<UnseenSlack>, Error> {
        let count_deg = self.machine.count_deg();
        Ok(self.sheet()?.and_then(|(sheet, _)| UnseenSlack::of(&sheet, count_deg)))
    }

    /// Returns the torque at the joint per volt of the controller's output, N m/V; `None` without a
    /// data sheet.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn nm_per_v(&self) -> Result<Option<f64>, Error> {
        Ok(self.sheet()?.map(|(_, mapping)| mapping.units.effort_gain))
    }

    /// Returns the data sheet of this run's machine, and its mapping to the core's units.
    pub(crate) fn sheet(&self) -> Result<Option<(DataSheet, Mapping)>, Error> {
        let machine = &*self.machine;
        if machine.motor.is_some() && machine.motor_encoder.is_some() {
            let key = "motor_encoder";
            let why = SheetRefusal::of(
                key,
                format!(
                    "`[{key}]` is for a file without a data sheet; beside `[motor]`, describe the \
                     load's encoder in `[load_encoder]`, and the motor's in `[encoder]`"
                ),
            );
            return Err(Error::Input(self.origin.refusal(&why)));
        }
        let disc = &machine.encoder.extras;
        let encoder = Mount { lines: disc.lines, at: disc.at, noise_counts: disc.noise_counts };
        let tables = SheetTables {
            motor: machine.motor.clone(),
            gear: machine.gear.clone(),
            load: machine.load.clone(),
            friction: machine.friction.clone(),
            supply: machine.supply.clone(),
            encoder,
            load_encoder: machine.load_encoder,
            sampling: LoopSide { position: machine.sampling.extras.position },
        };
        let refused = |why: SheetRefusal| Error::Input(self.origin.refusal(&why));
        let Some(sheet) = tables.sheet().map_err(refused)? else { return Ok(None) };
        let drive = WrittenDrive {
            full_scale_v: Some(machine.drive.full_scale_v()),
            duty_max: machine.drive.number("duty_max"),
        };
        Ok(Mapping::of(&sheet, drive).map(|mapping| (sheet, mapping)))
    }

    /// If the data sheet has more effects than the axis in closed form, returns its joint and
    /// drive.
    ///
    /// # Errors
    /// Returns an error that names the invalid value, or a solver that has no such joint.
    pub fn sheet_axis(&self) -> Result<Option<SheetAxis>, Error> {
        if self.substitute.is_some() {
            return Ok(None);
        }
        let Some((sheet, mapping)) = self.sheet()? else { return Ok(None) };
        let drive = &self.machine.drive;
        let pwm_hz = drive.number("pwm_hz").unwrap_or_default();
        let count_deg = self.machine.encoder.resolution_deg();
        let axis = SheetAxis::of(&sheet, &mapping, [count_deg, pwm_hz])?;
        if axis.is_some() && self.machine.run.solver == AxisSolverName::Rk4 {
            let allowed = "\"exact\", since the data sheet describes more than a rigid axis";
            return Err(self.refuse("run.solver", "\"rk4\"", allowed));
        }
        Ok(axis)
    }

    /// Returns the reading of the load's encoder where the joint is at zero, counts, if it is an
    /// absolute one beside the motor's.
    pub fn absolute_zero(&self) -> Option<u32> {
        if let Some(written) = &self.machine.motor_encoder {
            let MotorEncoder { load_kind, load_zero, .. } = written.core(MotorEncoder::NONE);
            let is_absolute = load_kind == motor_encoder::LoadEncoderKind::As5047p;
            return is_absolute.then_some(load_zero);
        }
        let load = self.machine.load_encoder_in_loop()?;
        (load.kind == LoadEncoderKind::As5047p).then_some(load.zero_counts.unwrap_or(0))
    }

    /// Returns whether the loop has an encoder on the motor and one on the load.
    pub fn has_two_encoders(&self) -> bool {
        self.machine.has_two_encoders()
    }

    /// Refuses a drive or an encoder noise that only a run simulates.
    fn has_a_plain_drive(&self, sheet: &DataSheet) -> Result<(), Error> {
        let Some(key) = sheet.has_a_drive_of_its_own() else { return Ok(()) };
        Err(Error::Input(format!(
            "{}: `{key}` is simulated by `stiction run` and `benchmark` only, without a current \
             loop, a winding that heats up, and another supply; a simulated device has an ideal \
             supply, or one with a capacitor, and readings without noise",
            self.origin.of(key)
        )))
    }

    /// Returns the computation delay.
    pub(super) fn delay(&self) -> Delay {
        match self.machine.run.delay_samples {
            0 => Delay::None,
            _ => Delay::OneSample,
        }
    }
}
