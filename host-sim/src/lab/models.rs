//! From a file's tables to frictions. Every value is checked here, once.

use super::build::{AnyMechanism, Boxed};
use super::plan::LabPlan;
use super::setup::Model;
use crate::error::Error;
use crate::friction::{Coulomb, ResetIntegrator};

const ABOVE_ZERO: &str = "a number above 0";

impl LabPlan {
    /// Checks mechanism and frictions without running anything.
    pub(super) fn check_models(&self) -> Result<(), Error> {
        match self.mechanism()? {
            AnyMechanism::One(mechanism) => self.check_model(&mechanism),
            AnyMechanism::Two(mechanism) => self.check_model(&mechanism),
        }
    }

    fn check_model<const N: usize>(&self, _: &Boxed<N>) -> Result<(), Error> {
        self.only_own_units()?;
        self.levels::<N>()?;
        match self.model {
            Model::Classical | Model::Karnopp => Ok(()),
            Model::KarnoppBanded => self.bands::<N>().map(|_| ()),
            Model::ResetIntegrator => self.reset_integrators::<N>().map(|_| ()),
        }
    }

    /// F_s and F_d.
    pub(super) fn levels<const N: usize>(&self) -> Result<[Coulomb; N], Error> {
        let table = &self.setup.friction;
        let slip: [f64; N] =
            self.each("friction.slip_n", table.slip_n.as_ref(), "a number not below 0", |_, f| f >= 0.0)?;
        let names = (self.key("friction.slip_n"), "a number above 0 and not below the one in");
        let allowed = format!("{} `{}`", names.1, names.0);
        let stick: [f64; N] =
            self.each("friction.stick_n", table.stick_n.as_ref(), &allowed, |i, f| f >= slip[i] && f > 0.0)?;
        Ok(std::array::from_fn(|i| Coulomb { stick: stick[i], slip: slip[i] }))
    }

    /// D_v.
    pub(super) fn bands<const N: usize>(&self) -> Result<[f64; N], Error> {
        let table = self.own(self.setup.friction.karnopp_banded.as_ref())?;
        let key = "friction.karnopp-banded.band_m_per_s";
        self.each(key, table.band_m_per_s.as_ref(), ABOVE_ZERO, |_, band| band > 0.0)
    }

    /// p_o, and the rules of eqs. 4a-4c for what is left out.
    pub(super) fn reset_integrators<const N: usize>(&self) -> Result<[ResetIntegrator; N], Error> {
        let table = self.own(self.setup.friction.reset_integrator.as_ref())?;
        let (levels, inertias) = (self.levels::<N>()?, self.inertias::<N>()?);
        let key = |name: &str| format!("friction.reset-integrator.{name}");
        let range: [f64; N] =
            self.each(&key("range_m"), table.range_m.as_ref(), ABOVE_ZERO, |_, p| p > 0.0)?;
        let mut friction: [ResetIntegrator; N] =
            std::array::from_fn(|i| ResetIntegrator::by_rules(levels[i], range[i], inertias[i]));
        if let Some(stiffness) = &table.stiffness_n_per_m {
            let given: [f64; N] =
                self.each(&key("stiffness_n_per_m"), Some(stiffness), ABOVE_ZERO, |_, k| k > 0.0)?;
            (0..N).for_each(|i| friction[i].stiffness = given[i]);
        }
        if let Some(damping) = &table.damping_n_s_per_m {
            let allowed = "a number not below 0";
            let given: [f64; N] =
                self.each(&key("damping_n_s_per_m"), Some(damping), allowed, |_, b| b >= 0.0)?;
            (0..N).for_each(|i| friction[i].damping = given[i]);
        }
        if let Some(gradient) = &table.gradient {
            let allowed = "a number not below 0";
            let given: [f64; N] = self.each(&key("gradient"), Some(gradient), allowed, |_, a| a >= 0.0)?;
            (0..N).for_each(|i| friction[i].gradient = given[i]);
        }
        Ok(friction)
    }

    /// A level in newtons for a joint that turns, or in newton metres for a block, is a mistake.
    fn only_own_units(&self) -> Result<(), Error> {
        let turns = self.setup.mechanism.kind.turns();
        let foreign: &[&str] = if turns {
            &["_n", "_m", "_m_per_s", "_n_per_m", "_n_s_per_m"]
        } else {
            &["_nm", "_rad", "_rad_per_s", "_nm_per_rad", "_nm_s_per_rad"]
        };
        let mut keys = Vec::new();
        if let Some(tables) = self.parameters["friction"].as_object() {
            for (key, value) in tables {
                match value.as_object() {
                    Some(own) => keys.extend(own.keys().map(|inner| format!("friction.{key}.{inner}"))),
                    None => keys.push(format!("friction.{key}")),
                }
            }
        }
        let Some(key) = keys.iter().find(|key| foreign.iter().any(|unit| key.ends_with(unit))) else {
            return Ok(());
        };
        let at = self.origin.of(key);
        let what = if turns {
            "turns: its frictions are in N m and rad"
        } else {
            "moves straight: its frictions are in N and m"
        };
        Err(Error::Input(format!("{at}: `{key}` has the wrong unit, since this mechanism {what}")))
    }

    /// The model's own table.
    fn own<'a, T>(&self, table: Option<&'a T>) -> Result<&'a T, Error> {
        table.ok_or_else(|| {
            let name = super::setup::name_of(&self.model);
            let at = self.origin.of("run.friction");
            Error::Input(format!(
                "{at}: `run.friction` names `{name}`, which has no table `[friction.{name}]`"
            ))
        })
    }
}
