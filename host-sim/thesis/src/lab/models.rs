//! From a file's tables to frictions. Every value is checked here, once.

use super::build::AnyMechanism;
use super::plan::LabPlan;
use dynamics::friction::Coulomb;
use files::error::{Error, rounded, suggestion};
use files::setup::{FrictionModel, ModelTable, name_of};
use friction_lab::friction::{
    Dahl, ElasticCoulomb, LuGre, MaxwellSlip, ResetIntegrator, Stribeck, Tanh,
};

const ABOVE_ZERO: &str = "a number above 0";
const NOT_BELOW_ZERO: &str = "a number not below 0";

/// Elements of the generalized Maxwell-slip model.
pub(super) const ELEMENTS: usize = 4;

/// The keys that each model's table may have.
fn keys_of(model: FrictionModel) -> &'static [&'static str] {
    match model {
        FrictionModel::Classical | FrictionModel::Karnopp => &[],
        FrictionModel::KarnoppBanded => &["band"],
        FrictionModel::ResetIntegrator => &["stiffness", "damping", "gradient"],
        FrictionModel::Tanh => &["speed"],
        FrictionModel::Stribeck => &["speed", "exponent", "viscous"],
        FrictionModel::Dahl => &["stiffness"],
        FrictionModel::LuGre | FrictionModel::ElasticCoulomb => {
            &["stiffness", "damping", "speed", "exponent", "viscous"]
        }
        FrictionModel::MaxwellSlip => &["attraction", "speed", "exponent", "viscous"],
    }
}

/// How far a printed K_r or a may be from its rule, as a part of what the rule gives; by as much a
/// run's friction at rest may then be off F_s. The thesis's tables have two digits: half a unit of
/// the second is most at 1.05, where it is 1/21 (4.8 %). It is counted as a part since a file is in
/// radians where a table is in degrees, and rounding to digits does not keep through a conversion.
/// The p_o in the rule is rounded, too: among the tables' 5.7e-4 deg is so the most, by 0.05 in
/// 5.65 (0.9 %). Together 1.0476 * 1.0089 is less than 1.06. Table 11 comes closest: 1000 N m/deg,
/// where F_d / p_o is 1053 (1047, if p_o is 1e-6 rad).
const ROUNDED: f64 = 0.06;

/// A model whose parameters follow from F_s and F_d, p_o and a mass where they are left out.
type Rule<F> = fn(Coulomb, f64, f64) -> F;

impl LabPlan {
    /// Checks mechanism and frictions without running anything.
    pub(super) fn check_models(&self) -> Result<(), Error> {
        match self.mechanism()? {
            AnyMechanism::One(_) => self.check_model::<1>(),
            AnyMechanism::Two(_) => self.check_model::<2>(),
        }
    }

    fn check_model<const N: usize>(&self) -> Result<(), Error> {
        self.only_own_keys_of_model()?;
        self.levels::<N>()?;
        match self.model {
            FrictionModel::Classical | FrictionModel::Karnopp => Ok(()),
            FrictionModel::KarnoppBanded => self.bands::<N>().map(|_| ()),
            FrictionModel::ResetIntegrator => self.reset_integrators::<N>().map(|_| ()),
            FrictionModel::Tanh => self.tanhs::<N>().map(|_| ()),
            FrictionModel::Stribeck => self.stribecks::<N>().map(|_| ()),
            FrictionModel::Dahl => self.dahls::<N>().map(|_| ()),
            FrictionModel::LuGre => self.lugres::<N>().map(|_| ()),
            FrictionModel::ElasticCoulomb => self.elastic_coulombs::<N>().map(|_| ()),
            FrictionModel::MaxwellSlip => self.maxwell_slips::<N>().map(|_| ()),
        }
    }

    /// F_s and F_d.
    pub(super) fn levels<const N: usize>(&self) -> Result<[Coulomb; N], Error> {
        let table = &self.setup.friction;
        let slip: [f64; N] =
            self.each("friction.slip_n", table.slip_n.as_ref(), NOT_BELOW_ZERO, |_, f| f >= 0.0)?;
        let allowed =
            format!("a number above 0 and not below the one in `{}`", self.key("friction.slip_n"));
        let stick: [f64; N] =
            self.each("friction.stick_n", table.stick_n.as_ref(), &allowed, |i, f| {
                f >= slip[i] && f > 0.0
            })?;
        Ok(std::array::from_fn(|i| Coulomb { stick: stick[i], slip: slip[i] }))
    }

    /// D_v.
    pub(super) fn bands<const N: usize>(&self) -> Result<[f64; N], Error> {
        let key = "friction.karnopp-banded.band_m_per_s";
        self.each(key, self.own().band_m_per_s.as_ref(), ABOVE_ZERO, |_, band| band > 0.0)
    }

