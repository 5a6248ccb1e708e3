//! The families of joints: what they are called, and what is asked of the joints of each.

use files::error::{Error, suggestion};

/// A family of joints. docs/how-to/ensembles.md has the distributions as a table, `draw.rs` has
/// them as code.
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
    /// The same with the backlash of a real gear, 0.1 to 1 deg at the joint.
    GearBacklash,
    /// The same with little backlash; the encoder sits on the load.
    FlexibleLoad,
    /// The thesis's axis and its neighbours, at 20 ms.
    ThesisAxis,
    /// A geared arm of two links, with a controller for each joint.
    Arm,
    /// The same arms without what the motion of one joint does to the other.
    ArmUncoupled,
    /// One inertia with a pendulum that drives the joint when the motor is off.
    OverhaulingGravity,
    /// One inertia on a bristle, with a constant load that drives it.
    OverhaulingLuGre,
    /// Two inertias and a shaft, encoder on the motor, with a constant load that drives the load.
    OverhaulingFlexible,
    /// A rigid joint with a wall before its target.
    EndStop,
    /// The same of a joint on a bristle.
    EndStopLuGre,
    /// The same of a flexible joint, whose load meets the wall.
    EndStopFlexible,
    /// The same of the thesis's axis.
    EndStopThesis,
    /// A rigid joint whose stick friction grows while it rests.
    Dwell,
    /// A rigid joint whose friction drifts from its begin on.
    Drifting,
    /// A rigid joint whose encoder is a count off in two readings of three, which no law knows.
    Noisy,
    /// The same joints, and `robust` knows the encoder's jitter.
    NoisyDeclared,
    /// Two inertias and a shaft with little backlash, an encoder on either side; the shaft is wound
    /// up at the begin.
    TwoEncoders,
    /// The same with up to 20 counts of backlash.
    TwoEncodersBacklash,
    /// The same with the backlash of a real gear, 0.1 to 1 deg at the joint.
    TwoEncodersGearBacklash,
    /// The same with a constant load that drives the load, and little backlash.
    TwoEncodersOverhauling,
    /// The same with encoders that are a count off in two readings of three, which `robust` knows.
    TwoEncodersNoisy,
    /// The same with a wall before the target of the load.
    TwoEncodersEndStop,
}

impl Family {
    /// The families that `all` selects, in report order.
    pub const USUAL: [Self; 10] = [
        Self::Rigid,
        Self::Loaded,
        Self::Gravity,
        Self::Overhauling,
        Self::LuGre,
        Self::FlexibleMotor,
        Self::FlexibleBacklash,
        Self::FlexibleLoad,
        Self::ThesisAxis,
        Self::Arm,
    ];

    /// Those that are run where they are named only: they ask one question each.
    pub const SPECIAL: [Self; 19] = [
        Self::GearBacklash,
        Self::ArmUncoupled,
        Self::OverhaulingGravity,
        Self::OverhaulingLuGre,
        Self::OverhaulingFlexible,
        Self::EndStop,
        Self::EndStopLuGre,
        Self::EndStopFlexible,
        Self::EndStopThesis,
        Self::Dwell,
        Self::Drifting,
        Self::Noisy,
        Self::NoisyDeclared,
        Self::TwoEncoders,
        Self::TwoEncodersBacklash,
        Self::TwoEncodersGearBacklash,
        Self::TwoEncodersOverhauling,
        Self::TwoEncodersNoisy,
        Self::TwoEncodersEndStop,
    ];

