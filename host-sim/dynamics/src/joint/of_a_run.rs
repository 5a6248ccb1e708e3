//! Joint of a run: the axis of a machine's file in closed form, or another joint in its place.

use super::{AnyJoint, CoreUnits, Description, DiscSide, InCoreUnits};
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;
use crate::refused::InvalidModel;
use crate::solver::{AxisSolver, Event, ExactAxis};

/// Joint that replaces the axis of a machine's file. Encoder, drive, loop and controllers are still
/// those of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substitute {
    /// The joint, in SI.
    pub joint: Description,
    /// Conversion of its efforts.
    pub units: CoreUnits,
    /// Side of the gear with the encoder.
    pub side: DiscSide,
}

/// The joint of a run, between two samples.
#[derive(Clone, Debug)]
pub enum RunJoint {
    /// The axis of the file.
    Axis(ExactAxis),
    /// Joint that replaces the axis.
    Substitute(Box<InCoreUnits<AnyJoint>>),
}

impl RunJoint {
    /// Creates the joint of a run, at rest: the axis of the file, or the joint that replaces it.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn at_rest(
        axis: &RobotAxis,
        sample_time_s: f64,
        substitute: Option<&Substitute>,
    ) -> Result<Self, InvalidModel> {
        let Some(Substitute { joint, units, side }) = substitute else {
            return Ok(Self::Axis(ExactAxis::at_rest(axis, sample_time_s)));
        };
        let joint = InCoreUnits::new(joint.build()?, *units, *side, axis);
        Ok(Self::Substitute(Box::new(joint)))
    }

    /// Sets position (deg) and velocity (deg/s), as if the joint was moved by hand.
    pub fn put(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        match self {
            Self::Axis(axis) => {
                *axis = axis.clone().with_state(position_deg, velocity_deg_per_s);
            }
            Self::Substitute(joint) => joint.put(position_deg, velocity_deg_per_s),
        }
    }
}

/// Calls the same method of either joint.
macro_rules! either {
    ($joint:expr, $inner:ident => $does:expr) => {
        match $joint {
            Self::Axis($inner) => $does,
            Self::Substitute($inner) => $does,
        }
    };
}

impl AxisSolver for RunJoint {
    #[inline]
    fn advance(&mut self, v: f64, duration_s: f64, friction: &Coulomb, on: &mut impl FnMut(Event)) {
        either!(self, joint => joint.advance(v, duration_s, friction, on));
    }

    #[inline]
    fn position(&self) -> f64 {
        either!(self, joint => joint.position())
    }

    #[inline]
    fn measured_at_motor(&self) -> f64 {
        either!(self, joint => joint.measured_at_motor())
    }

    #[inline]
    fn at_load(&self) -> f64 {
        either!(self, joint => joint.at_load())
    }

    #[inline]
    fn velocity(&self) -> f64 {
        either!(self, joint => joint.velocity())
    }

    #[inline]
    fn motor_velocity(&self) -> f64 {
        either!(self, joint => joint.motor_velocity())
    }

    #[inline]
    fn effort_left(&self) -> f64 {
        either!(self, joint => joint.effort_left())
    }

    fn open_winding(&mut self, back_emf: f64) {
        either!(self, joint => joint.open_winding(back_emf));
    }

    #[inline]
    fn stuck(&self) -> bool {
        either!(self, joint => joint.stuck())
    }

    fn derivative_evaluations(&self) -> u64 {
        either!(self, joint => joint.derivative_evaluations())
    }
}
