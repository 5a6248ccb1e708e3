//! The families of joints: their names, their units, and the requirements on their joints.

use files::error::{Error, suggestion};

/// A family of joints. docs/how-to/ensembles.md has the distributions as a table, `draw.rs` has
/// them as code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// One inertia with a set-valued Stribeck curve.
    Rigid,
    /// A rigid joint with a constant load that is less than the friction.
    Loaded,
    /// A rigid joint with a pendulum that is less than the friction.
    Gravity,
    /// A rigid joint with a constant load of 0.5 to 3 times the friction at rest. A load above it
    /// drives the joint when the motor is off.
    Overhauling,
    /// One inertia on a bristle that breaks away after 3 to 10 counts, with a constant load.
    LuGre,
    /// Two inertias and a shaft with little backlash; the encoder sits on the motor.
    FlexibleMotor,
    /// `FlexibleMotor` with up to 20 counts of backlash.
    FlexibleBacklash,
    /// `FlexibleMotor` with the backlash of a real gear, 0.1 to 1 deg at the joint.
    GearBacklash,
    /// Two inertias and a shaft with little backlash; the encoder sits on the load.
    FlexibleLoad,
    /// The thesis's axis and its neighbours, at 20 ms.
    ThesisAxis,
    /// A geared arm of two links, with a controller for each joint.
    Arm,
    /// The arms of `Arm` without the effect of one joint's motion on the other joint.
    ArmUncoupled,
    /// One inertia with a pendulum that drives the joint when the motor is off.
    OverhaulingGravity,
    /// One inertia on a bristle, with a constant load that drives it.
    OverhaulingLuGre,
    /// Two inertias and a shaft, encoder on the motor, with a constant torque that drives the load.
    OverhaulingFlexible,
    /// A rigid joint with a wall before its target.
    EndStop,
    /// A joint on a bristle with a wall before its target.
    EndStopLuGre,
    /// A flexible joint whose load meets a wall before its target.
    EndStopFlexible,
    /// The thesis's axis with a wall before its target.
    EndStopThesis,
    /// A rigid joint whose stick friction grows while it rests.
    Dwell,
    /// A rigid joint whose friction drifts from the start on.
    Drifting,
    /// A rigid joint whose encoder is a count off in two readings of three. No law is configured
    /// for this noise.
    Noisy,
    /// The joints of `Noisy`; `robust` is configured with the encoder's jitter.
    NoisyDeclared,
    /// Two inertias and a shaft with little backlash, an encoder on either side; the shaft is wound
    /// up at the start.
    TwoEncoders,
    /// `TwoEncoders` with up to 20 counts of backlash.
    TwoEncodersBacklash,
    /// `TwoEncoders` with the backlash of a real gear, 0.1 to 1 deg at the joint.
    TwoEncodersGearBacklash,
    /// `TwoEncoders` with 1 deg of backlash.
    TwoEncodersWideBacklash,
    /// `TwoEncoders` with a gear of 2 to 5 Hz.
    TwoEncodersSoft,
    /// `TwoEncoders` with a constant torque that drives the load.
    TwoEncodersOverhauling,
    /// `TwoEncoders` whose encoders are a count off in two readings of three; `robust` is
    /// configured with this jitter.
    TwoEncodersNoisy,
    /// `TwoEncoders` with a wall before the target of the load.
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

    /// Families that run only if they are named: each of them answers one question.
    pub const SPECIAL: [Self; 21] = [
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
        Self::TwoEncodersWideBacklash,
        Self::TwoEncodersSoft,
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
            Self::TwoEncodersWideBacklash => "two-encoders-wide-backlash",
            Self::TwoEncodersSoft => "two-encoders-soft",
            Self::TwoEncodersOverhauling => "two-encoders-overhauling",
            Self::TwoEncodersNoisy => "two-encoders-noisy",
            Self::TwoEncodersEndStop => "two-encoders-end-stop",
        }
    }

    /// Returns the number of the family, which is part of the key of its draws. A number is never
    /// used again for another family. Families with the same number have the same joints: arms with
    /// and without coupling, and noise that is declared or not.
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
            Self::TwoEncodersWideBacklash => 28,
            Self::TwoEncodersSoft => 29,
        }
    }

    /// Returns the family of a name.
    ///
    /// # Errors
    /// Returns an error that names the nearest family.
    pub fn named(name: &str) -> Result<Self, Error> {
        // The name of this family before `noisy-declared`; scripts may use it.
        let name = if name == "noisy-told" { "noisy-declared" } else { name };
        Self::all().find(|family| family.name() == name).ok_or_else(|| {
            let near = suggestion(name, Self::all().map(Self::name));
            Error::Input(format!("--plant {name}: there is no family of that name{near}"))
        })
    }

    /// Returns the units of the joints: deg and V for the thesis's axis, rad and N m for all
    /// others.
    pub const fn units(self) -> FamilyUnits {
        match self {
            Self::ThesisAxis | Self::EndStopThesis => FamilyUnits { angle: "deg", effort: "V" },
            _ => FamilyUnits { angle: "rad", effort: "N m" },
        }
    }

    /// Returns the simulated time of a step, s.
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
                | Self::TwoEncodersWideBacklash
                | Self::TwoEncodersSoft
                | Self::TwoEncodersOverhauling
                | Self::TwoEncodersNoisy
                | Self::TwoEncodersEndStop
        )
    }

    /// Returns whether the joint is positioned by an encoder on the load.
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

    /// Returns the error below which a joint counts as close to its target, in the family's unit.
    /// Settling within it is reported beside settling within 2 counts.
    pub const fn near(self) -> Option<f64> {
        match self {
            // Everywhere else, a settled joint of the thesis's axis is one within this error
            // (docs/how-to/choose-a-law.md).
            Self::ThesisAxis => Some(0.05),
            _ => None,
        }
    }

    /// Returns whether the load is behind a shaft and the only encoder is on the motor.
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
    /// Unit of positions.
    pub angle: &'static str,
    /// Unit of efforts.
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
