//! The joint of a run, and its plant for a device that lives longer than the run: it may be put
//! somewhere by hand, which Runge-Kutta's axis may not.

use super::plan::RunPlan;
use crate::error::Error;
use crate::joint::RunJoint;
use crate::plant::{Delay, Plant};

impl RunPlan {
    /// Gives the joint of this run, with its amplifier and its encoder, at rest at zero.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn plant(&self) -> Result<Plant<RunJoint>, Error> {
        let (axis, encoder) = (self.axis()?, self.encoder()?);
        let sample_time_s = self.machine.sampling.sample_time_s();
        let solver = self.joint()?;
        let scale = [self.machine.drive.lsb_v(), sample_time_s];
        Ok(Plant::new(solver, axis, encoder, scale, self.delay()))
    }

    /// Gives the joint of this run at rest: the axis of the file, or what takes its place.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn joint(&self) -> Result<RunJoint, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s();
        RunJoint::at_rest(&self.axis()?, sample_time_s, self.substitute.as_ref())
    }

    /// Returns how late the output is.
    pub(super) fn delay(&self) -> Delay {
        match self.machine.run.delay_samples {
            0 => Delay::None,
            _ => Delay::OneSample,
        }
    }
}
