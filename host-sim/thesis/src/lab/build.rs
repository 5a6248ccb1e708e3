//! Builds a mechanism from the tables of a file. Every value is checked here, once.

use super::plan::LabPlan;
use dynamics::mechanism::{GRAVITY, Mechanism, TwoLinkArm};
use files::error::Error;
use files::setup::MechanismKind;
use friction_lab::mechanism::{
    CoupledBlocks, DrivenBlock, IndependentBlocks, Pendulum, Pull, SpringMass, TwoBlocks, Wave,
};

/// A boxed mechanism with `N` coordinates.
pub type BoxedMechanism<const N: usize> = Box<dyn Mechanism<N> + Send + Sync>;

/// A mechanism of any kind.
pub enum AnyMechanism {
    /// One coordinate.
    One(BoxedMechanism<1>),
    /// Two coordinates.
    Two(BoxedMechanism<2>),
}

impl LabPlan {
    /// The mechanism.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn mechanism(&self) -> Result<AnyMechanism, Error> {
        self.only_own_keys()?;
        let kind = self.setup.mechanism.kind;
        Ok(match kind {
            MechanismKind::Block => {
                let [mass] = self.masses()?;
                AnyMechanism::One(Box::new(DrivenBlock { mass, push: self.push()? }))
            }
            MechanismKind::SpringMass => {
                let ([mass], [stiffness]) = (self.masses()?, self.stiffnesses()?);
                AnyMechanism::One(Box::new(SpringMass { mass, stiffness, pull: self.pull()? }))
            }
            MechanismKind::CoupledBlocks => {
                AnyMechanism::Two(Box::new(CoupledBlocks(self.two_blocks()?)))
            }
            MechanismKind::IndependentBlocks => {
                AnyMechanism::Two(Box::new(IndependentBlocks(self.two_blocks()?)))
            }
            MechanismKind::Pendulum => {
                let ([mass], [length]) = (self.masses()?, self.lengths()?);
                let ([torque], [start]) = (self.torques()?, self.starts()?);
                AnyMechanism::One(Box::new(Pendulum { mass, length, torque, start }))
            }
            MechanismKind::TwoLinkArm => AnyMechanism::Two(Box::new(TwoLinkArm {
                mass: self.masses()?,
                length: self.lengths()?,
                torque: self.torques()?,
                start: self.starts()?,
            })),
        })
    }

    /// The shortest time in which the mechanism does anything of its own, s.
    pub(super) fn time_scale_s(&self) -> Result<f64, Error> {
        let table = &self.setup.mechanism;
        self.mechanism()?;
        let each = |values: &Option<Vec<f64>>| values.clone().unwrap_or_default();
        let springs = each(&table.stiffness_n_per_m)
            .into_iter()
            .zip(&table.mass_kg)
            .map(|(k, m)| (m / k).sqrt());
        let links = each(&table.length_m).into_iter().map(|l| (l / GRAVITY).sqrt());
        let waves = table.push.iter().map(|push| push.period_s / 4.0);
        let drives = table.pull.iter().filter_map(|pull| pull.frequency_rad_per_s).map(f64::recip);
        Ok(springs.chain(links).chain(waves).chain(drives).fold(f64::INFINITY, f64::min))
    }

    /// A quarter of the wave's period, s; infinite without a wave.
    pub(super) fn wave_quarter_s(&self) -> f64 {
        self.setup.mechanism.push.as_ref().map_or(f64::INFINITY, |push| push.period_s / 4.0)
    }

    fn masses<const N: usize>(&self) -> Result<[f64; N], Error> {
        let masses = Some(&self.setup.mechanism.mass_kg);
        self.each("mechanism.mass_kg", masses, "a number above 0", |_, m| m > 0.0)
    }

    /// What a body resists a force with, for rules that want a mass: m, or m l^2.
    pub(super) fn inertias<const N: usize>(&self) -> Result<[f64; N], Error> {
        let masses = self.masses()?;
        if !self.setup.mechanism.kind.turns() {
            return Ok(masses);
        }
        let lengths: [f64; N] = self.lengths()?;
        Ok(std::array::from_fn(|i| masses[i] * lengths[i] * lengths[i]))
    }

    fn stiffnesses<const N: usize>(&self) -> Result<[f64; N], Error> {
        let stiffness = self.setup.mechanism.stiffness_n_per_m.as_ref();
        self.each("mechanism.stiffness_n_per_m", stiffness, "a number above 0", |_, k| k > 0.0)
    }

    fn lengths<const N: usize>(&self) -> Result<[f64; N], Error> {
        let lengths = self.setup.mechanism.length_m.as_ref();
        self.each("mechanism.length_m", lengths, "a number above 0", |_, l| l > 0.0)
    }

    fn torques<const N: usize>(&self) -> Result<[f64; N], Error> {
        self.each(
            "mechanism.torque_nm",
            self.setup.mechanism.torque_nm.as_ref(),
            "a finite number",
            |_, _| true,
        )
    }

    fn starts<const N: usize>(&self) -> Result<[f64; N], Error> {
        match self.setup.mechanism.start_rad.as_ref() {
            None => Ok([0.0; N]),
            start => self.each("mechanism.start_rad", start, "a finite number", |_, _| true),
        }
    }

    fn two_blocks(&self) -> Result<TwoBlocks, Error> {
        Ok(TwoBlocks { mass: self.masses()?, stiffness: self.stiffnesses()?, pull: self.pull()? })
    }

    fn pull(&self) -> Result<Pull, Error> {
        let Some(pull) = &self.setup.mechanism.pull else {
            return Err(self.missing_table("mechanism.pull"));
        };
        let finite = || "a finite number".into();
        self.check("mechanism.pull.speed_m_per_s", pull.speed_m_per_s, true, finite)?;
        if let Some(until_s) = pull.until_s {
            self.above_zero("mechanism.pull.until_s", until_s)?;
        }
        match pull.frequency_rad_per_s {
            None => {
                let until_s = pull.until_s.unwrap_or(f64::INFINITY);
                Ok(Pull::Ramp { speed: pull.speed_m_per_s, until_s })
            }
            Some(frequency) => {
                self.above_zero("mechanism.pull.frequency_rad_per_s", frequency)?;
                match pull.until_s {
                    None => Ok(Pull::Cosine { speed: pull.speed_m_per_s, frequency }),
                    Some(until_s) => Err(self.refuse(
                        "mechanism.pull.until_s",
                        &until_s.to_string(),
                        "to leave it out where `frequency_rad_per_s` is given",
                    )),
                }
            }
        }
    }

    fn push(&self) -> Result<Wave, Error> {
        let Some(push) = &self.setup.mechanism.push else {
            return Err(self.missing_table("mechanism.push"));
        };
        self.check("mechanism.push.amplitude_n", push.amplitude_n, true, || {
            "a finite number".into()
        })?;
        self.above_zero("mechanism.push.period_s", push.period_s)?;
        Ok(Wave { shape: push.shape.into(), amplitude: push.amplitude_n, period_s: push.period_s })
    }

    fn missing_table(&self, key: &str) -> Error {
        Error::Input(format!("{}: the table `[{key}]` is missing", self.origin.of(key)))
    }

    /// A key that the mechanism has no use for is a mistake.
    fn only_own_keys(&self) -> Result<(), Error> {
        let table = &self.setup.mechanism;
        let kind = table.kind;
        let (block, turns) = (kind == MechanismKind::Block, kind.turns());
        let springs = !block && !turns;
        let given = [
            ("stiffness_n_per_m", table.stiffness_n_per_m.is_some(), springs),
            ("pull", table.pull.is_some(), springs),
            ("push", table.push.is_some(), block),
            ("length_m", table.length_m.is_some(), turns),
            ("torque_nm", table.torque_nm.is_some(), turns),
            ("start_rad", table.start_rad.is_some(), turns),
        ];
        match given.iter().find(|(_, given, wanted)| *given && !wanted) {
            Some((key, ..)) => {
                let (key, kind) = (format!("mechanism.{key}"), files::setup::name_of(&kind));
                let at = self.origin.of(&key);
                Err(Error::Input(format!(
                    "{at}: `{key}` has no meaning for a mechanism of the kind `{kind}`"
                )))
            }
            None => Ok(()),
        }
    }
}
