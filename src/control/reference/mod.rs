//! The reference generators: they compute the set point of the joint at a tick.
//!
//! Each generator returns position, velocity and acceleration. Time is the number of ticks since
//! the motion began. The position is in counts and a fraction of a count, never rounded to a count.

mod braking;
mod sine;
mod step;
mod trajectory;

pub use braking::Braking;
pub use sine::Sine;
pub(crate) use sine::{AMPLITUDE, FREQUENCY};
pub use step::Step;
pub(crate) use trajectory::{CORNER_TIMES, HALF_BLEND};
pub use trajectory::{Corner, MAX_CORNERS, Trajectory};

use crate::units::position::Position;

/// The set point: position, velocity and acceleration that the joint should have at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Setpoint {
    /// Position theta_d.
    pub position: Position,
    /// Velocity theta_d', deg/s.
    pub velocity: f32,
    /// Acceleration theta_d'', deg/s^2.
    pub acceleration: f32,
}

impl Setpoint {
    /// Returns the set point of a joint that should be at rest at a position.
    pub const fn at_rest(position: Position) -> Self {
        Self { position, velocity: 0.0, acceleration: 0.0 }
    }

    /// Returns whether every part is a finite number.
    pub const fn is_finite(&self) -> bool {
        // Zero times a finite number is zero, and times any other it is NaN: one comparison for all
        // three.
        0.0 * self.position.fraction + 0.0 * self.velocity + 0.0 * self.acceleration == 0.0
    }
}

/// A reference: one of the generators, chosen at run time.
// The difference in size is a trajectory's corners: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// A jump from one position to another.
    Step(Step),
    /// Linear segments with parabolic blends.
    Trajectory(Trajectory),
    /// From a velocity to rest.
    Braking(Braking),
    /// To and fro, from rest.
    Sine(Sine),
}

impl Reference {
    /// Returns the set point `tick` ticks after the motion began.
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn at(&self, tick: u32) -> Setpoint {
        match self {
            Self::Step(step) => step.at(tick),
            Self::Trajectory(trajectory) => trajectory.at(tick),
            Self::Braking(_) | Self::Sine(_) => self.seldom_at(tick),
        }
    }

    // Four cases in the loop of a host cost it a fifth of its speed (tests/evidence/speed.md).
    #[cfg_attr(target_os = "none", inline(always))]
    #[cfg_attr(not(target_os = "none"), inline(never))]
    fn seldom_at(&self, tick: u32) -> Setpoint {
        match self {
            Self::Step(step) => step.at(tick),
            Self::Trajectory(trajectory) => trajectory.at(tick),
            Self::Braking(braking) => braking.at(tick),
            Self::Sine(sine) => sine.at(tick),
        }
    }
}
