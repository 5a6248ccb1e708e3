//! The joint of a run: the axis of a machine's file in closed form, or any other in its place.

use super::{AnyJoint, CoreUnits, Description, DiscSide, InCoreUnits};
use crate::friction::Coulomb;
use crate::mechanism::RobotAxis;
use crate::refused::InvalidModel;
use crate::solver::{AxisSolver, Event, ExactAxis};

/// A joint that takes the place of the axis that a machine's file describes. The rest of the file
/// stays: encoder, drive, loop, controllers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Substitute {
    /// The joint, in SI.
    pub joint: Description,
    /// The mapping of its efforts.
    pub units: CoreUnits,
    /// Where the encoder sits.
    pub side: DiscSide,
}

/// The joint of a run, between two samples.
#[derive(Clone, Debug)]
pub enum RunJoint {
    /// The axis of the file.
    Axis(ExactAxis),
    /// Another one.
    Substitute(Box<InCoreUnits<AnyJoint>>),
}

impl RunJoint {
    /// The joint of a run, at rest: the axis of the file or what takes its place.
    ///
    /// # Errors
    /// Names a value that no joint can have.
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

    /// Puts the joint somewhere (deg, deg/s), by hand.
    pub fn put(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        match self {
            Self::Axis(axis) => {
                *axis = axis.clone().with_state(position_deg, velocity_deg_per_s);
            }
            Self::Substitute(joint) => joint.put(position_deg, velocity_deg_per_s),
        }
    }
}

/// Does the same with either.
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
    fn stuck(&self) -> bool {
        either!(self, joint => joint.stuck())
    }

    fn derivative_evaluations(&self) -> u64 {
        either!(self, joint => joint.derivative_evaluations())
    }
}
