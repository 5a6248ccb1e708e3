//! The control loop of a joint: controller, course and monitors, which parameters make once, and
//! what each of them remembers.

use super::control;
use crate::controller::{Controller, Reading};
use crate::error::Error;
use crate::hardware::Hardware;
use crate::monitor::{MonitorState, Monitors};
use crate::motion::{Course, CourseState};
use crate::parameters::Parameters;
use crate::position::Position;
use crate::reference::Reference;
use crate::signal::Tick;

/// The control loop of a joint, made of parameters by [`ControlLoop::prepare`].
#[derive(Clone, Debug)]
pub struct ControlLoop {
    pub(super) controller: Controller,
    /// The course that is run: the motion of the parameters, until a link asks for another one.
    /// There is no room for both.
    pub(super) course: Course,
    /// Whether a link has replaced the motion of the parameters.
    pub(super) replaced: bool,
    pub(super) state: CourseState,
    /// The position in which the loop was armed, counts since power-on.
    pub(super) zero: i32,
    pub(super) monitors: Monitors,
    pub(super) watch: MonitorState,
    /// Ticks from the first one until the servo arms itself; none: it does not.
    pub(super) autostart: Option<u32>,
}

impl ControlLoop {
    /// Validates parameters and prepares all that a tick needs, in the place that is given: a loop
    /// is a kilobyte, and the stack of a board has no room for two.
    ///
    /// # Errors
    /// Names the first value that is not allowed, as [`Parameters::prepare`] does; nothing is
    /// changed then.
    pub fn prepare(
        place: &mut Option<Self>,
        parameters: &Parameters,
        hardware: &Hardware,
    ) -> Result<(), Error> {
        parameters.check()?;
        Self::begin_with(place, parameters, hardware)?;
        match place {
            Some(prepared) => {
                parameters.motion.prepare(&parameters.controller, &mut prepared.course)
            }
            None => Ok(()),
        }
    }

    /// Prepares all but the motion. It is a function of its own, so that the stack that it needs is
    /// free again for the motion.
    #[inline(never)]
    fn begin_with(
        place: &mut Option<Self>,
        parameters: &Parameters,
        hardware: &Hardware,
    ) -> Result<(), Error> {
        let Parameters { device, limits, controller: config, .. } = parameters;
        let mut controller = Controller::new(config, hardware)?;
        parameters.on_device(&mut controller, hardware);
        *place = Some(Self {
            controller,
            course: Course::default(),
            replaced: false,
            state: CourseState::default(),
            zero: 0,
            monitors: Monitors::new(limits, config, device, hardware),
            watch: MonitorState::default(),
            autostart: device.autostart.then(|| parameters.in_ticks(device.autostart_delay)),
        });
        Ok(())
    }

    /// Begins the loop's course at `position` (counts since power-on), which becomes zero. If a
    /// link asked for it, the silence of that link is watched.
    pub(super) fn arm(&mut self, position: i32, by_link: bool) {
        self.zero = position;
        self.state = CourseState::start(&self.controller, 0);
        self.watch = self.monitors.armed(&self.watch, by_link);
    }

    /// Forgets the state of the law and of the monitors, but not the motor's heat, and not what a
    /// ramp or a jog has found.
    pub(super) fn rest(&mut self) {
        if !self.is_over() {
            self.state = CourseState::default();
        }
        self.watch = self.monitors.armed(&self.watch, false);
    }

    /// Replaces the motion of the parameters by the course that a link asks for.
    pub(super) fn begin(&mut self, course: Course) {
        self.course = course;
        self.replaced = true;
        self.watch.listen();
        self.state.begin_motion();
    }

    /// Returns whether a position, counted from the zero of this arming, is out of the range.
    pub(super) const fn is_out_of_range(&self, position: Position) -> bool {
        self.monitors.is_out_of_range(self.zero.wrapping_add(position.counts))
    }

    /// Returns whether a trajectory begins farther from `counts`, in the zero of an arming, than the
    /// following error may be.
    pub(super) fn begins_far_from(&self, course: &Course, counts: i32) -> bool {
        let Course::Follow(Reference::Trajectory(trajectory)) = course else { return false };
        // It rests there before its first blend.
        let first = trajectory.corners().next().unwrap_or_default().position.counts;
        self.monitors.is_beyond_following_error(first.wrapping_sub(counts))
    }

    /// Runs one tick with the joint at `position`, counts since power-on.
    #[inline]
    pub(super) fn tick(&mut self, position: i32, supply: u16) -> Tick {
        let travel = position.wrapping_sub(self.zero).wrapping_sub(self.state.counts());
        let tick =
            control(&self.course, &self.controller, &mut self.state, Reading { travel, supply });
        if tick.saturated {
            self.state.capped(&self.course);
        }
        tick
    }

    /// Returns whether the course has ended. A ramp and a jog end; a reference does not.
    pub(super) const fn is_over(&self) -> bool {
        self.state.is_over(&self.course)
    }
}
