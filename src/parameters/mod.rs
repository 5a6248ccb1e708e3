//! The parameters: a whole machine as the device needs it.
//!
//! The parameters' form in the flash and over the link is in [`record`]. The numbers are those of
//! the core's own configuration (`f32`, counts), so that nothing is rounded a second time on the
//! device. Host and device build the same controller from them, bit for bit.

pub(crate) mod checksum;
pub mod names;
pub mod record;
pub mod store;

use crate::control::brake_resistor::{BrakeResistor, BrakeResistorLaw};
use crate::control::controller::{Controller, ControllerConfig, EffortMode};
use crate::control::current_loop;
use crate::control::current_sensor::CurrentSensor;
pub use crate::control::device_config::DeviceConfig;
use crate::control::drive::{Drive, DriveConfig, PwmMode, pwm_top};
use crate::control::encoder::Encoder;
#[cfg(feature = "two-encoders")]
use crate::control::encoder::RESOLUTION;
use crate::control::hardware::Hardware;
#[cfg(feature = "two-encoders")]
use crate::control::laws::RobustDualGains;
use crate::control::laws::{self, Gains};
#[cfg(feature = "two-encoders")]
use crate::control::motor_encoder::{LOAD_KIND, LoadEncoderKind, MotorEncoder};
use crate::control::motor_ntc::MotorNtc;
use crate::control::pd::PdGains;
use crate::control::profile::ProfileLimits;
use crate::identification::{self, IdentificationPlan, Ramp};
#[cfg(feature = "two-encoders")]
use crate::load_encoder::as5047p;
use crate::motion::arming_test::ArmingTest;
use crate::motion::home::{Home, HomeRequest};
use crate::motion::jog::{Jog, JogBounds, JogRequest, TELLING};
use crate::motion::winding::{WindingRequest, WindingTest};
use crate::motion::{self, Course, Motion};
use crate::safety::monitor::Limits;
use crate::units::error::{Allowed, HUGE, InvalidValue, above, between};
use crate::units::value::{About, Key, Table, Values, key, table};
pub use names::about;
pub use record::{DecodeError, FORMAT_VERSION, ROOM};

const EFFORT_MODE: Key = key(ControllerConfig::ABOUT, "effort");
const SAMPLE_TIME: Key = key(ControllerConfig::ABOUT, "sample_time");
const DEAD_TIME: Key = key(DeviceConfig::ABOUT, "dead_time");
const VELOCITY: Key = key(ProfileLimits::ABOUT, "velocity");
const OVERSPEED: Key = key(Limits::ABOUT, "overspeed");
const DUTY_MAX: Key = key(DriveConfig::ABOUT, "duty_max");
const FULL_SCALE: Key = key(CurrentSensor::ABOUT, "full_scale");
const INDUCTANCE: Key = key(CurrentSensor::ABOUT, "inductance");
const RESISTANCE_OHM: Key = key(CurrentSensor::ABOUT, "resistance");
const BANDWIDTH: Key = key(CurrentSensor::ABOUT, "bandwidth");
const BRAKE_OPEN: Key = key(DeviceConfig::ABOUT, "brake_open");
const BRAKE_CLOSE: Key = key(DeviceConfig::ABOUT, "brake_close");
const ARMING_TEST: Key = key(DeviceConfig::ABOUT, "arming_test");
const SHORT_BRAKE: Key = key(DeviceConfig::ABOUT, "short_brake");
const FROM: Key = key(BrakeResistor::ABOUT, "from");
const FULL: Key = key(BrakeResistor::ABOUT, "full");
const SUPPLY_FULL_SCALE: Key = key(DeviceConfig::ABOUT, "supply_full_scale");
const SUPPLY_MAX: Key = key(Limits::ABOUT, "supply_max");
const PEAK: Key = key(CurrentSensor::ABOUT, "peak");
const STALL: Key = key(Limits::ABOUT, "stall_effort");
const BACK_EMF: Key = key(Limits::ABOUT, "back_emf");
const MODE: Key = key(DriveConfig::ABOUT, "mode");
const PWM_HZ: Key = key(DriveConfig::ABOUT, "pwm_hz");
const INDEX: Key = key(DeviceConfig::ABOUT, "index_counts");
const INDEX_WIDTH: Key = key(DeviceConfig::ABOUT, "index_width");
const BOOTSTRAPPED: Key = key(DeviceConfig::ABOUT, "bootstrapped");