    pub(super) fn reset_integrators<const N: usize>(&self) -> Result<[ResetIntegrator; N], Error> {
        let mut friction = self.by_rules(ResetIntegrator::by_rules)?;
        let table = self.own();
        self.set_spring(&mut friction, NOT_BELOW_ZERO, |f| (&mut f.stiffness, &mut f.damping))?;
        self.set(&mut friction, "gradient", &table.gradient, NOT_BELOW_ZERO, |f, a| {
            f.gradient = a
        })?;
        self.agree_with_the_levels(&friction)?;
        Ok(friction)
    }

    /// K_r p_o has to be F_d and K_r (1 + a) p_o to be F_s, or the run would have another friction
    /// than the file says. beta is free: eq. 4c is a guideline, and two of the thesis's tables
    /// depart from it.
    fn agree_with_the_levels<const N: usize>(
        &self,
        friction: &[ResetIntegrator; N],
    ) -> Result<(), Error> {
        let rules = self.by_rules::<N, _>(ResetIntegrator::by_rules)?;
        let [stick, slip, range] =
            ["stick_n", "slip_n", "range_m"].map(|key| self.key(&format!("friction.{key}")));
        for (i, (own, rule)) in friction.iter().zip(&rules).enumerate() {
            for (key, value, wanted, rule) in [
                (
                    "stiffness_n_per_m",
                    own.stiffness,
                    rule.stiffness,
                    format!("F_d / p_o of `{slip}` and `{range}`"),
                ),
                (
                    "gradient",
                    own.gradient,
                    rule.gradient,
                    format!("(F_s - F_d) / F_d of `{stick}` and `{slip}`"),
                ),
            ] {
                let key = format!("{}[{i}]", self.key(&format!("friction.reset-integrator.{key}")));
                self.check(&key, value, (value - wanted).abs() <= ROUNDED * wanted, || {
                    let percent = 100.0 * ROUNDED;
                    format!(
                        "{} give or take {percent} %, which is {rule}, or to leave it out",
                        rounded(wanted)
                    )
                })?;
            }
        }
        Ok(())
    }

    pub(super) fn tanhs<const N: usize>(&self) -> Result<[Tanh; N], Error> {
        let mut friction = self.by_rules(Tanh::by_rules)?;
        self.set(&mut friction, "speed_m_per_s", &self.own().speed_m_per_s, ABOVE_ZERO, |f, v| {
            f.speed = v
        })?;
        Ok(friction)
    }

    pub(super) fn stribecks<const N: usize>(&self) -> Result<[Stribeck; N], Error> {
        let mut friction = self.by_rules(Stribeck::by_rules)?;
        self.set_sliding(&mut friction, |f| f)?;
        Ok(friction)
    }

    pub(super) fn dahls<const N: usize>(&self) -> Result<[Dahl; N], Error> {
        let mut friction = self.by_rules(Dahl::by_rules)?;
        let stiffness = &self.own().stiffness_n_per_m;
        self.set(&mut friction, "stiffness_n_per_m", stiffness, ABOVE_ZERO, |f, k| {
            f.stiffness = k
        })?;
        Ok(friction)
    }

    pub(super) fn lugres<const N: usize>(&self) -> Result<[LuGre; N], Error> {
        let mut friction = self.by_rules(LuGre::by_rules)?;
        self.set_spring(&mut friction, NOT_BELOW_ZERO, |f| (&mut f.stiffness, &mut f.damping))?;
        self.set_sliding(&mut friction, |f| &mut f.sliding)?;
        Ok(friction)
    }

    pub(super) fn elastic_coulombs<const N: usize>(&self) -> Result<[ElasticCoulomb; N], Error> {
        let mut friction = self.by_rules(ElasticCoulomb::by_rules)?;
        self.set_spring(&mut friction, ABOVE_ZERO, |f| (&mut f.stiffness, &mut f.damping))?;
        self.set_sliding(&mut friction, |f| &mut f.sliding)?;
        Ok(friction)
    }

    pub(super) fn maxwell_slips<const N: usize>(
        &self,
    ) -> Result<[MaxwellSlip<ELEMENTS>; N], Error> {
        let mut friction = self.by_rules(MaxwellSlip::<ELEMENTS>::by_rules)?;
        let attraction = &self.own().attraction_n_per_s;
        self.set(&mut friction, "attraction_n_per_s", attraction, ABOVE_ZERO, |f, c| {
            f.attraction = c
        })?;
        self.set_sliding(&mut friction, |f| &mut f.sliding)?;
        Ok(friction)
    }

    /// Stiffness and damping.
    fn set_spring<const N: usize, F>(
        &self,
        friction: &mut [F; N],
        allowed_damping: &str,
        parts: impl Fn(&mut F) -> (&mut f64, &mut f64),
    ) -> Result<(), Error> {
        let ModelTable { stiffness_n_per_m, damping_n_s_per_m, .. } = self.own();
        self.set(friction, "stiffness_n_per_m", &stiffness_n_per_m, ABOVE_ZERO, |f, k| {
            *parts(f).0 = k
        })?;
        self.set(friction, "damping_n_s_per_m", &damping_n_s_per_m, allowed_damping, |f, b| {
            *parts(f).1 = b
        })
    }

