//! A data sheet's joint in SI, behind the interface of the robot's axis in degrees and volts.
//!
//! ```text
//! output V -> Drive -> effort V -> InCoreUnits (x G) -> Joint in SI -> load; encoder with noise
//! ```
//!
//! Guarantees: a rigid joint without a Stribeck velocity equals the axis that [`super::units`] maps
//! to; a test compares the two. Limits: this joint is slower than the closed form of the axis, so a
//! run uses it only if the data sheet has an effect that the closed form lacks.

use crate::error::Error;
use dynamics::friction::{AddedFriction, Coulomb};
use dynamics::joint::{
    self, AnyJoint, Body, Bristle, CountNoise, Description, Gravity, InCoreUnits, Joint,
    LoadTorque, Ripple, SetValuedFriction, ShaftDescription, Stops, StribeckCurve, Substitute,
    Train,
};
use dynamics::mechanism::RobotAxis;
use dynamics::solver::{AxisSolver, Event};

use super::drive::DriveModel;
use super::sheet::DataSheet;
use super::tables::{DrivenBy, EncoderPlace};
use super::units::Mapping;

/// Default share of the motor in the friction of an elastic joint: most of the friction of a geared
/// joint is in the motor's bearings and the gear's input.
pub(super) const MOTOR_SHARE: f64 = 0.7;

/// The joint of a data sheet, as an axis in degrees and volts.
#[derive(Clone, Debug)]
pub struct SheetAxis {
    /// Joint in the core's units. Its position is that of the encoder's side of the gear.
    seen: InCoreUnits<AnyJoint>,
    drive: DriveModel,
    /// Noise of the encoder that closes the position loop.
    noise: EncoderNoise,
    /// Noise of the motor's encoder, if the load's encoder closes the position loop.
    motor_noise: EncoderNoise,
}

/// Noise of the readings of an encoder.
#[derive(Clone, Debug)]
struct EncoderNoise {
    /// Generator; `None` without noise.
    generator: Option<CountNoise>,
    /// Noise of the present reading, deg.
    present_deg: f64,
    count_deg: f64,
}

impl EncoderNoise {
    /// Creates the noise of an encoder. Encoders with different `number` have different noise. The
    /// noise is the same in each run, so that a run can be repeated.
    fn new(noise_counts: u32, number: u64, count_deg: f64) -> Self {
        let generator = (noise_counts > 0).then(|| CountNoise::new(number));
        Self { generator, present_deg: 0.0, count_deg }
    }

    /// Draws the noise of the next reading.
    fn advance(&mut self) {
        if let Some(generator) = &mut self.generator {
            self.present_deg = generator.next() as f64 * self.count_deg;
        }
    }
}

impl SheetAxis {
    /// Creates the joint of a data sheet, at rest at zero; `None` if a rigid axis in closed form
    /// describes it. `count_deg` is the angle of a count of `[encoder]`, deg; `pwm_hz` is the
    /// frequency of the PWM, Hz.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn of(
        sheet: &DataSheet,
        mapping: &Mapping,
        [count_deg, pwm_hz]: [f64; 2],
    ) -> Result<Option<Self>, Error> {
        if !sheet.is_more_than_an_axis() {
            return Ok(None);
        }
        Self::always(sheet, mapping, [count_deg, pwm_hz]).map(Some)
    }

    /// Creates the joint of any data sheet, at rest at zero.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn always(
        sheet: &DataSheet,
        mapping: &Mapping,
        [count_deg, pwm_hz]: [f64; 2],
    ) -> Result<Self, Error> {
        let joint =
            sheet.description(mapping, count_deg.to_radians(), &SheetFactors::ONE).build()?;
        // The axis of the plant: friction above its slip level counts as a brake.
        let axis = RobotAxis {
            gain: mapping.gain(),
            viscous: mapping.viscous_v(),
            friction: Coulomb {
                stick: mapping.volts(sheet.stick()[0]),
                slip: mapping.volts(sheet.slip()[0]),
            },
            added: AddedFriction::default(),
        };
        let of_sheet = |number| EncoderNoise::new(sheet.encoder.noise_counts, number, count_deg);
        let [noise, motor_noise] = match sheet.load_encoder_in_loop() {
            Some(load) => [EncoderNoise::new(load.noise_counts, 1, load.count_deg()), of_sheet(2)],
            None => [of_sheet(1), EncoderNoise::new(0, 2, count_deg)],
        };
        Ok(Self {
            seen: InCoreUnits::new(joint, mapping.units, sheet.side(), &axis),
            drive: DriveModel::of(sheet, pwm_hz),
            noise,
            motor_noise,
        })
    }
}