/// Fewest and most counts between two passes of an index: 64 are an encoder of 16 lines, and a
/// number of 32 bits with a fraction has all whole numbers up to 2^24.
const LEAST_INDEX: f32 = 64.0;
const MOST_INDEX: f32 = 16_777_216.0;

/// Highest frequency of a PWM whose every period has a conversion of the current, Hz. Each one
/// restarts that of the supply, which takes 156 of the converter's clocks, after 27 of its own: 8.7
/// us at 21 MHz.
const FASTEST_SENSED: f32 = 100e3;

/// Longest time constant L/R of a winding in a current loop, s: windings have 0.1 to 20 ms, and a
/// value in mH in the place of H must not become a gain.
const SLOWEST_WINDING: f32 = 0.05;

/// Time that a bootstrap capacitor takes to charge in each period, s: two time constants of 100 nF
/// and 10 ohm.
const BOOTSTRAP_S: f32 = 2e-6;

table! {
    /// Parameters of a device: its whole configuration.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Parameters (parameters) "" {}
    with {
        /// The control loop.
        controller: ControllerConfig = ControllerConfig::EXAMPLE,
        /// The motion that arming begins.
        motion: Motion = Motion::Hold,
        /// The configuration that only a device has.
        device: DeviceConfig = DeviceConfig::EXAMPLE,
        /// The thresholds of the faults.
        limits: Limits = Limits::EXAMPLE,
        /// The limits of a profiled move.
        profile: ProfileLimits = ProfileLimits::EXAMPLE,
        /// The bounds of a jog.
        jog: JogBounds = JogBounds::EXAMPLE,
        /// The sensor of the motor's current.
        current: CurrentSensor = CurrentSensor::NONE,
        /// The brake resistor of the supply.
        brake_resistor: BrakeResistor = BrakeResistor::NONE,
        /// The temperature sensor of the motor.
        motor_ntc: MotorNtc = MotorNtc::NONE,
    }
}

/// Returns the declarations of all tables.
pub fn tables() -> impl Iterator<Item = &'static [About]> {
    let tables = [
        ControllerConfig::ABOUT,
        Encoder::ABOUT,
        DriveConfig::ABOUT,
        PdGains::ABOUT,
        laws::ABOUT,
        motion::ABOUT,
        DeviceConfig::ABOUT,
        Limits::ABOUT,
        ProfileLimits::ABOUT,
        JogBounds::ABOUT,
        CurrentSensor::ABOUT,
        BrakeResistor::ABOUT,
        MotorNtc::ABOUT,
    ];
    let laws = tables.into_iter().chain(Gains::ABOUT.iter().copied());
    // A machine's file has other keys for these.
    #[cfg(feature = "two-encoders")]
    let laws = laws.chain([MotorEncoder::ABOUT, RobustDualGains::ABOUT]);
    laws
}

/// Returns the declarations of all values.
pub fn declarations() -> impl Iterator<Item = &'static About> {
    tables().flatten()
}

impl Parameters {
    /// Validates every value, and returns the prepared controller and its motion.
    ///
    /// # Errors
    /// Returns an error that names the first invalid value.
    pub fn prepare(&self, hardware: &Hardware) -> Result<(Controller, Course), InvalidValue> {
        self.check_times(hardware)?;
        self.check()?;
        let mut controller = Controller::new(&self.controller, hardware)?;
        self.on_device(&mut controller, hardware);
        Ok((controller, self.motion.course(&self.controller, &self.profile)?))
    }

