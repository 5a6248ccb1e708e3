//! The servo's part of a [homing](crate::motion::home): arming, and setting the reference.
//!
//! The joint loses its reference when a homing begins. It is referenced again once the homing has
//! found its place. A homing that ends otherwise leaves the joint unreferenced. The exception is a
//! joint whose range is less than a turn of an absolute encoder: once the output is off, its angle
//! sets the reference again (`servo/absolute_load.rs`).

use super::referenced::Referenced;
use super::{ControlLoop, Input, Refusal, Servo};
use crate::control::signal::Tick;
use crate::motion::Course;
use crate::motion::home::{Home, HomeFindings};

impl Servo {
    /// Arms the servo for a link: at the next tick a homing begins. The reference ends, so the
    /// range of positions is off. The monitor of an abrupt stop is off on the way to a hard stop.
    /// From now on, the silence of that link is a fault.
    ///
    /// # Errors
    /// Returns the reason for the refusal; an armed servo refuses a homing. Unlike for other
    /// motions, the joint need not be referenced. A homing that would end outside the range is
    /// refused.
    pub fn home(&mut self, home: Home) -> Result<(), Refusal> {
        if home.watch.at().unsigned_abs() >= 1 << 30 {
            return Err(Refusal::TooFar);
        }
        let ends_outside = self.control_loop.as_ref().is_some_and(|control_loop| {
            control_loop.monitors.range(Some(0)).check(home.watch.leaves_at())
        });
        if ends_outside {
            return Err(Refusal::OutOfRange);
        }
        // The range must not forbid the homing that finds its zero.
        let before = core::mem::replace(&mut self.referenced, Referenced::No);
        let begun = self.begin_home(home);
        if begun.is_err() {
            self.referenced = before;
        }
        begun
    }

    fn begin_home(&mut self, home: Home) -> Result<(), Refusal> {
        let is_in_doubt = self.is_encoder_in_doubt();
        let control_loop = self.ready_to_arm()?;
        if is_in_doubt {
            return Err(Refusal::EncoderInDoubt);
        }
        if control_loop.monitors.is_friction_unknown() {
            return Err(Refusal::FrictionUnknown);
        }
        let expects_stop = home.watch.expects_stop();
        control_loop.begin_home(home);
        self.start_loop(true);
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.expect_stop(expects_stop);
        }
        Ok(())
    }

    /// Returns the findings of a homing that is over; none if a stop command or a fault ended it.
    pub fn homed(&self) -> Option<HomeFindings> {
        let home = self.control_loop.as_ref()?.home.as_ref()?;
        home.is_over().then(|| *home.found())
    }

    /// Sets the reference if a homing has ended and has found its place.
    pub(super) fn take_home(&mut self) {
        let Some(control_loop) = &self.control_loop else { return };
        let ControlLoop { home: Some(home), zero, .. } = control_loop else { return };
        let found = home.found();
        if found.ended.is_found() {
            self.origin = zero.wrapping_add(found.moved).wrapping_sub(home.at());
            self.referenced = Referenced::Set;
            let index = home.index();
            self.restart_index(index);
        }
    }
}

impl ControlLoop {
    /// Starts a homing. It replaces the [`Course`], which is the motion of the loop.
    #[inline(never)]
    fn begin_home(&mut self, home: Home) {
        self.begin(Course::Profile(home.profile));
        self.home = Some(home.watch);
    }

    /// Updates the homing with the last tick, and returns whether it has ended.
    // The longest ticks are those of a profile without a homing.
    #[cold]
    #[inline(never)]
    pub(super) fn homing_ends(&mut self, tick: &Tick, lines: u8) -> bool {
        let (Course::Profile(profile), Some(home)) = (&mut self.course, &mut self.home) else {
            return false;
        };
        let was_back = home.is_back();
        let ends = home.ends(tick, lines & Input::SWITCH != 0, profile);
        if home.is_back() != was_back {
            // A law that has given up at the stop tries again.
            self.state.begin_motion();
            self.watch.expect_stop(was_back && home.expects_stop());
        }
        ends
    }
}
