//! The servo's part of a [homing](crate::motion::home): arming for it, and the reference that it
//! sets.
//!
//! The joint is not referenced from the begin of a homing on. It is referenced again when the stop
//! was found, and by nothing that ends a homing before.

use super::referenced::Referenced;
use super::{ControlLoop, Refusal, Servo};
use crate::control::signal::Tick;
use crate::motion::Course;
use crate::motion::home::{Home, HomeEnd, HomeFindings};

impl Servo {
    /// Arms the servo for a link: at the next tick a homing begins. The range of positions is off,
    /// so is the monitor of an abrupt stop on the way there, and the reference ends. From now on,
    /// the silence of that link is a fault.
    ///
    /// # Errors
    /// Says what is in the way; an armed servo does not home. Unlike other motions, it does not
    /// have to be referenced. A homing that would end outside the range is refused.
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
        // The range must not forbid what finds its place.
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
        control_loop.begin_home(home);
        self.start_loop(true);
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.expect_stop(true);
        }
        Ok(())
    }

    /// Returns what the homing has found, once it is over. There is nothing if the homing was ended
    /// by a stop or a fault.
    pub fn homed(&self) -> Option<HomeFindings> {
        let home = self.control_loop.as_ref()?.home.as_ref()?;
        home.is_over().then(|| *home.found())
    }

    /// Sets the reference if what has ended is a homing that has found its stop.
    pub(super) fn take_home(&mut self) {
        let Some(ControlLoop { home: Some(home), zero, .. }) = &self.control_loop else { return };
        let found = home.found();
        if found.ended == HomeEnd::Stop {
            self.origin = zero.wrapping_add(found.moved).wrapping_sub(home.at());
            self.referenced = Referenced::Set;
        }
    }
}

impl ControlLoop {
    /// Prepares a homing in its place.
    #[inline(never)]
    fn begin_home(&mut self, home: Home) {
        self.begin(Course::Profile(home.profile));
        self.home = Some(home.watch);
    }

    /// Takes what the last tick has made of the homing, and returns whether it has ended.
    // The longest ticks are those of a profile without a homing.
    #[cold]
    #[inline(never)]
    pub(super) fn homing_ends(&mut self, tick: &Tick) -> bool {
        let (Course::Profile(profile), Some(home)) = (&mut self.course, &mut self.home) else {
            return false;
        };
        let was_back = home.is_back();
        let ends = home.ends(tick, profile);
        if home.is_back() != was_back {
            // A law that has given up at the stop tries again.
            self.state.begin_motion();
            self.watch.expect_stop(was_back);
        }
        ends
    }
}
