//! Homing switch and encoder index of a run.

use stiction::control::device_config::DeviceConfig;

use super::plan::RunPlan;
use crate::home_sensors::{IndexModel, SwitchModel};
use files::error::Error;
use stiction::units::value::Table as _;

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
        Ok((device.index_counts > 0 && every > 0).then(|| IndexModel {
            every,
            first: every / 4,
            width: i64::from(device.index_width).max(1),
        }))
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
