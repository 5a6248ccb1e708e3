//! The servo's part of an absolute encoder on the load: the reference from its angle, and the fault
//! of one that does not answer.
//!
//! ```text
//! valid answer, not referenced -> the one position of the range with that angle -> referenced
//! no valid answer              -> the load's position stays; after 5 ticks or 5 ms a fault
//! ```
//!
//! The position is known if the range of positions (`limits.position_min_deg`, `position_max_deg`)
//! is less than a turn of the encoder. Without a range, or with a wider one, the number of turns is
//! unknown, and the joint stays unreferenced; so it does outside of its range. A counted position
//! outside of the range is located anew once the output is off.
//!
//! After power-on the chip has a tenth of a second to become ready.
//!
//! Does badly: the range is believed. A joint that can turn beyond it by the rest of a turn is
//! located at a wrong place, so its hard stops must be less than a turn apart. While answers are
//! missing, the law sees a load that stands still. The first answer then has the travel of all
//! missed ticks, for which the monitor of jumps allows.

use super::{Servo, State};
use crate::control::controller::ControllerConfig;
use crate::control::motor_encoder::{LoadEncoderKind, MotorEncoder};
use crate::load_encoder::{AbsoluteEncoder, as5047p};
use crate::safety::fault::{Fault, LatchedFault};
use crate::servo::referenced::Referenced;

/// Ticks in a row without a valid answer that are a fault: at most these, and at least the second
/// number. Between them, it is the time below.
const MISSING: [u32; 2] = [5, 2];

/// Time without a valid answer that is a fault, s: five ticks of the usual millisecond.
const MISSING_S: f32 = 0.005;

/// Time after power-on within which no answer is expected, s: ten times the 10 ms that the chip
/// needs at most.
const READY_S: f32 = 0.1;

/// An absolute encoder on the load, prepared for a loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct AbsoluteLoad {
    pub encoder: AbsoluteEncoder,
    /// Ticks in a row without a valid answer that are a fault.
    missing: u32,
    /// Ticks within which the first valid answer has to come.
    ready: u32,
}

impl AbsoluteLoad {
    /// Prepares the encoder; `None` if the load's encoder is not an absolute one.
    pub fn of(config: &ControllerConfig) -> Option<Self> {
        let MotorEncoder { load_kind, load_zero, .. } = config.motor;
        config.motor.count().filter(|_| load_kind == LoadEncoderKind::As5047p)?;
        let encoder = AbsoluteEncoder::new(as5047p::BITS, config.encoder.direction, load_zero)?;
        let ticks = |s: f32| libm::ceilf(s / config.sample_time) as u32;
        let [most, least] = MISSING;
        let missing = ticks(MISSING_S).max(least).min(most);
        Some(Self { encoder, missing, ready: ticks(READY_S) })
    }
}

impl Servo {
    /// Returns whether the load's encoder is the absolute one on the bus, of a joint with two.
    pub const fn has_absolute_load(&self) -> bool {
        match &self.control_loop {
            Some(control_loop) => control_loop.absolute.is_some(),
            None => false,
        }
    }

    /// Returns the reading of an absolute encoder on the load, counts within its turn; `None`
    /// without one, or if it did not answer in the last tick.
    pub const fn load_angle(&self) -> Option<u16> {
        match &self.follower.encoder {
            Some(state) if self.has_absolute_load() && self.follower.missing == 0 => {
                Some((state.counter() & ((1 << as5047p::BITS) - 1)) as u16)
            }
            _ => None,
        }
    }

    /// Checks the answers of an absolute encoder in a tick, and sets the reference from its angle
    /// when the output is off.
    // Only joints with such an encoder come here.
    #[inline(never)]
    pub(super) fn check_absolute_load(&mut self) {
        let Some(control_loop) = &self.control_loop else { return };
        let Some(absolute) = &control_loop.absolute else { return };
        let missing = self.follower.missing;
        let Some(state) = &self.follower.encoder else {
            if missing == absolute.ready {
                self.latch_missing(missing);
            }
            return;
        };
        if missing > 0 {
            let most = absolute.missing;
            if missing == most {
                self.latch_missing(missing);
            }
            if missing >= most {
                self.referenced = Referenced::No;
            }
            return;
        }
        if self.state == State::Armed {
            return;
        }
        let position = self.follower.seen.position;
        let is_inside = !control_loop.monitors.range(Some(self.origin)).check(position);
        if self.referenced == Referenced::Set && is_inside {
            return;
        }
        let encoder = &absolute.encoder;
        let angle = state.counter() & ((1 << as5047p::BITS) - 1);
        let [lowest, highest] = control_loop.monitors.range_counts();
        if let Ok(position) = encoder.locate(angle, lowest, highest)
            && !self.is_encoder_in_doubt()
        {
            self.origin = self.follower.seen.position.wrapping_sub(position);
            self.referenced = Referenced::Set;
        }
    }

    /// Latches the fault of an encoder that has not answered for a number of ticks. The reference
    /// ends with it: the load may have moved by more than half a turn until it answers again.
    #[cold]
    fn latch_missing(&mut self, ticks: u32) {
        let (fault, tick, value) = (Fault::EncoderSilent, self.clock, ticks as f32);
        self.latch(LatchedFault { fault, tick, value });
    }
}