    /// Sets the soft start (ticks) and the nominal supply (readings of the supply's converter) of a
    /// controller.
    pub(crate) fn on_device(&self, controller: &mut Controller, hardware: &Hardware) {
        let nominal = match self.controller.effort {
            EffortMode::Voltage => self.nominal_supply(hardware),
            // A current loop measures what the supply has caused.
            EffortMode::Current => 0.0,
        };
        controller.on_device(self.in_ticks(self.device.soft_start), nominal);
    }

    /// Returns the nominal supply in readings of its converter; zero: the supply is not measured,
    /// or has no nominal value.
    pub(crate) fn nominal_supply(&self, hardware: &Hardware) -> f32 {
        let DeviceConfig { nominal_supply, supply_full_scale, .. } = self.device;
        match supply_full_scale {
            full_scale if full_scale > 0.0 => {
                nominal_supply / full_scale * f32::from(hardware.supply_top)
            }
            _ => 0.0,
        }
    }

    /// Prepares the law of the brake resistor; none without one. The parameters must be valid.
    pub fn brake_resistor_law(&self, hardware: &Hardware) -> Option<BrakeResistorLaw> {
        let of_board = [self.device.supply_full_scale, self.controller.sample_time];
        BrakeResistorLaw::of(&self.brake_resistor, of_board, hardware)
    }

    /// Returns a time (s) in whole ticks.
    pub(crate) fn in_ticks(&self, s: f32) -> u32 {
        libm::roundf(s / self.controller.sample_time) as u32
    }

    /// Returns a number of ticks that is no shorter than a time (s). Rounding of `f32` can make it
    /// one tick more than needed, and never one less.
    pub fn ticks_at_least(&self, s: f32) -> u32 {
        libm::ceilf(s / self.controller.sample_time) as u32
    }

    /// Rejects a value that the timers of this board cannot produce. A valid record may be that of
    /// another board.
    ///
    /// # Errors
    /// Returns an error that names the value.
    pub fn fits(&self, hardware: &Hardware) -> Result<(), DecodeError> {
        let fits = self.check_times(hardware);
        let top = |()| pwm_top(hardware, self.controller.drive.pwm_hz).map(|_| ());
        fits.and_then(top).map_err(DecodeError::Value)
    }

    /// Rejects a sample time or a dead time that the timers cannot produce. With a shorter dead
    /// time, both switches of a half-bridge would conduct at once.
    ///
    /// # Errors
    /// Returns an error that names the value.
    pub(crate) fn check_times(&self, hardware: &Hardware) -> Result<(), InvalidValue> {
        let [shortest, longest] = hardware.sample_time;
        between(SAMPLE_TIME, self.controller.sample_time, shortest, longest)?;
        between(DEAD_TIME, self.device.dead_time, 0.0, hardware.dead_time_max)?;
        match self.controller.effort {
            EffortMode::Voltage => Ok(()),
            EffortMode::Current => self.periods(hardware).map(|_| ()),
        }
    }

    /// Returns the number of the PWM's periods in a sample time.
    ///
    /// # Errors
    /// Rejects a frequency of the PWM with which it is no whole number, and names the nearest one.
    pub fn periods(&self, hardware: &Hardware) -> Result<u32, InvalidValue> {
        let ControllerConfig { sample_time, drive, .. } = &self.controller;
        let clocks = libm::roundf(sample_time * hardware.pwm_clock_hz) as u32;
        let top = pwm_top(hardware, drive.pwm_hz)?;
        current_loop::periods(clocks, top).map_err(|nearest| {
            let hz = nearest as f32 * (hardware.pwm_clock_hz / clocks as f32);
            let allowed = Allowed::SetBy(hz, SAMPLE_TIME);
            InvalidValue { key: PWM_HZ, found: drive.pwm_hz, allowed }
        })
    }

