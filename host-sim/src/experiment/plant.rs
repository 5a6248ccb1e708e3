//! The plant of a run, for a device that lives longer than the run: solved in closed form, since it
//! may be put somewhere by hand.

use super::plan::RunPlan;
use crate::error::Error;
use crate::plant::{Delay, Plant};
use crate::solver::ExactAxis;

impl RunPlan {
    /// Gives the joint of this run, with its amplifier and its encoder, at rest at zero.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn plant(&self) -> Result<Plant<ExactAxis>, Error> {
        let (axis, encoder) = (self.axis()?, self.encoder()?);
        let sample_time_s = self.machine.sampling.sample_time_s();
        let solver = ExactAxis::at_rest(&axis, sample_time_s);
        let scale = [self.machine.drive.lsb_v(), sample_time_s];
        Ok(Plant::new(solver, axis, encoder, scale, self.delay()))
    }
    /// Returns how late the output is.
    pub(super) fn delay(&self) -> Delay {
        match self.machine.run.delay_samples {
            0 => Delay::None,
            _ => Delay::OneSample,
        }
    }
}
