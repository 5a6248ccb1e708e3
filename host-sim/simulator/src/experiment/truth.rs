//! The true joint of a simulated device, where it is another than the one that the commands believe.
//!
//! A device knows its encoder, its drive and its sample time for certain: files that contradict each
//! other there describe two devices, and are refused. Motor, gear, load, friction, and the volts of a
//! code are the plant's alone, and may be anything.

use stiction::control::encoder::{CounterBits, Encoder};
use stiction::units::value::Table as _;

use super::plan::RunPlan;
use crate::error::{Error, rounded};

/// Two figures of a device are the same if they differ by less than this part: a file that was pulled
/// from a device has them in single precision, and the volts of a code have five digits.
const SAME: f64 = 1e-4;

impl RunPlan {
    /// Returns this plan with the plant of `truth`. The parameters of a device stay those of this
    /// plan.
    ///
    /// # Errors
    /// Names a figure of the device that is another in `truth`.
    pub fn with_truth(self, truth: Self) -> Result<Self, Error> {
        let own = self.of_the_device();
        for ((what, key, found), (.., believed)) in truth.of_the_device().into_iter().zip(own) {
            if (found - believed).abs() > SAME * believed.abs() {
                return Err(Error::Input(format!(
                    "--truth {}: {what} ({key}) is {}, and {} in {}; a device has one of them, so \
                     both files need the same",
                    truth.origin,
                    rounded(found),
                    rounded(believed),
                    self.origin,
                )));
            }
        }
        Ok(Self { truth: Some(Box::new(truth)), ..self })
    }

    /// Returns the figures that a device knows for certain, with their keys.
    fn of_the_device(&self) -> [(&'static str, &'static str, f64); 4] {
        let machine = &*self.machine;
        let (encoder, drive) = (&machine.encoder, &machine.drive);
        [
            ("the sample time in s", "`loop.sample_time_s`", machine.sampling.sample_time_s()),
            (
                "the joint's angle of one count in deg",
                "`encoder.resolution_deg`, or `encoder.lines` and `gear.ratio`",
                encoder.resolution_deg(),
            ),
            (
                "the number of bits of the counter",
                "`encoder.counter_bits`",
                match encoder.core(Encoder::EXAMPLE).counter_bits {
                    CounterBits::Sixteen => 16.0,
                    CounterBits::ThirtyTwo => 32.0,
                },
            ),
            (
                "the number of codes up to full scale",
                "`drive.full_scale_v` / `drive.lsb_v`",
                drive.full_scale_v() / drive.lsb_v(),
            ),
        ]
    }
}
