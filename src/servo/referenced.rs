//! The reference: whether the position that the servo counts is the true position of the joint.
//!
//! ```text
//!   reset ------> not referenced -- a command, with the joint at rest --> referenced
//!                   ^   ^       +-- a homing that has found its stop ------>  |
//!                   |   |                                                     |
//!                   |   +-- stall, jump, reversal, silence, index, encoder ----+
//!                   +------ a homing that begins -----------------------------+
//! ```
//!
//! An absolute encoder on the load sets the reference by its angle (`servo/absolute_load.rs`). An
//! incremental encoder counts only travel. The position of the joint is known once a command has
//! set it ([`Servo::set_reference`]) or a [homing](crate::motion::home) has found a stop. The
//! reference ends when counts may be lost or added, or when the encoder's configuration changes,
//! such as its direction or unit. Until a joint with a range of positions is referenced, only jogs
//! and homings drive it. The range does not apply to them: they have their own limits of travel.
//!
//! With [`PositionReference::PowerOn`] the joint counts as referenced from each reset on. Only a
//! changed encoder, counts that differ from the encoder's index, or a homing without a place end
//! this. The range is then only as accurate as the
//! position of the joint at the reset. It has no effect on a joint with a range and an absolute
//! encoder on its load, whose angle is the reference (`servo/absolute_load.rs`).
//!
//! Does badly: no sensor confirms the command. If a load turns the joint faster than the counter
//! can follow while the output is off, the lost counts are not detected.

use super::{Refusal, Servo, State};
use crate::control::device_config::PositionReference;

/// Source of the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Referenced {
    /// The position counts from the place of the last reset.
    #[default]
    AtReset,
    /// A command or a homing has set the position of the joint.
    Set,
    /// The encoder was changed, its counts are in doubt, or a homing has found no stop yet.
    No,
}

impl Servo {
    /// Returns whether the joint is referenced: the counted position is the true one.
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

    /// Sets the present position of the joint to `position`, counts. Autostart ends, so the output
    /// stays off.
    ///
    /// # Errors
    /// Refuses before the first tick, while the servo is armed, while the joint moves, and while
    /// the encoder is in doubt. Also refuses a position of 2^30 counts or more.
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
        // Only the origin moves: a shift of the counts would look like counts of a working encoder.
        self.origin = self.follower.seen.position.wrapping_sub(position);
        self.countdown = None;
        self.referenced = Referenced::Set;
        self.restart_index(None);
        Ok(())
    }

    /// Ends the reference, because counts are in doubt. With [`PositionReference::PowerOn`] it
    /// stays.
    pub(super) fn lose_reference(&mut self) {
        if !self.is_referenced_at_reset() {
            self.referenced = Referenced::No;
        }
    }

    /// Ends the reference after a time without ticks in which the reading of the load's encoder may
    /// have passed half of its range: a counter of 16 bits, or a turn of an absolute encoder.
    /// `motor_counts` is the motor's travel meanwhile. A board with such an encoder calls this
    /// before the ticks go on.
    #[cfg(feature = "two-encoders")]
    pub fn check_pause(&mut self, motor_counts: i32) {
        let Some(control_loop) = &self.control_loop else { return };
        let Some(motor) = control_loop.controller.motor_encoder() else { return };
        let load = control_loop.controller.encoder().resolution;
        // A quarter of the range: the load may be ahead of the motor by slack and twist.
        let quarter = if control_loop.absolute.is_some() { 4_096.0 } else { 16_384.0 };
        let most = quarter * load;
        if (motor_counts as f32).abs() * motor.resolution > most {
            self.referenced = Referenced::No;
        }
    }

    fn is_referenced_at_reset(&self) -> bool {
        self.control_loop.as_ref().is_some_and(|control_loop| {
            control_loop.reference == PositionReference::PowerOn && !control_loop.has_angle()
        })
    }
}
