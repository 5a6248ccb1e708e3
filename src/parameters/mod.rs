//! The parameters: a whole machine as the device needs it.
//!
//! The parameters' form in the flash and over the link is in [`record`]. The numbers are those of
//! the core's own configuration (`f32`, counts), so that nothing is rounded a second time on the
//! device. Host and device build the same controller from them, bit for bit.

mod former;
pub mod record;

use crate::compensator::{self, Gains};
use crate::controller::{Controller, ControllerConfig, SAMPLE_TIME};
use crate::drive::DriveConfig;
use crate::encoder::Encoder;
use crate::error::{Error, between};
use crate::hardware::Hardware;
use crate::identification::Ramp;
use crate::monitor::Limits;
use crate::motion::{self, Course, Motion};
use crate::pd::PdGains;
use crate::value::{About, Table, Values, table};
pub use record::{DecodeError, FORMAT_VERSION, ROOM};

table! {
    /// The parameters of a device: everything that it is told.
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
    }
}

table! {
    /// The configuration that only a device has. By default the device neither starts nor scales
    /// anything by itself.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DeviceConfig (device) "device" {
        /// Arm without a command, `autostart_delay_s` after power-on. No reset that nobody asked
        /// for does.
        autostart: bool = 0x0801 "autostart", Any, Default(false);
        /// Time from the first tick to arming by itself, s.
        autostart_delay: f32 = 0x0802 "autostart_delay_s", Between(0.0, 60.0), Default(1.0);
        /// Time in which the output's limit rises from zero to the full scale after arming, s; 0 is
        /// at once. The product of its ticks and the codes fits 32 bits up to 10 s at 10 kHz.
        soft_start: f32 = 0x0803 "soft_start_s", Between(0.0, 10.0), Default(0.5);
        /// Time between the switching of complementary outputs, s: up to what the STM32F405's
        /// dead-time generator reaches at 168 MHz.
        dead_time: f32 = 0x0804 "dead_time_s", Between(0.0, 6e-6), Default(1e-6);
        /// Supply for which the gains were found, V: the output is scaled by its ratio to the
        /// measured supply. 0 leaves the output alone. Up to `supply_full_scale_v`.
        nominal_supply: f32 =
            0x0805 "nominal_supply_v", Between(0.0, device.supply_full_scale), Default(0.0);
        /// Supply at the full scale of the converter, V; 0: the supply is not measured.
        supply_full_scale: f32 = 0x0806 "supply_full_scale_v", Between(0.0, 100.0), Default(0.0);
    }
}

impl DeviceConfig {
    /// The configuration of a device that neither starts nor scales anything by itself. It has half
    /// a second of soft start and one microsecond of dead time.
    pub const CAUTIOUS: Self = Self::EXAMPLE;
}

/// Returns the declarations of all tables.
pub fn tables() -> impl Iterator<Item = &'static [About]> {
    let tables = [
        ControllerConfig::ABOUT,
        Encoder::ABOUT,
        DriveConfig::ABOUT,
        PdGains::ABOUT,
        compensator::ABOUT,
        motion::ABOUT,
        DeviceConfig::ABOUT,
        Limits::ABOUT,
    ];
    tables.into_iter().chain(Gains::ABOUT.iter().copied())
}

/// Returns the declarations of all values.
pub fn about() -> impl Iterator<Item = &'static About> {
    tables().flatten()
}

impl Parameters {
    /// Validates every value, and prepares the controller and its motion.
    ///
    /// # Errors
    /// Names the first value that is not allowed.
    pub fn prepare(&self, hardware: &Hardware) -> Result<(Controller, Course), Error> {
        self.check()?;
        let mut controller = Controller::new(&self.controller, hardware)?;
        self.on_device(&mut controller, hardware);
        Ok((controller, self.motion.course(&self.controller)?))
    }

    /// Gives a controller its soft start and its nominal supply, in the units of a tick.
    pub(crate) fn on_device(&self, controller: &mut Controller, hardware: &Hardware) {
        let DeviceConfig { soft_start, nominal_supply, supply_full_scale, .. } = self.device;
        let nominal = match supply_full_scale {
            full_scale if full_scale > 0.0 => {
                nominal_supply / full_scale * f32::from(hardware.supply_top)
            }
            _ => 0.0,
        };
        controller.on_device(self.in_ticks(soft_start), nominal);
    }

    /// Returns a time (s) in whole ticks.
    pub(crate) fn in_ticks(&self, s: f32) -> u32 {
        libm::roundf(s / self.controller.sample_time) as u32
    }

    /// Refuses a value that this board's timers cannot make. A record that is valid by itself may
    /// be another board's.
    ///
    /// # Errors
    /// Names the value.
    pub fn fits(&self, hardware: &Hardware) -> Result<(), DecodeError> {
        hardware.pwm_top(self.controller.drive.pwm_hz).map(|_| ()).map_err(DecodeError::Value)
    }

    /// Refuses a value that is not within its bounds, and values that do not go together.
    ///
    /// # Errors
    /// Names the first value that is not allowed.
    #[inline(never)]
    pub fn check(&self) -> Result<(), Error> {
        // The bounds for which the tick's timer and the deadline are made: 50 Hz to 10 kHz.
        between(SAMPLE_TIME, self.controller.sample_time, 1e-4, 0.02)?;
        self.validate()?;
        self.motion.is_soft(self.device.soft_start, self.controller.drive.full_scale)?;
        self.motion.check(&self.controller)
    }

    /// Prepares a ramp for this machine that rises by `rate` (V/s) and is held for `hold` (s), as
    /// [`Motion::Ramp`] does.
    ///
    /// # Errors
    /// Names the value that is not allowed.
    pub fn ramp(&self, rate: f32, hold: f32) -> Result<Ramp, Error> {
        let ControllerConfig { sample_time, drive, .. } = &self.controller;
        Motion::Ramp { rate, hold }.is_soft(self.device.soft_start, drive.full_scale)?;
        Ramp::new(rate, hold, *sample_time, drive.full_scale)
    }
}

#[cfg(test)]
mod tests;
