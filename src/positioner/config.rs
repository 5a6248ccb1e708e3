//! Configuration of a positioner in SI units, and the error of a refused one.

use crate::control::motor_encoder::MotorEncoder;
use core::fmt;

use crate::control::laws::robust::EncoderSide;
use crate::control::laws::{Loop, RobustGains};
use crate::units::error::{Allowed, InvalidValue};
use crate::units::value::Table;

/// Configuration of a joint and of the loop around it.
///
/// Angles are rad of the joint, and the effort is in any unit: volts, amperes, N m, a share of the
/// duty. Inertia, friction, load and limits are in the same unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionerConfig {
    /// Time between two ticks h, s.
    pub sample_time: f32,
    /// Counts of the encoder in a turn of the joint, after the decoder (four a line) and the gear.
    pub counts_per_turn: f32,
    /// Largest effort u_m.
    pub largest_effort: f32,
    /// Step of the effort u_q: that of a D/A converter, of the PWM compare, or of a message. The
    /// returned effort is a multiple of it, or the largest effort.
    pub effort_step: f32,
    /// Moment of inertia J, as the effort of an acceleration of 1 rad/s^2.
    pub inertia: f32,
    /// Viscous friction B with back-EMF, as the effort of a speed of 1 rad/s.
    pub viscous: f32,
    /// Breakaway efforts of the joint over all positions: the lowest, and the highest.
    pub breakaway: [f32; 2],
    /// Largest load that drives the joint. 0: no load does.
    pub load: f32,
    /// Effort that holds the joint where it starts.
    pub hold_effort: f32,
    /// Counts by which the encoder changes at rest: 2 for noise of one count to either side.
    pub jitter: f32,
    /// Largest speed, rad/s. 0: `0.15 u_m / B`, and 3 rad/s at most if h is up to 10 ms.
    pub speed: f32,
    /// Largest acceleration, rad/s^2. 0: `0.25 u_m / J`.
    pub acceleration: f32,
    /// Side of the transmission on which the encoder sits.
    pub encoder_side: EncoderSide,
}

/// Error of a configuration: a field that is outside its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused {
    /// Name of the field, as in the configuration.
    pub field: &'static str,
    /// Value found, in the unit of the field.
    pub found: f32,
    /// Lowest value allowed.
    pub low: f32,
    /// Highest value allowed.
    pub high: f32,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { field, found, low, high } = self;
        write!(f, "{field} is {found}; must be from {low} to {high}")
    }
}

impl core::error::Error for Refused {}

/// Bounds of every number that has no other bounds: within them the law's products stay finite in
/// `f32`.
pub(super) const RANGE: [f32; 2] = [1e-6, 1e6];

/// Shortest and longest sample time, s: within them a law can count its fixed times in ticks.
pub(super) const SAMPLE_TIME: [f32; 2] = [1e-5, 0.1];

/// Least and most counts of a turn. Above 2^24 a turn is no whole number of counts in `f32`.
pub(super) const COUNTS: [f32; 2] = [16.0, 16_777_216.0];

/// Most counts of jitter, as in [`RobustGains`].
const JITTER: f32 = 100.0;

/// Refuses a value outside its range; NaN is in no range.
pub(super) fn check(field: &'static str, found: f32, [low, high]: [f32; 2]) -> Result<(), Refused> {
    if found >= low && found <= high { Ok(()) } else { Err(Refused { field, found, low, high }) }
}

/// Converts an error of the core into one with the name of the field in the table `T`.
pub(super) fn refused<T: Table>(error: InvalidValue) -> Refused {
    let field =
        T::ABOUT.iter().find(|about| about.key == error.key).map_or("", |about| about.field);
    let [low, high] = match error.allowed {
        Allowed::Between(low, high) | Allowed::Above(low, high) | Allowed::OrOff(low, high) => {
            [low, high]
        }
        Allowed::UpTo(high, _) | Allowed::DueTo(high, _) => [0.0, high],
        Allowed::SetBy(only, _) => [only, only],
        Allowed::Any | Allowed::LaterBy(_) | Allowed::AnotherLaw => [-RANGE[1], RANGE[1]],
    };
    Refused { field, found: error.found, low, high }
}

impl PositionerConfig {
    /// Validates the configuration, and returns the law's gains and its loop in the core's units:
    /// degrees instead of rad.
    ///
    /// # Errors
    /// Returns the first field that is outside its range.
    pub(super) fn prepared(&self) -> Result<(RobustGains, Loop), Refused> {
        let [least, most] = RANGE;
        check("sample_time", self.sample_time, SAMPLE_TIME)?;
        check("counts_per_turn", self.counts_per_turn, COUNTS)?;
        check("largest_effort", self.largest_effort, [least, most])?;
        check("effort_step", self.effort_step, [1e-6 * self.largest_effort, self.largest_effort])?;
        check("inertia", self.inertia, RANGE)?;
        check("viscous", self.viscous, [0.0, most])?;
        let [low, high] = self.breakaway;
        check("breakaway[0]", low, [1e-6 * self.largest_effort, self.largest_effort])?;
        check("breakaway[1]", high, [low, self.largest_effort])?;
        check("load", self.load, [0.0, self.largest_effort])?;
        check("hold_effort", self.hold_effort, [-self.largest_effort, self.largest_effort])?;
        check("jitter", self.jitter, [0.0, JITTER])?;
        check("speed", self.speed, [0.0, most])?;
        check("acceleration", self.acceleration, [0.0, most])?;
        let per_deg = |per_rad: f32| per_rad.to_radians();
        let gains = RobustGains {
            inertia: per_deg(self.inertia),
            viscous: per_deg(self.viscous),
            breakaway_low: low,
            breakaway_high: high,
            encoder_side: self.encoder_side,
            jitter: self.jitter,
            load: self.load,
            hold_effort: self.hold_effort,
            speed: self.speed.to_degrees(),
            acceleration: self.acceleration.to_degrees(),
            ..RobustGains::EXAMPLE
        };
        let around = Loop {
            sample_time: self.sample_time,
            resolution: 360.0 / self.counts_per_turn,
            full_scale: self.largest_effort,
            lsb: self.effort_step,
            // Without a PD loop beside it.
            kp: 0.0,
            motor: MotorEncoder::NONE,
        };
        Ok((gains, around))
    }
}
