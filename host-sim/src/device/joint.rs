//! The joint of a machine's file as a device has it on its pins: a disc that is read and an effort that is held.

use stiction::encoder::Direction;

use crate::encoder::EncoderModel;
use crate::error::Error;
use crate::experiment::RunPlan;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, ExactAxis};

/// A joint, sample by sample.
#[derive(Clone, Debug)]
pub struct SimulatedJoint {
    axis: RobotAxis,
    solver: ExactAxis,
    encoder: EncoderModel,
    lsb_v: f64,
    sample_time_s: f64,
    /// The code of the sample before, if the run has a sample of computation delay.
    delayed: Option<i16>,
    time_s: f64,
    samples: u64,
}

impl SimulatedJoint {
    /// At rest at zero.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn new(plan: &RunPlan) -> Result<Self, Error> {
        let (axis, encoder) = (plan.axis()?, plan.encoder()?);
        let sample_time_s = plan.machine.sampling.sample_time_s();
        Ok(Self {
            solver: ExactAxis::at_rest(&axis, sample_time_s),
            axis,
            encoder,
            lsb_v: plan.machine.drive.lsb_v(),
            sample_time_s,
            delayed: (plan.machine.run.delay_samples == 1).then_some(0),
            time_s: 0.0,
            samples: 0,
        })
    }

    /// What a counter with sound wires reads.
    pub fn counter(&self) -> u32 {
        self.encoder.counter(self.solver.position())
    }

    /// Where the disc is, in counts of a counter that does not wrap.
    pub fn disc(&self) -> i64 {
        let counts = self.encoder.counts(self.solver.position());
        match self.encoder.direction {
            Direction::Forward => counts,
            Direction::Reverse => -counts,
        }
    }

    /// The code that was put out is held for a time (s), or nothing if the output is off. `brake_v` is friction on top of
    /// the machine's own, V: a hand on the joint, a hard stop.
    pub fn hold(&mut self, code: i16, is_on: bool, brake_v: f64, duration_s: f64) {
        let code = match &mut self.delayed {
            Some(before) => std::mem::replace(before, code),
            None => code,
        };
        // Off is off at once: that is the pin, not the computation.
        let v = if is_on { f64::from(code) * self.lsb_v } else { 0.0 };
        // Counted in samples as long as it is samples, so that nothing adds up.
        let time_s = self.time_s + self.samples as f64 * self.sample_time_s;
        let friction = self.axis.friction_at(time_s + 0.5 * duration_s).raised(brake_v);
        self.solver.advance(v, duration_s, &friction, &mut |_| {});
        if duration_s == self.sample_time_s {
            self.samples += 1;
        } else {
            self.time_s += duration_s;
        }
    }

    /// True position, deg.
    pub fn position_deg(&self) -> f64 {
        self.solver.position()
    }

    /// True velocity, deg/s.
    pub fn velocity_deg_per_s(&self) -> f64 {
        self.solver.velocity()
    }

    /// It is put somewhere, by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.solver = self.solver.clone().with_state(position_deg, velocity_deg_per_s);
    }

    /// The plan's time between samples, s.
    pub const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }
}
