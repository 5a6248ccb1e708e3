//! The reference: whether the position that the servo counts is that of the joint.
//!
//! ```text
//!   reset ------> not referenced -- a command, with the joint at rest --> referenced
//!                   ^   ^       +-- a homing that has found its stop ------>  |
//!                   |   |                                                     |
//!                   |   +-- stall, jump, reversal, or another `[encoder]` ----+
//!                   +------ a homing that begins -----------------------------+
//! ```
//!
//! An incremental encoder counts travel. Where the joint stands is known once a command says so
//! ([`Servo::set_reference`]), or a [homing](crate::motion::home) has found a stop. Counts that
//! were lost or added end that, and so does an encoder that counts in another direction or unit. A
//! joint with a range of positions is driven by jogs and homings only until it is referenced, and
//! its range does not hold for them: they have travels of their own.
//!
//! With [`PositionReference::PowerOn`] the joint counts as referenced from each reset on, and only
//! another encoder and a homing without a stop end that. The range is then only as good as the
//! place of the last reset.
//!
//! Does badly: no sensor confirms the command. A load that turns the joint faster than the counter
//! follows, while the output is off, is not seen.

use super::{Refusal, Servo, State};
use crate::control::device_config::PositionReference;

/// How the position came to be known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Referenced {
    /// The position counts from the place of the last reset.
    #[default]
    AtReset,
    /// A command or a homing has set where the joint stands.
    Set,
    /// The encoder was changed, its counts are in doubt, or a homing has found no stop yet.
    No,
}

impl Servo {
    /// Returns whether the position is that of the joint.
    pub fn is_referenced(&self) -> bool {
        match self.referenced {
            Referenced::No => false,
            Referenced::Set => true,
            Referenced::AtReset => self.is_referenced_at_reset(),
        }
    }

    /// Returns the joint's zero (counts since power-on), if it is known.
    pub(super) fn known_origin(&self) -> Option<i32> {
        self.is_referenced().then_some(self.origin)
    }

    /// Says that the joint stands at `position`, counts. The output is off, and stays so: autostart
    /// ends.
    ///
    /// # Errors
    /// Refuses while the servo is armed, while the joint moves, while the encoder is in doubt, and
    /// a position of 2^30 counts and more.
    pub fn set_reference(&mut self, position: i32) -> Result<(), Refusal> {
        match self.state {
            State::Boot => return Err(Refusal::Booting),
            State::Armed => return Err(Refusal::Armed),
            State::Stopped | State::Faulted(_) => {}
        }
        if !self.is_at_rest() {
            return Err(Refusal::Moving);
        }
        if self.is_encoder_in_doubt() {
            return Err(Refusal::EncoderInDoubt);
        }
        if position.unsigned_abs() >= 1 << 30 {
            return Err(Refusal::TooFar);
        }
        // The counts since power-on go on: a shift would look like counts of a living encoder.
        self.origin = self.follower.seen.position.wrapping_sub(position);
        self.countdown = None;
        self.referenced = Referenced::Set;
        Ok(())
    }

    /// Takes counts that are in doubt.
    pub(super) fn lose_reference(&mut self) {
        if !self.is_referenced_at_reset() {
            self.referenced = Referenced::No;
        }
    }

    fn is_referenced_at_reset(&self) -> bool {
        self.control_loop
            .as_ref()
            .is_some_and(|control_loop| control_loop.reference == PositionReference::PowerOn)
    }
}
