//! The servo's part of the [encoder's index](crate::safety::encoder_index): passes that the board
//! has captured check the counts, and end a homing.
//!
//! The check starts anew when the position becomes known, with other parameters, and with its own
//! fault. A homing to the index starts it at the place that it has found. The check runs in every
//! state, since counts are lost with the output off as well. A deviation behind another fault ends
//! the reference, and is a fault at the next pass after that one is cleared.

use super::referenced::Referenced;
use super::{Servo, State};
use crate::motion::home::IndexPass;
use crate::safety::encoder_index::IndexState;
use crate::safety::fault::{Fault, LatchedFault};

impl Servo {
    /// Returns whether the joint's encoder has an index. The board then calls
    /// [`pass_index`](Self::pass_index) before each tick.
    pub fn has_index(&self) -> bool {
        self.control_loop.as_ref().is_some_and(|control_loop| control_loop.index.is_some())
    }

    /// Checks the counts with the reading of the counter that the index has captured since the last
    /// call, if there was one. Of two passes in a tick, that is the last one: both are apart by a
    /// whole number of turns. A board with an index calls this before each tick, and before it
    /// reads the counter.
    // Not in the tick, which it would make longer.
    #[cold]
    #[inline(never)]
    pub fn pass_index(&mut self, captured: Option<u32>) {
        let Some(control_loop) = &mut self.control_loop else { return };
        let Some(check) = control_loop.index else { return };
        let Some([position, pass]) = self.follower.at(&control_loop.controller, captured) else {
            return;
        };
        let pass = captured.map(|_| pass);
        if let (Some(home), Some(place)) = (&mut control_loop.home, pass)
            && let Some(of_joint) =
                self.follower.joint_after(&control_loop.controller, place.wrapping_sub(position))
        {
            let [way, position] = of_joint.map(|at| at.wrapping_sub(control_loop.zero));
            home.pass_index(IndexPass { position, way, place });
        }
        if let Some(deviation) = check.update(&mut self.index, position, pass) {
            // The position is known to be wrong, also where a reset sets it.
            self.referenced = Referenced::No;
            if !matches!(self.state, State::Faulted(_)) {
                let (tick, value) = (self.clock, deviation as f32);
                self.latch(LatchedFault { fault: Fault::IndexDeviation, tick, value });
                self.restart_index(None);
            }
        }
    }

    /// Restarts the check, with a pass of the index at `place` (counts since power-on), if known.
    pub(super) fn restart_index(&mut self, place: Option<i32>) {
        self.index = IndexState::start(place);
    }

    /// Returns the number of passes of the index since the check has started, and the deviation of
    /// the last one, counts.
    pub const fn index_passes(&self) -> (u32, i32) {
        self.index.passes()
    }
}
