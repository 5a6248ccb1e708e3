//! The proof of the encoder that arming needs after a stall, a jump, a reversal or an open line.
//!
//! ```text
//!   fault                 rests                16 counts by hand, or a jog that agrees
//!  --|- - - - in doubt - - -|- - - in doubt - - - -|------- arming is allowed
//! ```
//!
//! A command clears these faults, and a dead encoder looks like a joint at rest. A client that
//! clears, arms and repeats would push the joint a little farther each time, without end. So the
//! encoder is in doubt until one of two proofs:
//!
//! - The joint is moved by hand with the output off: the position is [`BY_HAND`] counts from where
//!   the joint rested. The count begins at rest, because one open line turns a coasting joint into
//!   counts to and fro.
//! - A [jog](crate::motion::jog) ends with the verdict that encoder and motor agree.
//!
//! Of two encoders, each needs its own proof: by hand, both count; in a jog, both agree.
//!
//! Guarantees: without a hand at the joint, a client drives a joint with a dead encoder only by
//! jogs, each within its own bounds. Noise of less than 16 counts to each side is no proof.
//!
//! Does badly: a load that moves the joint passes for a hand, and so does noise that drifts by 16
//! counts while the joint rests. Counts by hand do not show the direction; only the jog does.

use crate::safety::fault::Fault;
use crate::safety::monitor::Seen;
use crate::safety::open_loop::SLACK;

/// Distance from the place of rest that proves the encoder, counts: twice the counts that show the
/// direction in a jog, since noise of 4 counts to each side makes 8.
pub const BY_HAND: u32 = 2 * SLACK;

/// Whether the encoder is in doubt, and where the joint has rested since.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EncoderProof {
    /// The encoder is trusted.
    #[default]
    Given,
    /// The encoder is in doubt, and the joint has not rested with the output off since.
    Moving,
    /// The encoder is in doubt. The joint rested at this position, counts.
    Rested(i32),
}

impl EncoderProof {
    /// Returns whether the encoder is in doubt.
    pub const fn is_due(self) -> bool {
        !matches!(self, Self::Given)
    }

    /// Returns the state after a fault: the encoder is in doubt if the fault may come from it.
    pub const fn after(self, fault: Fault) -> Self {
        if fault.doubts_encoder() { Self::Moving } else { self.after_drive() }
    }

    /// Returns the state after the output was on. An encoder in doubt stays in doubt, and the joint
    /// has to rest again: travel under drive is no proof.
    pub const fn after_drive(self) -> Self {
        if self.is_due() { Self::Moving } else { Self::Given }
    }

    /// Updates the state with the position (counts) of a tick with the output off.
    pub const fn update(&mut self, position: i32, is_at_rest: bool) {
        match *self {
            Self::Moving if is_at_rest => *self = Self::Rested(position),
            Self::Rested(at) if position.wrapping_sub(at).unsigned_abs() >= BY_HAND => {
                *self = Self::Given;
            }
            _ => {}
        }
    }
}

/// The proofs of all encoders of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct EncoderProofs {
    /// Proof of the encoder that measures the position.
    position: EncoderProof,
    /// Proof of the motor's own encoder, if it has one.
    #[cfg(feature = "two-encoders")]
    motor: EncoderProof,
}

impl EncoderProofs {
    /// The proofs of encoders that are all in doubt.
    pub const IN_DOUBT: Self = Self::all(EncoderProof::Moving);

    const fn all(proof: EncoderProof) -> Self {
        Self {
            position: proof,
            #[cfg(feature = "two-encoders")]
            motor: proof,
        }
    }

    fn map(self, next: impl Fn(EncoderProof) -> EncoderProof) -> Self {
        Self {
            position: next(self.position),
            #[cfg(feature = "two-encoders")]
            motor: next(self.motor),
        }
    }

    /// Returns whether an encoder is in doubt.
    pub const fn is_due(self) -> bool {
        #[cfg(feature = "two-encoders")]
        if self.motor.is_due() {
            return true;
        }
        self.position.is_due()
    }

    /// Returns the proofs after a fault: each encoder is in doubt if the fault may come from it.
    pub fn after(self, fault: Fault) -> Self {
        self.map(|proof| proof.after(fault))
    }

    /// Returns the proofs after the output was on.
    pub fn after_drive(self) -> Self {
        self.map(EncoderProof::after_drive)
    }

    /// Updates the proofs with the readings of a tick with the output off.
    pub fn update(&mut self, seen: &Seen, is_at_rest: bool) {
        self.position.update(seen.position, is_at_rest);
        #[cfg(feature = "two-encoders")]
        match &seen.motor {
            Some(motor) => self.motor.update(motor.position, is_at_rest),
            None => self.motor = EncoderProof::Given,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_doubt() -> EncoderProof {
        EncoderProof::default().after(Fault::Stall)
    }

    #[test]
    fn sixteen_counts_from_the_place_of_rest_are_a_proof() {
        for way in [1, -1] {
            let mut proof = in_doubt();
            // A joint that coasts proves nothing, however far.
            proof.update(1000, false);
            proof.update(i32::MAX - 2, true);
            assert!(proof.is_due());
            proof.update((i32::MAX - 2).wrapping_add(way * 15), false);
            assert!(proof.is_due());
            proof.update((i32::MAX - 2).wrapping_add(way * 16), false);
            assert!(!proof.is_due());
        }
    }

    #[test]
    fn noise_about_the_place_of_rest_is_no_proof() {
        let mut proof = in_doubt();
        proof.update(0, true);
        for tick in 0..1000 {
            proof.update([4, -4, 15, -15][tick % 4], tick % 3 == 0);
        }
        assert!(proof.is_due());
    }

    #[test]
    fn what_the_drive_moves_is_no_proof() {
        let mut proof = in_doubt();
        proof.update(0, true);
        proof = proof.after_drive();
        proof.update(100, false);
        assert!(proof.is_due());
        proof.update(100, true);
        proof.update(110, false);
        assert!(proof.is_due());
    }

    #[test]
    fn other_faults_neither_put_the_encoder_in_doubt_nor_prove_it() {
        for &fault in Fault::ALL {
            let doubts = matches!(
                fault,
                Fault::EncoderJump
                    | Fault::Stall
                    | Fault::EncoderReversed
                    | Fault::EncoderOpen
                    | Fault::EncodersDisagree
            );
            assert_eq!(EncoderProof::Given.after(fault).is_due(), doubts, "{fault:?}");
            assert!(in_doubt().after(fault).is_due(), "{fault:?}");
        }
    }
}
