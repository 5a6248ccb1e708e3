//! Homing switch and encoder index of a run.

use stiction::control::device_config::DeviceConfig;

use super::plan::RunPlan;
use crate::home_sensors::{IndexModel, SwitchModel};
use files::error::Error;
use stiction::units::value::Table as _;

/// Longest lag of an index, us.
const LONGEST_LAG_US: f64 = 10_000.0;

impl RunPlan {
    /// Returns the index of the encoder of this run, or of its [truth](Self::truth); `None` without
    /// `device.index_counts`.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn index(&self) -> Result<Option<IndexModel>, Error> {
        let device = self.machine.device.core(DeviceConfig::EXAMPLE);
        let plant = self.truth.as_deref().unwrap_or(self);
        let lines = plant.sheet()?.and_then(|(sheet, _)| sheet.encoder.lines);
        let every = lines.map_or(i64::from(device.index_counts), |lines| 4 * i64::from(lines));
        let lag_us = plant.machine.encoder.extras.index_lag_us;
        plant.check(
            "encoder.index_lag_us",
            lag_us,
            (0.0..=LONGEST_LAG_US).contains(&lag_us),
            || format!("a number from 0 to {LONGEST_LAG_US}"),
        )?;
        let width = i64::from(device.index_width).max(1);
        let mut index = IndexModel::new(every, width);
        index.lag_s = 1e-6 * lag_us;
        Ok((device.index_counts > 0 && every > 0).then_some(index))
    }

    /// Returns the index for the edges on the wires of an emulated microcontroller, which have no
    /// lag.
    ///
    /// # Errors
    /// Returns an error that names the invalid value, or a lag.
    pub fn index_on_wires(&self) -> Result<Option<IndexModel>, Error> {
        let index = self.index()?;
        if index.is_some_and(|index| index.lag_s > 0.0) {
            return Err(Error::Input(format!(
                "{}: the lag of an index is not simulated on the emulated microcontroller; leave \
                 it out, or use `stiction device --simulated`",
                self.origin.of("encoder.index_lag_us")
            )));
        }
        Ok(index)
    }

    /// Returns this run with the edge of the homing switch at an angle, deg.
    #[must_use]
    pub fn with_home_switch(self, edge_deg: f64) -> Self {
        Self { home_switch_deg: Some(edge_deg), ..self }
    }

    /// Returns the homing switch of this run, or of its [truth](Self::truth).
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn home_switch(&self) -> Result<SwitchModel, Error> {
        let plant = self.truth.as_deref().unwrap_or(self);
        let load = plant.sheet()?.map(|(sheet, _)| sheet.load);
        let of_sheet = load.as_ref().and_then(|load| load.home_switch_deg);
        let contact = self.machine.device.core(DeviceConfig::EXAMPLE).home_switch;
        let mut switch = SwitchModel::new(contact, plant.home_switch_deg.or(of_sheet));
        if let Some(load) = load {
            switch.hysteresis_deg = load.home_switch_hysteresis_deg.unwrap_or(0.0);
            switch.bounce_s = load.home_switch_bounce_s.unwrap_or(0.0);
        }
        Ok(switch)
    }
}
