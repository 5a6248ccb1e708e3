//! A course: a motion that is prepared for a loop, tick by tick.

use crate::control::controller::{Controller, ControllerState, Reading};
use crate::control::profile::Profile;
use crate::control::reference::{Reference, Step};
use crate::control::signal::Tick;
use crate::identification::{Identification, Ramp, RampState};
use crate::motion::jog::{Jog, JogState};
use crate::motion::winding::WindingTest;

/// A motion that is prepared for a loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// The loop is closed and follows a reference, which has no end.
    Follow(Reference),
    /// The loop is open and applies a ramp, which ends automatically.
    Ramp(Ramp),
    /// The loop is closed and follows a profile, which holds its own state.
    Profile(Profile),
    /// The loop is open and applies the efforts of a jog, which ends automatically.
    Jog(Jog),
    /// The loop is open and applies the efforts of an identification, which ends automatically. The
    /// identification holds its own state, in the memory that a trajectory's corners would occupy.
    Identification(Identification),
    /// The board pulses the winding, which ends automatically. The effort of a tick is zero.
    Winding(WindingTest),
}

/// The state of a course from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CourseState {
    controller: ControllerState,
    ramp: RampState,
    jog: JogState,
}

impl Default for Course {
    /// Returns a course that stays at zero.
    fn default() -> Self {
        Self::Follow(Reference::Step(Step::default()))
    }
}

impl Course {
    /// Runs one tick of the course.
    #[inline]
    pub fn tick(
        &mut self,
        controller: &Controller,
        state: &mut CourseState,
        reading: Reading,
    ) -> Tick {
        let CourseState { controller: remembered, ramp: progress, jog: jogged } = state;
        match self {
            Self::Follow(reference) => controller.tick(remembered, reading, reference),
            Self::Profile(profile) => controller.follow(remembered, reading, profile.update()),
            Self::Ramp(ramp) => {
                controller.open_loop(remembered, reading, |counts| ramp.update(progress, counts))
            }
            Self::Jog(jog) => {
                #[cfg(feature = "two-encoders")]
                let motor = controller.motor_encoder().map(|_| reading.motor_counts);
                #[cfg(not(feature = "two-encoders"))]
                let motor = None;
                let effort = |counts| jog.update(jogged, counts, motor);
                controller.open_loop(remembered, reading, effort)
            }
            Self::Identification(identification) => {
                identify(controller, remembered, reading, identification)
            }
            Self::Winding(test) => measure(controller, remembered, reading, test),
        }
    }

    /// Returns whether the loop is open.
    pub(crate) const fn is_open(&self) -> bool {
        matches!(self, Self::Ramp(_) | Self::Jog(_) | Self::Identification(_) | Self::Winding(_))
    }

    /// Restarts the course together with the loop: otherwise, a profile and an identification would
    /// go on from their last tick. A profile sets out after `wait` ticks.
    pub(crate) fn restart(&mut self, wait: u32) {
        if let Self::Profile(profile) = self {
            profile.restart();
            profile.wait(wait);
        }
        if let Self::Identification(identification) = self {
            identification.restart();
        }
        if let Self::Winding(test) = self {
            test.restart();
        }
    }
}

/// Runs a tick of an identification. It is a separate function, so that the other courses do not
/// become slower.
#[inline(never)]
fn identify(
    controller: &Controller,
    state: &mut ControllerState,
    reading: Reading,
    identification: &mut Identification,
) -> Tick {
    let tick = controller.open_loop(state, reading, |counts| identification.update(counts));
    identification.applied(tick.v_applied);
    tick
}

/// Runs a tick of a measurement of the winding. It is a separate function, so that the other
/// courses do not become slower.
#[inline(never)]
fn measure(
    controller: &Controller,
    state: &mut ControllerState,
    reading: Reading,
    test: &mut WindingTest,
) -> Tick {
    controller.open_loop(state, reading, |counts| test.update(counts))
}

impl CourseState {
    /// Resets the whole state, in place.
    pub(crate) fn forget(&mut self) {
        self.controller.forget();
        self.ramp = RampState::default();
        self.jog = JogState::default();
    }

    /// Returns the state of a joint at rest in position `counts`, before the first tick of the
    /// course.
    pub fn start(controller: &Controller, counts: i32) -> Self {
        Self {
            controller: controller.start(counts),
            ramp: RampState::start(counts),
            jog: JogState::start(counts),
        }
    }

    /// Returns the number of the next tick, counted from the start of the motion.
    pub const fn next_tick(&self) -> u32 {
        self.controller.next_tick()
    }

    /// Returns the state of the controller.
    pub(crate) const fn controller(&self) -> &ControllerState {
        &self.controller
    }

    /// Returns theta_a as of the last tick, counts.
    pub const fn counts(&self) -> i32 {
        self.controller.counts()
    }

    /// Returns the ticks until the output's limit has risen to the full scale after arming.
    pub(crate) const fn soft_start_left(&self, controller: &Controller) -> u32 {
        controller.soft_start_left(&self.controller)
    }

    /// Sets the least code of the next tick in its direction; zero: none.
    pub(crate) const fn push(&mut self, least: i32) {
        self.controller.push(least);
    }

    /// Starts a motion at the next tick: the count of ticks restarts at zero, and a law that has
    /// given up tries again. The rest of the loop's state is kept.
    pub fn begin_motion(&mut self) {
        self.controller.begin_motion();
    }

    /// Returns the state of the ramp. In any other course, it stays as at a ramp's start.
    pub const fn ramp(&self) -> &RampState {
        &self.ramp
    }

    /// Returns the state of the jog. In any other course, it stays as at a jog's start.
    pub const fn jog(&self) -> &JogState {
        &self.jog
    }

    /// Returns whether a course that has an end is over.
    pub const fn is_over(&self, course: &Course) -> bool {
        match course {
            Course::Follow(_) | Course::Profile(_) => false,
            Course::Ramp(_) => self.ramp.is_over(),
            Course::Jog(_) => self.jog.is_over(),
            Course::Identification(identification) => identification.is_over(),
            Course::Winding(test) => test.is_over(),
        }
    }

    /// Called when an open loop does not get the effort that it requests: a ramp then ends without
    /// levels, a jog ends its way, and an identification ends a push without a reading.
    pub(crate) fn capped(&mut self, course: &mut Course) {
        match course {
            Course::Follow(_) | Course::Profile(_) | Course::Winding(_) => {}
            Course::Ramp(_) => self.ramp.abandon(),
            Course::Jog(_) => self.jog.capped(),
            Course::Identification(identification) => identification.capped(),
        }
    }
}