    /// Rejects a value that is not within its bounds, and values that contradict each other. The
    /// limits of a board are checked in [`fits`](Self::fits).
    ///
    /// # Errors
    /// Returns an error that names the first invalid value.
    #[inline(never)]
    pub fn check(&self) -> Result<(), InvalidValue> {
        self.validate()?;
        #[cfg(feature = "two-encoders")]
        self.check_resolution()?;
        self.check_velocity()?;
        self.check_bootstrap()?;
        self.check_short_brake()?;
        self.check_arming_test()?;
        self.check_current()?;
        self.check_brake_resistor()?;
        self.check_index()?;
        self.profile.check(self.controller.sample_time, self.controller.encoder.resolution)?;
        self.motion.is_soft(self.device.soft_start, self.controller.drive.full_scale)?;
        if matches!(self.motion, Motion::Ramp { .. }) {
            self.check_brake()?;
        }
        self.jog.check(self.controller.drive.full_scale, &self.device)?;
        self.motion.check(&self.controller)
    }

    /// Rejects a resolution of the load's encoder that is not the one of its kind: positions would
    /// be in another unit than the angles of the chip.
    #[cfg(feature = "two-encoders")]
    fn check_resolution(&self) -> Result<(), InvalidValue> {
        let ControllerConfig { motor, encoder, .. } = &self.controller;
        let is_chip = motor.count().is_some() && motor.load_kind == LoadEncoderKind::As5047p;
        let allowed = Allowed::SetBy(as5047p::RESOLUTION, LOAD_KIND);
        if is_chip && !allowed.includes(encoder.resolution) {
            return Err(InvalidValue { key: RESOLUTION, found: encoder.resolution, allowed });
        }
        Ok(())
    }

    /// Rejects a velocity of the profile above the overspeed limit: every move would trip it.
    fn check_velocity(&self) -> Result<(), InvalidValue> {
        let (found, overspeed) = (self.profile.velocity, self.limits.overspeed);
        if overspeed > 0.0 && found > overspeed {
            let allowed = Allowed::UpTo(overspeed, OVERSPEED);
            return Err(InvalidValue { key: VELOCITY, found, allowed });
        }
        Ok(())
    }

    /// Rejects a duty at which a leg's high side would conduct for so long that its bootstrap
    /// capacitor does not charge.
    fn check_bootstrap(&self) -> Result<(), InvalidValue> {
        let DriveConfig { pwm_hz, mode, duty_max, .. } = self.controller.drive;
        let off = match mode {
            // A leg conducts for (1 + duty) / 2 of the period, and waits for two dead times.
            PwmMode::LockedAntiphase => 2.0 * (BOOTSTRAP_S + 2.0 * self.device.dead_time) * pwm_hz,
            PwmMode::SignMagnitude => BOOTSTRAP_S * pwm_hz,
            // The amplifier has its own bridge.
            PwmMode::Analog => 0.0,
        };
        // Three digits, rounded down: a person types it.
        let most = libm::floorf((1.0 - off).max(0.0) * 1000.0) / 1000.0;
        if self.device.bootstrapped && duty_max > most {
            let allowed = Allowed::DueTo(most, BOOTSTRAPPED);
            return Err(InvalidValue { key: DUTY_MAX, found: duty_max, allowed });
        }
        Ok(())
    }

    /// Rejects a short brake of an analog amplifier: zero volts of one that makes a current are no
    /// current, and do not brake.
    fn check_short_brake(&self) -> Result<(), InvalidValue> {
        let found = self.device.short_brake;
        if found > 0.0 && self.controller.drive.mode == PwmMode::Analog {
            return Err(InvalidValue {
                key: SHORT_BRAKE,
                found,
                allowed: Allowed::SetBy(0.0, MODE),
            });
        }
        Ok(())
    }

    /// Rejects a test at arming whose travel does not show an encoder: twice the counts that show a
    /// direction, and the largest twist of a gear between two encoders.
    fn check_arming_test(&self) -> Result<(), InvalidValue> {
        let (travel, ControllerConfig { encoder, motor, .. }) =
            (self.device.arming_test, &self.controller);
        let count = encoder.resolution.max(motor.count().unwrap_or(0.0));
        #[cfg(feature = "two-encoders")]
        let twist = motor.count().map_or(0.0, |_| motor.twist);
        #[cfg(not(feature = "two-encoders"))]
        let twist = 0.0;
        match travel {
            0.0 => Ok(()),
            _ => between(ARMING_TEST, travel, 2.0 * TELLING as f32 * count + twist, HUGE),
        }
    }

