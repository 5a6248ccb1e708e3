//! The families of joints: what they are called, and what is asked of the joints of each.

use crate::error::{Error, suggestion};

/// A family of joints. docs/ensemble.md has the distributions as a table, `draw.rs` has them as
/// code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// One inertia with a set-valued Stribeck curve.
    Rigid,
    /// The same with a constant load that is less than the friction.
    Loaded,
    /// The same with a pendulum that is less than the friction.
    Gravity,
    /// The same with a constant load that drives the joint when the motor is off.
    Overhauling,
    /// One inertia on a bristle that breaks away after 3 to 10 counts, with a constant load.
    LuGre,
    /// Two inertias and a shaft with little backlash; the encoder sits on the motor.
    FlexibleMotor,
    /// The same with up to 20 counts of backlash.
    FlexibleBacklash,
    /// The same with little backlash; the encoder sits on the load.
    FlexibleLoad,
    /// The thesis's axis and its neighbours, at 20 ms.
    ThesisAxis,
}

impl Family {
    /// Every family, in the order of reports.
    pub const ALL: [Self; 9] = [
        Self::Rigid,
        Self::Loaded,
        Self::Gravity,
        Self::Overhauling,
        Self::LuGre,
        Self::FlexibleMotor,
        Self::FlexibleBacklash,
        Self::FlexibleLoad,
        Self::ThesisAxis,
    ];

    /// Returns the name in options and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Loaded => "loaded",
            Self::Gravity => "gravity",
            Self::Overhauling => "overhauling",
            Self::LuGre => "lugre",
            Self::FlexibleMotor => "flexible-motor",
            Self::FlexibleBacklash => "flexible-backlash",
            Self::FlexibleLoad => "flexible-load",
            Self::ThesisAxis => "thesis-axis",
        }
    }

    /// Returns the number that its draws begin with. A number that was given never means another
    /// family.
    pub const fn number(self) -> u8 {
        match self {
            Self::Rigid => 1,
            Self::Loaded => 2,
            Self::Gravity => 3,
            Self::Overhauling => 4,
            Self::LuGre => 5,
            Self::FlexibleMotor => 6,
            Self::FlexibleBacklash => 7,
            Self::FlexibleLoad => 8,
            Self::ThesisAxis => 9,
        }
    }

    /// Returns the family of a name.
    ///
    /// # Errors
    /// Names the nearest one.
    pub fn named(name: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|family| family.name() == name).ok_or_else(|| {
            let near = suggestion(name, Self::ALL.map(Self::name));
            Error::Input(format!("--plant {name}: there is no family of that name{near}"))
        })
    }

    /// Returns the unit of its angles: those of the thesis's axis are in degrees, and its efforts
    /// in volts; all others are in rad and N m.
    pub const fn units(self) -> Units {
        match self {
            Self::ThesisAxis => Units { angle: "deg", effort: "V" },
            _ => Units { angle: "rad", effort: "N m" },
        }
    }

    /// Returns how long a step is watched, s.
    pub const fn duration_s(self) -> f64 {
        match self {
            Self::ThesisAxis => 20.0,
            _ => 30.0,
        }
    }

    /// Returns the time in which a joint has to settle, s.
    pub const fn settles_within_s(self) -> f64 {
        match self {
            Self::FlexibleLoad => 10.0,
            _ => 5.0,
        }
    }

    /// Returns whether the joint has a load whose place is another than the encoder's.
    pub const fn has_unseen_load(self) -> bool {
        matches!(self, Self::FlexibleMotor | Self::FlexibleBacklash)
    }
}

/// The units of a family's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Units {
    /// Of positions.
    pub angle: &'static str,
    /// Of efforts.
    pub effort: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_are_each_family_s_own() {
        for (i, family) in Family::ALL.into_iter().enumerate() {
            assert_eq!(Family::named(family.name()).unwrap(), family);
            assert!(Family::ALL[..i].iter().all(|other| other.number() != family.number()));
        }
        let message = Family::named("flexible-moter").unwrap_err().to_string();
        assert!(message.contains("did you mean `flexible-motor`?"), "{message}");
    }
}
