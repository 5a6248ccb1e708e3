//! Inputs of a guest, in SI. The effort is in the unit of the joint's drive.

use stiction::control::laws::{Guest, LawInput, Loop};

/// The joint as in the rule book: the nominal joint and bounds, never the simulated joint.
///
/// The layout is that of `StictionLawJoint` in `stiction_law.h`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct JointFacts {
    /// Time between two ticks, s.
    pub sample_time: f64,
    /// Angle of a count, rad.
    pub count: f64,
    /// Largest effort.
    pub largest_effort: f64,
    /// Step of the effort.
    pub effort_step: f64,
    /// Nominal inertia, effort s^2/rad.
    pub inertia: f64,
    /// Nominal viscous friction, effort s/rad.
    pub viscous: f64,
    /// Lowest breakaway effort.
    pub breakaway_low: f64,
    /// Highest breakaway effort.
    pub breakaway_high: f64,
    /// Largest load that drives the joint against its friction; 0: the friction holds the load.
    pub load: f64,
    /// Effort that holds the load where the joint is armed, within 20 %.
    pub hold_effort: f64,
    /// Noise of the encoder at rest from peak to peak, counts.
    pub jitter: f64,
    /// Whether the encoder is on the load, behind an elastic gear.
    pub encoder_at_load: bool,
}

/// Inputs of one tick.
///
/// The layout is that of `StictionLawSample` in `stiction_law.h`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Sample {
    /// Position, counts.
    pub counts: i32,
    /// Whether the last effort was less than the law's.
    pub saturated: bool,
    /// Set point with its fraction, counts.
    pub target_counts: f64,
    /// Set point minus position, rad.
    pub error: f64,
    /// Measured velocity, rad/s.
    pub velocity: f64,
    /// Velocity of the set point, rad/s.
    pub target_velocity: f64,
    /// Acceleration of the set point, rad/s^2.
    pub target_acceleration: f64,
    /// Effort that the joint had since the last tick: limited, rounded, with soft start.
    pub applied: f64,
}

impl JointFacts {
    /// Returns the facts of a guest's joint.
    pub fn of(guest: &Guest) -> Self {
        let (joint, around) = (&guest.gains.joint, &guest.around);
        // The core's angles are in degrees.
        let per_radian = |per_degree: f32| f64::from(per_degree).to_degrees();
        Self {
            sample_time: around.sample_time.into(),
            count: f64::from(around.resolution).to_radians(),
            largest_effort: joint.largest_effort.into(),
            effort_step: around.lsb.into(),
            inertia: per_radian(joint.inertia),
            viscous: per_radian(joint.viscous),
            breakaway_low: joint.breakaway[0].into(),
            breakaway_high: joint.breakaway[1].into(),
            load: joint.load.into(),
            hold_effort: joint.hold_effort.into(),
            jitter: joint.jitter.into(),
            encoder_at_load: joint.encoder_at_load,
        }
    }
}

impl Sample {
    /// Returns the sample of a tick.
    pub fn of(input: &LawInput, around: &Loop) -> Self {
        let radians = |degrees: f32| f64::from(degrees).to_radians();
        let position = input.setpoint.position;
        let ahead = f64::from(input.error) / f64::from(around.resolution);
        Self {
            counts: input.counts,
            saturated: input.saturated,
            // The error is exact where counters wrap; without a wrap this is the set point.
            target_counts: if position.counts.checked_sub(input.counts).is_some() {
                f64::from(position.counts) + f64::from(position.fraction)
            } else {
                f64::from(input.counts) + ahead
            },
            error: radians(input.error),
            velocity: radians(input.velocity),
            target_velocity: radians(input.setpoint.velocity),
            target_acceleration: radians(input.setpoint.acceleration),
            applied: input.applied.into(),
        }
    }
}
