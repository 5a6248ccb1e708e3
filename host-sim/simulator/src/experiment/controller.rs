//! Makes the configuration of the core from the table of a controller: its laws, with their gains.

use heapless::Vec as FixedVec;
use stiction::control::drive::DriveConfig;
use stiction::control::encoder::{CounterBits, Encoder};
use stiction::control::laws::{Gains, MAX_TERMS, RobustDualGains, RobustGains};
use stiction::control::motor_encoder::MotorEncoder;
use stiction::control::pd::PdGains;
use stiction::control::velocity::MAX_WINDOW;
use stiction::units::value::{About, Absent, Table, Values as _};
use stiction::{Controller, ControllerConfig};

use super::plan::RunPlan;
use crate::guest;
use crate::rules::ControllerGains;
use files::error::Error;
use files::hardware::STM32F405;
use files::machine::{LawName, Laws, PD};
use files::written::{AllGains, ParameterTable, laws};

impl RunPlan {
    /// Builds the control core with this run's controller; with no controller, all gains are zero.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn controller(&self) -> Result<Controller, Error> {
        let name = self.controller.as_deref().unwrap_or_default();
        let config = self.controller_config()?;
        let controller =
            Controller::new(&config, &STM32F405).map_err(|error| self.explain(&error))?;
        // Gains of other laws; those of its own laws have been checked.
        let taken = |key: &str| {
            config.compensator.iter().flat_map(about_law).any(|about| about.name == key)
        };
        for (key, _) in self.machine.controller.get(name).iter().flat_map(|table| table.iter()) {
            if taken(key) {
                continue;
            }
            if let Some(gain) =
                self.machine.controller.get(name).and_then(|table| table.number(key))
            {
                self.at_least_zero(&format!("controller.{name}.{key}"), gain)?;
            }
        }
        Ok(controller)
    }

    /// Returns the configuration of the core, the same for the host and a device.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn controller_config(&self) -> Result<ControllerConfig, Error> {
        let machine = &self.machine;
        let name = self.controller.as_deref().unwrap_or_default();
        let none = ParameterTable::default();
        let table = machine.controller.get(name).unwrap_or(&none);
        // The value can be negative, or too large for the core's type.
        let window = machine.sampling.velocity_window();
        if !(2..=MAX_WINDOW as i64).contains(&window) {
            let allowed = format!("a whole number from 2 to {MAX_WINDOW}");
            return Err(self.refuse("loop.velocity_window", &window.to_string(), &allowed));
        }
        let mut pd = PdGains { kp: 0.0, kd: 0.0 };
        table.apply(PdGains::ABOUT, &mut pd);
        let mut laws = self.laws(name, table)?;
        if let Some(guest) = self.guest()? {
            pd = guest.pd;
            laws.extend(guest.laws);
        }
        let config = ControllerConfig {
            encoder: self.position_encoder(),
            motor: self.motor_encoder_config()?,
            drive: machine.drive.core(DriveConfig::EXAMPLE),
            pd,
            compensator: laws,
            ..ControllerConfig::EXAMPLE
        };
        Ok(machine.sampling.core(config))
    }

    /// Returns the encoder that closes the position loop. Beside the motor's encoder, the one on
    /// the load has a counter of 32 bits.
    pub(super) fn position_encoder(&self) -> Encoder {
        let encoder = self.machine.encoder.core(Encoder::EXAMPLE);
        self.machine.load_encoder_in_loop().map_or(encoder, |load| Encoder {
            resolution: load.count_deg() as f32,
            counter_bits: CounterBits::ThirtyTwo,
            direction: load.direction.into(),
            output: load.output.into(),
        })
    }

    /// Returns the motor's encoder of a file that was made from the parameters of a device.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub(super) fn motor_encoder_of_a_device(&self) -> Result<Option<MotorEncoder>, Error> {
        let Some(written) = &self.machine.motor_encoder else { return Ok(None) };
        let count_deg = written.number("resolution_deg").unwrap_or_default();
        self.above_zero("motor_encoder.resolution_deg", count_deg)?;
        Ok(Some(written.core(MotorEncoder::NONE)))
    }

    /// Returns the motor's encoder of a joint that has another one on its load.
    fn motor_encoder_config(&self) -> Result<MotorEncoder, Error> {
        if let Some(of_a_device) = self.motor_encoder_of_a_device()? {
            return Ok(of_a_device);
        }
        let written = self.machine.encoder.core(Encoder::EXAMPLE);
        let of_gear = self.joint_bounds()?.motor_config();
        Ok(match of_gear.count() {
            Some(_) => {
                let load = self.machine.load_encoder_in_loop();
                MotorEncoder {
                    direction: written.direction,
                    output: written.output,
                    load_kind: load.map(|load| load.kind).unwrap_or_default().into(),
                    load_zero: load.and_then(|load| load.zero_counts).unwrap_or(0),
                    ..of_gear
                }
            }
            None => of_gear,
        })
    }

    /// Returns the gains of this run's controller if it is a law of another program, for the joint
    /// of the file. They include gains of PD, from which the thresholds of the monitors follow.
    fn guest(&self) -> Result<Option<ControllerGains>, Error> {
        let Some(name) = self.controller.as_deref() else { return Ok(None) };
        // A guest is a controller that lists no law.
        let table = self.machine.controller.get(name);
        let lists_none =
            table.and_then(|table| table.extras.laws.as_ref()).is_some_and(Vec::is_empty);
        let Some(rule) = guest::find(name).filter(|_| lists_none) else { return Ok(None) };
        Ok(Some(rule.gains(&self.joint_bounds()?)))
    }

    /// Calls a function that runs this plan. If the controller is a law of another program, the
    /// call is a case of that law.
    ///
    /// # Errors
    /// Returns the error of the function, or the first error of that law.
    pub fn as_case<T>(&self, case: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        guest::run_case(self.guest()?.as_slice(), case)
    }

    /// Returns the laws of this run's controller; empty for a ramp, and for a configuration with an
    /// error, which has been reported already.
    pub(crate) fn laws_in_use(&self) -> Vec<Gains> {
        self.controller_config()
            .map_or(vec![], |config| config.compensator.iter().copied().collect())
    }

    fn laws(
        &self,
        name: &str,
        table: &ParameterTable<AllGains, Laws>,
    ) -> Result<FixedVec<Gains, MAX_TERMS>, Error> {
        let key = format!("controller.{name}.laws");
        let origin = self.origin.of(&key);
        let laws = match &table.extras.laws {
            Some(laws) => laws.clone(),
            None if name.is_empty() => vec![],
            None => vec![LawName::find(name).ok_or_else(|| {
                let why = "a controller whose name is not that of a law must list its laws, as in \
                           [\"srnf\"]";
                Error::Input(format!("{origin}: `{key}` is missing: {why}"))
            })?],
        };
        let twice = laws.iter().enumerate().find(|(i, law)| laws[..*i].contains(law));
        if let Some((i, _)) = twice {
            return Err(Error::Input(format!("{origin}: `{key}[{i}]` repeats a law")));
        }
        if let Some((one, other, shared)) = sharing(&laws) {
            let why = format!("only one of them is allowed, since both use `{shared}`");
            return Err(Error::Input(format!("{origin}: `{key}` has {one} and {other}; {why}")));
        }
        if let Some(law) =
            laws.iter().find(|law| law.0.is_some_and(|law| law.replaces_pd()) && laws.len() > 1)
        {
            let why = "it replaces PD, and must be the only law";
            return Err(Error::Input(format!(
                "{origin}: `{key}` has {} and another law; {why}",
                law.name()
            )));
        }
        let mut gains = FixedVec::new();
        for law in laws.iter().filter_map(|law| law.0) {
            let law = self.law_of_its_encoders(name, table, law)?;
            if gains.push(self.gains(name, table, law)?).is_err() {
                let why = format!("at most {MAX_TERMS} beside {PD}");
                return Err(Error::Input(format!("{origin}: `{key}` has too many entries; {why}")));
            }
        }
        Ok(gains)
    }

    /// Returns the law for the encoders of the loop: in a file, `robust` is the name of both the
    /// law with one encoder and the law with two.
    fn law_of_its_encoders(
        &self,
        name: &str,
        table: &ParameterTable<AllGains, Laws>,
        law: Gains,
    ) -> Result<Gains, Error> {
        let Gains::Robust(_) = law else { return Ok(law) };
        let one = Gains::Robust(RobustGains::EXAMPLE);
        let two = Gains::RobustDual(RobustDualGains::EXAMPLE);
        let (used, other, why) = if self.machine.has_two_encoders() {
            (two, one, "it has no effect in a loop with two encoders")
        } else {
            (one, two, "it needs a `[load_encoder]` in the loop")
        };
        let mut given = other;
        table.apply(about_law(&other), &mut given);
        let is_used = |key: &str| about_law(&used).iter().any(|about| about.name == key);
        let stray = about_law(&other)
            .iter()
            .find(|about| !is_used(about.name) && given.get(about.key) != other.get(about.key));
        stray.map_or(Ok(used), |about| {
            let key = format!("controller.{name}.{}", about.name);
            let origin = self.origin.of(&key);
            Err(Error::Input(format!("{origin}: `{key}` must be left out: {why}")))
        })
    }

    /// Returns the law with the gains of a table. A gain without a default is required.
    fn gains(
        &self,
        name: &str,
        table: &ParameterTable<AllGains, Laws>,
        mut law: Gains,
    ) -> Result<Gains, Error> {
        let about = about_law(&law);
        let gone: Vec<String> = about
            .iter()
            .filter(|about| about.absent == Absent::Needed && table.number(about.name).is_none())
            .map(|about| format!("`controller.{name}.{}`", about.name))
            .collect();
        if !gone.is_empty() {
            let (origin, law) = (self.origin.of(&format!("controller.{name}.laws")), law.name());
            let (are, them) = if gone.len() == 1 { ("is", "it") } else { ("are", "them") };
            return Err(Error::Input(format!(
                "{origin}: {} {are} missing; the law {law} needs {them}",
                gone.join(", ")
            )));
        }
        table.apply(about, &mut law);
        Ok(law)
    }
}

/// Returns the declarations of a law's gains.
pub fn about_law(law: &Gains) -> &'static [About] {
    laws().find(|(example, _)| example.id() == law.id()).map(|(_, about)| about).unwrap_or_default()
}

/// Returns two laws of a list that use the same key of a table, and that key.
fn sharing(laws: &[LawName]) -> Option<(&'static str, &'static str, &'static str)> {
    let all: Vec<Gains> = laws.iter().filter_map(|law| law.0).collect();
    all.iter().enumerate().find_map(|(i, one)| {
        all.iter().skip(i + 1).find_map(|other| {
            let shares = |about: &&About| about_law(other).iter().any(|b| b.name == about.name);
            let shared = about_law(one).iter().find(shares)?;
            Some((one.name(), other.name(), shared.name))
        })
    })
}