    /// Stribeck's curve.
    fn set_sliding<const N: usize, F>(
        &self,
        friction: &mut [F; N],
        sliding: impl Fn(&mut F) -> &mut Stribeck,
    ) -> Result<(), Error> {
        let table = self.own();
        self.set(friction, "speed_m_per_s", &table.speed_m_per_s, ABOVE_ZERO, |f, v| {
            sliding(f).speed = v
        })?;
        self.set(friction, "exponent", &table.exponent, ABOVE_ZERO, |f, d| {
            sliding(f).exponent = d
        })?;
        let viscous = &table.viscous_n_s_per_m;
        self.set(friction, "viscous_n_s_per_m", viscous, NOT_BELOW_ZERO, |f, b| {
            sliding(f).viscous = b
        })
    }

    /// Each body's friction from the rules of its model.
    fn by_rules<const N: usize, F>(&self, rule: Rule<F>) -> Result<[F; N], Error> {
        let (levels, inertias) = (self.levels::<N>()?, self.inertias::<N>()?);
        let allowed = "a number above 0 (how far friction gives way before it slides)";
        let range: [f64; N] = self.each(
            "friction.range_m",
            self.setup.friction.range_m.as_ref(),
            allowed,
            |_, p| p > 0.0,
        )?;
        for (i, levels) in levels.iter().enumerate() {
            // The rules divide by F_d.
            let key = format!("{}[{i}]", self.key("friction.slip_n"));
            self.check(&key, levels.slip, levels.slip > 0.0, || ABOVE_ZERO.into())?;
        }
        Ok(std::array::from_fn(|i| rule(levels[i], range[i], inertias[i])))
    }

    /// Puts what a table has in place of the rule.
    fn set<const N: usize, F>(
        &self,
        friction: &mut [F; N],
        key: &str,
        values: &Option<Vec<f64>>,
        allowed: &str,
        put: impl Fn(&mut F, f64),
    ) -> Result<(), Error> {
        if values.is_some() {
            let key = format!("friction.{}.{key}", name_of(&self.model));
            let least = if allowed == ABOVE_ZERO { f64::MIN_POSITIVE } else { 0.0 };
            let values: [f64; N] =
                self.each(&key, values.as_ref(), allowed, |_, value| value >= least)?;
            friction.iter_mut().zip(values).for_each(|(friction, value)| put(friction, value));
        }
        Ok(())
    }

    /// The model's own table, empty if the file has none.
    fn own(&self) -> ModelTable {
        let all = &self.setup.friction;
        let own = match self.model {
            FrictionModel::Classical | FrictionModel::Karnopp => &None,
            FrictionModel::KarnoppBanded => &all.karnopp_banded,
            FrictionModel::ResetIntegrator => &all.reset_integrator,
            FrictionModel::Tanh => &all.tanh,
            FrictionModel::Stribeck => &all.stribeck,
            FrictionModel::Dahl => &all.dahl,
            FrictionModel::LuGre => &all.lugre,
            FrictionModel::ElasticCoulomb => &all.elastic_coulomb,
            FrictionModel::MaxwellSlip => &all.maxwell_slip,
        };
        own.clone().unwrap_or_default()
    }

    /// A key that the model has no use for is a mistake, and so is one whose unit is that of
    /// another kind of mechanism.
    fn only_own_keys_of_model(&self) -> Result<(), Error> {
        let turns = self.setup.mechanism.kind.turns();
        let own = name_of(&self.model);
        let Some(tables) = self.parameters["friction"].as_object() else { return Ok(()) };
        for (key, value) in tables {
            let inner = value.as_object().into_iter().flat_map(|own| own.keys());
            for inner in inner {
                let known = keys_of(self.model);
                if !known.iter().any(|known| inner.split('_').next() == Some(known)) {
                    let key = format!("friction.{key}.{inner}");
                    let (at, near) =
                        (self.origin.of(&key), suggestion(inner, known.iter().copied()));
                    return Err(Error::Input(format!(
                        "{at}: `{key}` has no meaning for \
                        `{own}`{near}"
                    )));
                }
                self.check_unit(&format!("friction.{key}.{inner}"), turns)?;
            }
            if !value.is_object() {
                self.check_unit(&format!("friction.{key}"), turns)?;
            }
        }
        Ok(())
    }

    fn check_unit(&self, key: &str, turns: bool) -> Result<(), Error> {
        let turned = key.ends_with("_nm") || key.contains("_nm_") || key.contains("_rad");
        let has_unit = !["gradient", "exponent"].iter().any(|plain| key.ends_with(plain));
        if !has_unit || turned == turns {
            return Ok(());
        }
        let at = self.origin.of(key);
        let what = if turns {
            "turns: its frictions are in N m and rad"
        } else {
            "moves straight: its frictions are in N and m"
        };
        Err(Error::Input(format!("{at}: `{key}` has the wrong unit, since this mechanism {what}")))
    }
}
