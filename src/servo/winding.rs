//! The servo's part of a [measurement of the winding](crate::motion::winding): arming, the board's
//! work, and the findings.

use super::{ControlLoop, Refusal, Servo, State};
use crate::control::winding_pulses::GroupSums;
use crate::motion::Course;
use crate::motion::winding::{WindingFindings, WindingTest};

impl Servo {
    /// Arms the servo for a link: at the next tick a measurement of the winding begins. The
    /// comparison of the current with the configured winding is off until it ends. From now on, the
    /// silence of that link is a fault.
    ///
    /// # Errors
    /// Returns the reason for the refusal; an armed servo refuses a measurement, and so does one
    /// whose encoder is in doubt: it bounds the travel. The joint need not be referenced.
    pub fn measure_winding(&mut self, test: WindingTest) -> Result<(), Refusal> {
        let is_in_doubt = self.is_encoder_in_doubt();
        let control_loop = self.ready_to_arm()?;
        if is_in_doubt {
            return Err(Refusal::EncoderInDoubt);
        }
        control_loop.begin(Course::Winding(test));
        self.start_loop(true);
        Ok(())
    }

    /// Takes the readings of the board's pulses.
    #[cold]
    #[inline(never)]
    pub fn pulsed(&mut self, sums: &GroupSums) {
        if let (State::Armed, Some(ControlLoop { course: Course::Winding(test), .. })) =
            (self.state, &mut self.control_loop)
        {
            test.take(sums);
        }
    }

    /// Returns the findings of a measurement that is over; none if a stop or a fault ended it.
    pub fn winding(&self) -> Option<WindingFindings> {
        let ControlLoop { course: Course::Winding(test), .. } = self.control_loop.as_ref()? else {
            return None;
        };
        test.is_over().then(|| *test.findings())
    }
}