    /// Rejects an index that comes too often for its width: a deviation of the counts could not be
    /// distinguished from the other sense.
    fn check_index(&self) -> Result<(), InvalidValue> {
        let DeviceConfig { index_counts, index_width, .. } = self.device;
        if index_counts > 0 {
            between(INDEX, index_counts as f32, LEAST_INDEX, MOST_INDEX)?;
            let allowed = Allowed::Between(0.0, (index_counts / 8) as f32);
            let found = index_width as f32;
            if !allowed.includes(found) {
                return Err(InvalidValue { key: INDEX_WIDTH, found, allowed });
            }
        }
        Ok(())
    }

    /// Rejects a holding brake where a ramp is to run: nothing bounds the travel of a load that
    /// falls once the brake is open.
    fn check_brake(&self) -> Result<(), InvalidValue> {
        between(BRAKE_OPEN, self.device.brake_open, 0.0, 0.0)?;
        between(BRAKE_CLOSE, self.device.brake_close, 0.0, 0.0)
    }

    /// Rejects a brake resistor where the supply is not measured or has no monitor, one that begins
    /// within the supply's own voltage, and one that the monitor precedes.
    fn check_brake_resistor(&self) -> Result<(), InvalidValue> {
        let (BrakeResistor { from, full, .. }, device) = (self.brake_resistor, &self.device);
        if !self.brake_resistor.is_there() {
            return Ok(());
        }
        let measured = device.supply_full_scale;
        above(SUPPLY_FULL_SCALE, measured, 0.0, HUGE)?;
        // A resistor at its limits leaves the rest to the monitor.
        above(SUPPLY_MAX, self.limits.supply_max, 0.0, measured)?;
        let allowed = Allowed::UpTo(self.limits.supply_max, SUPPLY_MAX);
        if !allowed.includes(full) {
            return Err(InvalidValue { key: FULL, found: full, allowed });
        }
        above(FROM, from, device.nominal_supply, full)
    }

    /// Rejects a sensor of the motor's current where the effort is not the motor's voltage, where
    /// the back-EMF is unknown, and where the converter is too slow for a conversion of current and
    /// supply in each period of the PWM.
    fn check_current(&self) -> Result<(), InvalidValue> {
        let found = self.current.full_scale;
        if self.current.is_there() && self.controller.drive.mode == PwmMode::Analog {
            let allowed = Allowed::SetBy(0.0, MODE);
            return Err(InvalidValue { key: FULL_SCALE, found, allowed });
        }
        if self.current.is_there() {
            above(BACK_EMF, self.limits.back_emf, 0.0, HUGE)?;
            let found = self.controller.drive.pwm_hz;
            if found > FASTEST_SENSED {
                let allowed = Allowed::DueTo(FASTEST_SENSED, FULL_SCALE);
                return Err(InvalidValue { key: PWM_HZ, found, allowed });
            }
            self.check_stall()?;
        }
        match self.controller.effort {
            EffortMode::Voltage => Ok(()),
            EffortMode::Current => self.check_current_loop(),
        }
    }

    /// Rejects a stall threshold that the limit of the current keeps the effort below: a blocked
    /// joint would never be reported, and a homing would never find its stop.
    fn check_stall(&self) -> Result<(), InvalidValue> {
        let (found, most) = (self.limits.stall_effort, self.current.peak * self.current.resistance);
        if most > 0.0 && found > most {
            let allowed = Allowed::DueTo(most, PEAK);
            return Err(InvalidValue { key: STALL, found, allowed });
        }
        Ok(())
    }

    /// Rejects a current loop without a sensor or without the winding's inductance, and one that is
    /// too fast for the PWM.
    fn check_current_loop(&self) -> Result<(), InvalidValue> {
        let CurrentSensor { full_scale, resistance, inductance, bandwidth, .. } = self.current;
        above(FULL_SCALE, full_scale, 0.0, HUGE)?;
        let slowest = Allowed::DueTo(SLOWEST_WINDING * resistance, RESISTANCE_OHM);
        if !slowest.includes(inductance) {
            return Err(InvalidValue { key: INDUCTANCE, found: inductance, allowed: slowest });
        }
        let most = current_loop::FASTEST * self.controller.drive.pwm_hz;
        let allowed = Allowed::DueTo(most, PWM_HZ);
        if !allowed.includes(bandwidth) {
            return Err(InvalidValue { key: BANDWIDTH, found: bandwidth, allowed });
        }
        Ok(())
    }