impl AxisSolver for SheetAxis {
    fn advance(&mut self, v: f64, duration_s: f64, friction: &Coulomb, on: &mut impl FnMut(Event)) {
        let effort_v = self.drive.effort(v, self.seen.joint.motor().velocity);
        self.seen.advance(effort_v, duration_s, friction, on);
        self.noise.advance();
        self.motor_noise.advance();
    }

    fn position(&self) -> f64 {
        self.seen.joint.load().position.to_degrees()
    }

    fn measured(&self) -> f64 {
        self.seen.position() + self.noise.present_deg
    }

    fn measured_at_motor(&self) -> f64 {
        self.seen.measured_at_motor() + self.motor_noise.present_deg
    }

    fn at_encoder(&self) -> f64 {
        self.seen.position()
    }

    fn velocity(&self) -> f64 {
        self.seen.joint.load().velocity.to_degrees()
    }

    fn stuck(&self) -> bool {
        self.seen.stuck()
    }

    fn derivative_evaluations(&self) -> u64 {
        self.seen.derivative_evaluations()
    }
}

/// Factors by which a joint differs from its data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetFactors {
    /// Inertia.
    pub inertia: f64,
    /// Slip friction in both directions.
    pub slip: f64,
    /// Stick friction in both directions.
    pub stick: f64,
    /// Viscous friction, including that of the back-EMF.
    pub viscous: f64,
}

impl SheetFactors {
    /// Factors of the unchanged joint of the data sheet.
    pub const ONE: Self = Self { inertia: 1.0, slip: 1.0, stick: 1.0, viscous: 1.0 };
}

impl DataSheet {
    /// Returns whether the joint needs more than a rigid axis with two levels of friction.
    pub fn is_more_than_an_axis(&self) -> bool {
        let reaches_its_supply = matches!(
            DriveModel::of(self, 0.0),
            DriveModel::Amplifier { .. } | DriveModel::Bridge { .. }
        );
        self.asks_for().iter().any(|(_, is_asked)| *is_asked) || reaches_its_supply
    }

    /// Returns the keys of effects that an axis in closed form does not have, and whether the data
    /// sheet uses each.
    pub fn asks_for(&self) -> [(&'static str, bool); 12] {
        let reverse = [self.stick(), self.slip()].iter().any(|[one, other]| one != other);
        [
            ("gear.stiffness_nm_per_rad", self.stiffness().is_some()),
            ("load.constant_nm", self.load.constant_nm != 0.0),
            ("load.unbalance_nm", self.load.unbalance_nm != 0.0),
            ("load.stop_min_deg", self.load.stop_min_deg.is_some()),
            ("load.stop_max_deg", self.load.stop_max_deg.is_some()),
            ("friction.stick_reverse_nm", reverse),
            ("friction.stribeck_rad_per_s", self.stribeck().is_some_and(|speed| speed > 0.0)),
            ("friction.bristle_stiffness_nm_per_rad", self.bristle_stiffness().is_some()),
            ("friction.ripple", self.friction.ripple > 0.0),
            ("motor.inductance_h", self.lag_s() > 0.0),
            ("encoder.noise_counts", self.encoder.noise_counts > 0),
            ("load_encoder.noise_counts", self.load_noise_counts() > 0),
        ]
    }

    /// Returns the key of an effect that only [`SheetAxis`] has: a drive that is not ideal, or
    /// noise.
    pub fn has_a_drive_of_its_own(&self) -> Option<&'static str> {
        if self.encoder.noise_counts > 0 {
            return Some("encoder.noise_counts");
        }
        if self.load_noise_counts() > 0 {
            return Some("load_encoder.noise_counts");
        }
        // A device simulates the dead time of a bridge, and its supply with a capacitor.
        let has_capacitor = self.supply.as_ref().is_some_and(|supply| supply.capacitance_f > 0.0);
        let is_of_its_own = match self.motor.driven_by {
            DrivenBy::Voltage => !has_capacitor && self.supply_is_real(),
            DrivenBy::Current => DriveModel::of(self, 0.0) != DriveModel::Ideal,
        };
        is_of_its_own.then_some("supply")
    }

    /// Returns the joint without its drive, which replaces the axis in closed form in a device. Its
    /// position is that of the encoder's side; `times` scales its inertia and friction.
    pub fn substitute(
        &self,
        mapping: &Mapping,
        count_deg: f64,
        times: &SheetFactors,
    ) -> Option<Substitute> {
        let joint = self.description(mapping, count_deg.to_radians(), times);
        let substitute = Substitute { joint, units: mapping.units, side: self.side() };
        self.is_more_than_an_axis().then_some(substitute)
    }

