//! What an armed joint does: it follows a reference under its controller, or its friction is identified.
//!
//! Servo, simulator and the replay beside an emulated board all run a joint by these functions.

use crate::controller::{Controller, ControllerState, Tick};
use crate::identification::{Ramp, RampState};
use crate::reference::{Reference, Step};

/// A motion, ready to be run.
// The difference in size is a trajectory's corners: there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// The loop is closed; it has no end.
    Follow(Reference),
    /// The loop is open; it ends by itself.
    Ramp(Ramp),
}

/// What is remembered from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CourseState {
    controller: ControllerState,
    ramp: RampState,
}

impl Default for Course {
    /// Staying at zero.
    fn default() -> Self {
        Self::Follow(Reference::Step(Step::default()))
    }
}

impl Course {
    /// One tick.
    #[inline]
    pub fn tick(&self, controller: &Controller, state: &mut CourseState, counter: u32) -> Tick {
        let CourseState { controller: remembered, ramp: progress } = state;
        match self {
            Self::Follow(reference) => controller.tick(remembered, counter, reference),
            Self::Ramp(ramp) => {
                controller.open_loop(remembered, counter, |counts| ramp.update(progress, counts))
            }
        }
    }
}

impl CourseState {
    /// A joint at rest whose counter reads `counter` now, which is position `counts`.
    pub fn start(controller: &Controller, counter: u32, counts: i32) -> Self {
        Self { controller: controller.start(counter, counts), ramp: RampState::start(counts) }
    }

    /// theta_a as of the last tick, counts.
    pub const fn counts(&self) -> i32 {
        self.controller.counts()
    }

    /// Another motion begins at the next tick; the loop goes on.
    pub const fn begin_motion(&mut self) {
        self.controller.begin_motion();
    }

    /// What a ramp remembers; at its start in any other course.
    pub const fn ramp(&self) -> &RampState {
        &self.ramp
    }

    /// The same, to be changed.
    pub const fn ramp_mut(&mut self) -> &mut RampState {
        &mut self.ramp
    }
}
