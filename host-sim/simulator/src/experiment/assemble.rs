//! Builds the models of a run, and the whole loop, from the tables of a machine's file.

use stiction::control::encoder::{CounterBits, Encoder};
use stiction::units::value::Table;

use super::plan::{MAX_SAMPLES, RunPlan};
use super::task::Task;
use crate::closed_loop::ClosedLoop;
use dynamics::friction::{AddedFriction, Coulomb};
use dynamics::mechanism::RobotAxis;
use files::encoder::EncoderModel;
use files::error::{Error, rounded, shown};

impl RunPlan {
    /// Builds the model of the joint.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn axis(&self) -> Result<RobotAxis, Error> {
        let joint = &self.machine.joint;
        let friction = &joint.friction;
        self.above_zero("joint.gain_deg_per_s2_per_v", joint.gain_deg_per_s2_per_v)?;
        self.at_least_zero("joint.viscous_v_per_deg_per_s", joint.viscous_v_per_deg_per_s)?;
        self.at_least_zero("joint.friction.slip_v", friction.slip_v)?;
        self.above_zero("joint.friction.band_deg_per_s", friction.band_deg_per_s)?;
        self.check(
            "joint.friction.stick_v",
            friction.stick_v,
            friction.stick_v >= friction.slip_v,
            || format!("a number not below `slip_v` ({})", shown(friction.slip_v)),
        )?;
        let lowest = -friction.slip_v;
        self.check("joint.friction.added_v", friction.added_v, friction.added_v >= lowest, || {
            format!("a number not below {} (minus `slip_v`)", shown(lowest))
        })?;
        for (i, [from, to]) in friction.added_during_s.iter().flatten().enumerate() {
            if !(from.is_finite() && to.is_finite() && from < to) {
                let found = format!("[{}, {}]", shown(*from), shown(*to));
                let key = format!("joint.friction.added_during_s[{i}]");
                return Err(self.refuse(&key, &found, "a start and a later end, both finite"));
            }
        }
        Ok(RobotAxis {
            gain: joint.gain_deg_per_s2_per_v,
            viscous: joint.viscous_v_per_deg_per_s,
            friction: Coulomb { stick: friction.stick_v, slip: friction.slip_v },
            added: AddedFriction {
                amount: friction.added_v,
                during_s: friction.added_during_s.clone(),
            },
        })
    }

    /// Builds the model of the encoder that closes the position loop. Beside the motor's encoder,
    /// the one on the load has the same place of its zero between two counts.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn encoder(&self) -> Result<EncoderModel, Error> {
        let encoder = self.written_encoder()?;
        let core = self.position_encoder();
        Ok(self.machine.load_encoder_in_loop().map_or(encoder, |load| EncoderModel {
            resolution: load.count_deg(),
            counter_bits: core.counter_bits,
            direction: core.direction,
            ..encoder
        }))
    }

    /// Builds the model of the motor's encoder if a second encoder, on the load, closes the
    /// position loop.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn motor_encoder(&self) -> Result<Option<EncoderModel>, Error> {
        // The timer that counts it beside another encoder has 32 bits.
        let counter_bits = CounterBits::ThirtyTwo;
        if let Some(motor) = self.motor_encoder_of_a_device()? {
            let (resolution, direction) = (f64::from(motor.count), motor.direction);
            let of_load = self.written_encoder()?;
            return Ok(Some(EncoderModel { resolution, direction, counter_bits, ..of_load }));
        }
        if self.machine.load_encoder_in_loop().is_none() {
            return Ok(None);
        }
        Ok(Some(EncoderModel { counter_bits, ..self.written_encoder()? }))
    }

    /// Builds the model of the encoder of `[encoder]`.
    fn written_encoder(&self) -> Result<EncoderModel, Error> {
        let written = &self.machine.encoder;
        let core = written.core(Encoder::EXAMPLE);
        let phase = written.extras.phase;
        self.above_zero("encoder.resolution_deg", written.resolution_deg())?;
        self.check("encoder.phase", phase, (-1.0..=1.0).contains(&phase), || {
            "a number from -1 to 1".into()
        })?;
        Ok(EncoderModel {
            resolution: written.resolution_deg(),
            rounding: written.extras.rounding,
            phase,
            counter_bits: core.counter_bits,
            direction: core.direction,
        })
    }

    /// Builds the whole loop, ready to run.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn closed_loop(&self) -> Result<ClosedLoop, Error> {
        let machine = &self.machine;
        self.above_zero("run.step_s", machine.run.step_s)?;
        let controller = self.controller()?;
        Ok(ClosedLoop {
            course: self.course()?,
            controller,
            encoder: self.encoder()?,
            motor_encoder: self.motor_encoder()?,
            absolute_zero: self.absolute_zero(),
            lsb_v: machine.drive.lsb_v(),
            sample_time_s: machine.sampling.sample_time_s(),
            delay: self.delay(),
            supply: self.supply,
            axis: self.axis()?,
        })
    }

    /// Returns the number of samples after the first.
    ///
    /// # Errors
    /// Returns an error if the duration is not a positive number of at most ten million samples.
    pub fn samples(&self) -> Result<u32, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s();
        let duration_s = self.duration_s();
        let samples = (duration_s / sample_time_s).round();
        self.check("run.duration_s", duration_s, (1.0..=MAX_SAMPLES).contains(&samples), || {
            let longest_s = rounded(MAX_SAMPLES * sample_time_s);
            format!("a number from {} (one sample) to {longest_s}", shown(sample_time_s))
        })?;
        Ok(samples as u32)
    }

    /// Checks every value of the run without running it.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn validate(&self) -> Result<(), Error> {
        self.closed_loop()?;
        self.sheet_axis()?;
        match self.task {
            Task::Ramp(rate) => self.ramp(rate).map(|_| ()),
            Task::Step(_) | Task::Trajectory(_) | Task::Sine(_) => self.samples().map(|_| ()),
        }
    }
}