    /// Returns the noise of the load's encoder, counts; 0 if it is not in the position loop.
    fn load_noise_counts(&self) -> u32 {
        self.load_encoder_in_loop().map_or(0, |load| load.noise_counts)
    }

    fn side(&self) -> joint::DiscSide {
        match self.position_side() {
            Some(EncoderPlace::Motor) => joint::DiscSide::Motor,
            Some(EncoderPlace::Load) | None => joint::DiscSide::Load,
        }
    }

    /// Returns L/R of a motor driven by a voltage, s; 0 with an amplifier, which compensates it.
    pub fn lag_s(&self) -> f64 {
        match (self.motor.driven_by, self.motor.resistance_ohm) {
            (super::tables::DrivenBy::Voltage, Some(ohm)) => self.motor.inductance_h / ohm,
            _ => 0.0,
        }
    }

    /// Returns the slip friction in the positive direction minus the mean of both directions, N m.
    fn offset(&self) -> f64 {
        let [forward, backward] = self.slip();
        0.5 * (forward - backward)
    }

    fn description(&self, mapping: &Mapping, count: f64, times: &SheetFactors) -> Description {
        let mean = |[forward, backward]: [f64; 2]| 0.5 * (forward + backward);
        let coulomb = times.slip * mean(self.slip());
        let curve = StribeckCurve {
            coulomb,
            // The difference of both ways is that of their slip levels. Equal levels times equal
            // factors can differ in their last bit.
            stick: (times.stick * self.stick()[0] - times.slip * self.offset()).max(coulomb),
            stribeck_velocity: self.stribeck().unwrap_or(0.0),
            viscous: times.viscous * mapping.viscous,
        };
        let friction = &self.friction;
        let ripple = (friction.ripple > 0.0).then(|| Ripple {
            depth: friction.ripple,
            cycles: friction.ripple_per_turn.unwrap_or(1.0),
            phase: friction.ripple_phase_deg.to_radians(),
        });
        let surface = |curve| SetValuedFriction { ripple, ..SetValuedFriction::from(curve) };
        let inertia = times.inertia * mapping.inertia;
        let train = match (self.bristle_stiffness(), self.stiffness()) {
            (Some(stiffness), _) => {
                let by_default = 1.4 * (stiffness * inertia).sqrt();
                let damping = self.bristle_damping().unwrap_or(by_default);
                Train::LuGre { inertia, curve, bristle: Bristle { stiffness, damping } }
            }
            (None, Some(stiffness)) => {
                let motor = friction.motor_share.unwrap_or(MOTOR_SHARE);
                // The back-EMF acts on the motor.
                let part = |share: f64, back_emf: f64| StribeckCurve {
                    coulomb: share * curve.coulomb,
                    stick: share * curve.stick,
                    viscous: times.viscous * (share * self.viscous() + back_emf),
                    ..curve
                };
                let load = times.inertia * self.load.inertia_kg_m2;
                let rotor = Body {
                    inertia: inertia - load,
                    friction: surface(part(motor, mapping.back_emf)),
                };
                // Friction that repeats with the gear's angle is on the motor's side.
                let load = Body { inertia: load, friction: part(1.0 - motor, 0.0).into() };
                let (damping, backlash) =
                    (self.damping().unwrap_or(0.0), self.backlash().unwrap_or(0.0));
                Train::Flexible {
                    motor: rotor,
                    load,
                    shaft: ShaftDescription { stiffness, damping, backlash },
                }
            }
            (None, None) => Train::Rigid(Body { inertia, friction: surface(curve) }),
        };
        let gravity = (self.load.unbalance_nm > 0.0).then(|| Gravity {
            amplitude: self.load.unbalance_nm,
            angle: -self.hangs_at().unwrap_or(0.0),
        });
        // Friction that is higher one way equals the mean plus a constant torque against that way.
        let constant = self.load.constant_nm - times.slip * self.offset();
        Description {
            load: LoadTorque { constant, gravity },
            lag_s: self.lag_s(),
            stops: Stops {
                lower: self.load.stop_min_deg.map_or(f64::NEG_INFINITY, f64::to_radians),
                upper: self.load.stop_max_deg.map_or(f64::INFINITY, f64::to_radians),
            },
            ..Description::of(train, count)
        }
    }
}
