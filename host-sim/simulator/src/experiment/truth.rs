//! The true joint of a simulated device, if it differs from that of the machine's file.
//!
//! Both files must agree in encoder, drive and sample time, which are properties of the device;
//! otherwise they are refused. Motor, gear, load, friction, and the voltage of a code belong to the
//! plant and can differ.

use stiction::control::encoder::{CounterBits, Encoder};
use stiction::units::value::Table as _;

use super::plan::RunPlan;
use files::error::{Error, rounded};

/// Relative difference up to which two values of a device are equal: a file pulled from a device is
/// in single precision, and the voltage of a code has five digits.
const SAME: f64 = 1e-4;

impl RunPlan {
    /// Returns this plan with the plant of `truth`. The parameters of a device stay those of this
    /// plan.
    ///
    /// # Errors
    /// Returns an error with the value of the device that differs in `truth`.
    pub fn with_truth(self, truth: Self) -> Result<Self, Error> {
        let own = self.of_the_device();
        for ((what, key, found), (.., believed)) in truth.of_the_device().into_iter().zip(own) {
            if (found - believed).abs() > SAME * believed.abs() {
                return Err(Error::Input(format!(
                    "--truth {}: {what} ({key}) is {}, but {} in {}; it belongs to the device and \
                     must be the same in both files",
                    truth.origin,
                    rounded(found),
                    rounded(believed),
                    self.origin,
                )));
            }
        }
        Ok(Self { truth: Some(Box::new(truth)), ..self })
    }

    /// Returns the values that belong to the device, with their keys.
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
