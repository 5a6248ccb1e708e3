//! The servo's part of a [ramp](crate::identification::Ramp): the findings.

use super::{ControlLoop, Servo};
use crate::motion::Course;
use serde::{Deserialize, Serialize};

/// The friction levels that a ramp has found, in volts of effort. A level is none if the joint did
/// not move, or did not rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionLevels {
    /// Effort at the first count of the motion, V: the stick level.
    pub stick: Option<f32>,
    /// Effort at the last count before rest, V: the slip level.
    pub slip: Option<f32>,
}

impl Servo {
    /// Returns the levels found by a ramp that is over.
    pub fn levels(&self) -> Option<FrictionLevels> {
        let ControlLoop { course: Course::Ramp(ramp), state, .. } = self.control_loop.as_ref()?
        else {
            return None;
        };
        let found = state.ramp().findings();
        let volts = |rung: Option<u32>| rung.map(|rung| ramp.volts(rung));
        state
            .ramp()
            .is_over()
            .then(|| FrictionLevels { stick: volts(found.stick), slip: volts(found.slip) })
    }
}