    /// Prepares a ramp for this machine that rises by `rate` (V/s) and is held for `hold` (s), as
    /// [`Motion::Ramp`] does.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn ramp(&self, rate: f32, hold: f32) -> Result<Ramp, InvalidValue> {
        let ControllerConfig { sample_time, drive, .. } = &self.controller;
        Motion::Ramp { rate, hold }.is_soft(self.device.soft_start, drive.full_scale)?;
        self.check_brake()?;
        Ramp::new(rate, hold, *sample_time, drive.full_scale)
    }

    /// Prepares a jog for this machine, within its bounds and those that a client requests.
    ///
    /// # Errors
    /// Returns an error that names the value that the machine does not allow.
    pub fn jog(&self, asked: &JogRequest) -> Result<Jog, InvalidValue> {
        let ControllerConfig { sample_time, encoder, .. } = &self.controller;
        let bounds = self.jog.less(asked, encoder.resolution)?;
        let jog = Jog::new(&bounds, *sample_time, encoder.resolution);
        #[cfg(feature = "two-encoders")]
        if let Some(count) = self.controller.motor.count() {
            return Ok(jog.with_motor(&bounds, count, self.controller.motor.twist));
        }
        Ok(jog)
    }

    /// Prepares the test at arming; `None` without one.
    pub(crate) fn arming_test(&self) -> Option<ArmingTest> {
        let ControllerConfig { sample_time, encoder, motor, .. } = &self.controller;
        let travel = self.device.arming_test;
        (travel > 0.0).then(|| {
            let jog = Jog::new(&self.jog, *sample_time, encoder.resolution);
            ArmingTest::new(jog, travel, [encoder.resolution, motor.count().unwrap_or(0.0)])
        })
    }

    /// Prepares a measurement of the winding, within the bounds of a jog.
    ///
    /// # Errors
    /// Returns an error that names the value that the machine does not allow: without a current
    /// loop, no board works in each period of the PWM.
    pub fn measure_winding(
        &self,
        asked: &WindingRequest,
        hardware: &Hardware,
    ) -> Result<WindingTest, InvalidValue> {
        let ControllerConfig { drive, encoder, effort, sample_time, .. } = &self.controller;
        if *effort != EffortMode::Current {
            let found = f32::from(EffortMode::Voltage as u8);
            let needed = f32::from(EffortMode::Current as u8);
            let allowed = Allowed::Between(needed, needed);
            return Err(InvalidValue { key: EFFORT_MODE, found, allowed });
        }
        self.check_brake()?;
        let prepared = Drive::new(drive, hardware)?;
        let unit = self.current.unit(hardware.supply_top);
        let of_tick = [*sample_time, encoder.resolution, unit];
        WindingTest::new(asked, &self.jog, (prepared, drive), of_tick)
    }

    /// Prepares a homing for this machine, within the bounds that a client requests.
    ///
    /// # Errors
    /// Returns an error that names the bound that the machine does not allow.
    pub fn home(&self, asked: &HomeRequest) -> Result<Home, InvalidValue> {
        let Self { controller, limits, profile, jog, device, .. } = self;
        Home::new(asked, controller, limits, profile, jog, device)
    }

    /// Prepares an identification for this machine, within the bounds that a client requests.
    ///
    /// # Errors
    /// Returns an error that names the bound that the machine does not allow.
    pub fn identify(
        &self,
        asked: &identification::IdentificationRequest,
    ) -> Result<IdentificationPlan, InvalidValue> {
        IdentificationPlan::new(asked, &self.controller, &self.limits, &self.profile)
    }
}

#[cfg(test)]
mod tests;
