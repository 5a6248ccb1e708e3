//! The servo's part of an [identification](crate::identification): arming, and the findings.

use super::{ControlLoop, Refusal, Servo};
use crate::identification::{Findings, Identification, IdentificationPlan};
use crate::motion::Course;
use crate::safety::monitor::PositionLimits;

impl Servo {
    /// Arms the servo for a link: at the next tick an identification begins. The monitor that
    /// requires a known direction of the encoder is off until the servo is armed anew. From now on,
    /// the silence of that link is a fault.
    ///
    /// # Errors
    /// Returns the reason for the refusal. A travel that could leave the range of positions is
    /// refused. An armed servo refuses an identification.
    pub fn identify(&mut self, settings: &IdentificationPlan) -> Result<(), Refusal> {
        let (here, origin) = (self.follower.seen.position, self.known_origin());
        let control_loop = self.ready_to_close()?;
        let range = control_loop.monitors.range(origin);
        if is_too_near_to_the_end(settings.travel(), here, range) {
            return Err(Refusal::OutOfRange);
        }
        control_loop.begin_identification(settings);
        self.start_loop(true);
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch.suppose_direction();
        }
        Ok(())
    }

    /// Returns the findings of an identification that is over; none if a stop or a fault ended it.
    pub fn identified(&self) -> Option<&Findings> {
        let ControlLoop { course: Course::Identification(identification), .. } =
            self.control_loop.as_ref()?
        else {
            return None;
        };
        identification.is_over().then(|| identification.findings())
    }

    /// Returns the number of completed steps of the present identification; none in another course.
    pub fn identification_steps(&self) -> Option<u8> {
        let ControlLoop { course: Course::Identification(identification), .. } =
            self.control_loop.as_ref()?
        else {
            return None;
        };
        Some(identification.findings().steps)
    }
}

impl ControlLoop {
    /// Starts an identification. It replaces the [`Course`], which is the motion of the loop. It is
    /// built in place, because it has the size of most of a kilobyte.
    #[inline(never)]
    fn begin_identification(&mut self, settings: &IdentificationPlan) {
        self.begin(Course::Identification(Identification::new(settings)));
    }
}

/// Returns whether a joint at `position` (counts since power-on) may leave the range if it goes
/// `travel` counts either way.
fn is_too_near_to_the_end(travel: u32, position: i32, range: PositionLimits) -> bool {
    let out = |travel: i32| range.check(position.wrapping_add(travel));
    let travel = travel.min(i32::MAX as u32) as i32;
    out(travel) || out(-travel)
}