    /// Every family.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::USUAL.into_iter().chain(Self::SPECIAL)
    }

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
            Self::GearBacklash => "gear-backlash",
            Self::FlexibleLoad => "flexible-load",
            Self::ThesisAxis => "thesis-axis",
            Self::Arm => "arm",
            Self::ArmUncoupled => "arm-uncoupled",
            Self::OverhaulingGravity => "overhauling-gravity",
            Self::OverhaulingLuGre => "overhauling-lugre",
            Self::OverhaulingFlexible => "overhauling-flexible",
            Self::EndStop => "end-stop",
            Self::EndStopLuGre => "end-stop-lugre",
            Self::EndStopFlexible => "end-stop-flexible",
            Self::EndStopThesis => "end-stop-thesis",
            Self::Dwell => "dwell",
            Self::Drifting => "drifting",
            Self::Noisy => "noisy",
            Self::NoisyDeclared => "noisy-declared",
            Self::TwoEncoders => "two-encoders",
            Self::TwoEncodersBacklash => "two-encoders-backlash",
            Self::TwoEncodersGearBacklash => "two-encoders-gear-backlash",
            Self::TwoEncodersOverhauling => "two-encoders-overhauling",
            Self::TwoEncodersNoisy => "two-encoders-noisy",
            Self::TwoEncodersEndStop => "two-encoders-end-stop",
        }
    }

    /// Returns the number that its draws begin with. A number that was given never means another
    /// family. An arm is the same with its coupling and without, and a joint whatever is known of
    /// it.
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
            Self::Arm | Self::ArmUncoupled => 10,
            Self::OverhaulingGravity => 11,
            Self::OverhaulingLuGre => 12,
            Self::OverhaulingFlexible => 13,
            Self::EndStop => 14,
            Self::EndStopLuGre => 15,
            Self::EndStopFlexible => 16,
            Self::EndStopThesis => 17,
            Self::Dwell => 18,
            Self::Drifting => 19,
            Self::Noisy | Self::NoisyDeclared => 20,
            Self::GearBacklash => 21,
            Self::TwoEncoders => 22,
            Self::TwoEncodersBacklash => 23,
            Self::TwoEncodersGearBacklash => 24,
            Self::TwoEncodersOverhauling => 25,
            Self::TwoEncodersNoisy => 26,
            Self::TwoEncodersEndStop => 27,
        }
    }

    /// Returns the family of a name.
    ///
    /// # Errors
    /// Names the nearest one.
    pub fn named(name: &str) -> Result<Self, Error> {
        // The name of this family before `noisy-declared`; scripts may use it.
        let name = if name == "noisy-told" { "noisy-declared" } else { name };
        Self::all().find(|family| family.name() == name).ok_or_else(|| {
            let near = suggestion(name, Self::all().map(Self::name));
            Error::Input(format!("--plant {name}: there is no family of that name{near}"))
        })
    }

    /// Returns the unit of its angles: those of the thesis's axis are in degrees, and its efforts
    /// in volts; all others are in rad and N m.
    pub const fn units(self) -> FamilyUnits {
        match self {
            Self::ThesisAxis | Self::EndStopThesis => FamilyUnits { angle: "deg", effort: "V" },
            _ => FamilyUnits { angle: "rad", effort: "N m" },
        }
    }

    /// Returns how long a step is watched, s.
    pub const fn duration_s(self) -> f64 {
        match self {
            Self::ThesisAxis | Self::EndStopThesis => 20.0,
            _ => 30.0,
        }
    }

    /// Returns the time in which a joint has to settle, or in which its law has to give up before a
    /// wall, s.
    pub const fn settles_within_s(self) -> f64 {
        match self {
            _ if self.has_wall() => 2.0,
            _ if self.is_positioned_at_load() => 10.0,
            _ => 5.0,
        }
    }

    /// Returns whether a wall stands before the target.
    pub const fn has_wall(self) -> bool {
        matches!(
            self,
            Self::EndStop
                | Self::EndStopLuGre
                | Self::EndStopFlexible
                | Self::EndStopThesis
                | Self::TwoEncodersEndStop
        )
    }

    /// Returns whether a load drives the joint, and a brake holds it until the move begins.
    pub const fn is_overhauling(self) -> bool {
        matches!(
            self,
            Self::Overhauling
                | Self::OverhaulingGravity
                | Self::OverhaulingLuGre
                | Self::OverhaulingFlexible
                | Self::TwoEncodersOverhauling
        )
    }

    /// Returns whether the joint has an encoder on either side of its gear.
    pub const fn has_two_encoders(self) -> bool {
        matches!(
            self,
            Self::TwoEncoders
                | Self::TwoEncodersBacklash
                | Self::TwoEncodersGearBacklash
                | Self::TwoEncodersOverhauling
                | Self::TwoEncodersNoisy
                | Self::TwoEncodersEndStop
        )
    }

    /// Returns whether an encoder on the load says where the joint is.
    pub const fn is_positioned_at_load(self) -> bool {
        matches!(self, Self::FlexibleLoad) || self.has_two_encoders()
    }

    /// Returns whether the encoder is a count off in two readings of three.
    pub const fn has_noise(self) -> bool {
        matches!(self, Self::Noisy | Self::NoisyDeclared | Self::TwoEncodersNoisy)
    }

    /// Returns whether it is an arm of two joints.
    pub const fn is_arm(self) -> bool {
        matches!(self, Self::Arm | Self::ArmUncoupled)
    }

    /// Returns the error below which a joint counts as close to its target, in its unit. A settling
    /// into it is reported beside that into 2 counts.
    pub const fn near(self) -> Option<f64> {
        match self {
            // Settled means that on the thesis's axis everywhere else
            // (docs/how-to/choose-a-law.md).
            Self::ThesisAxis => Some(0.05),
            _ => None,
        }
    }

    /// Returns whether the joint has a load whose place is another than the encoder's.
    pub const fn has_unseen_load(self) -> bool {
        matches!(
            self,
            Self::FlexibleMotor
                | Self::FlexibleBacklash
                | Self::GearBacklash
                | Self::OverhaulingFlexible
                | Self::EndStopFlexible
        )
    }
}

/// The units of a family's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FamilyUnits {
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
        let all: Vec<Family> = Family::all().collect();
        for (i, family) in all.iter().copied().enumerate() {
            assert_eq!(Family::named(family.name()).unwrap(), family);
            let is_same = |other: &Family| {
                let one_noise = [Family::Noisy, Family::NoisyDeclared];
                family.is_arm() && other.is_arm()
                    || one_noise.contains(&family) && one_noise.contains(other)
            };
            let is_other = |other: &Family| other.number() != family.number();
            assert!(all[..i].iter().all(|other| is_other(other) || is_same(other)));
        }
        assert_eq!(Family::named("noisy-told").unwrap(), Family::NoisyDeclared);
        let message = Family::named("flexible-moter").unwrap_err().to_string();
        assert!(message.contains("did you mean `flexible-motor`?"), "{message}");
    }
}
