//! The follower: it keeps the position and standstill of the joint, whether or not the loop is
//! closed.

use super::Input;
use crate::control::encoder::{Encoder, EncoderState};
#[cfg(feature = "two-encoders")]
use crate::safety::monitor::SeenMotor;
use crate::safety::monitor::{Seen, Standstill};

/// Position and standstill of the joint, and reading of the supply, in the last tick, armed or not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Follower {
    /// The encoder's state; none before the first tick.
    pub encoder: Option<EncoderState>,
    pub standstill: Standstill,
    pub seen: Seen,
    pub supply: u16,
    /// Position of the motor, if it has its own encoder.
    #[cfg(feature = "two-encoders")]
    pub motor: Option<MotorFollower>,
}

/// Position and standstill of a motor with its own encoder.
#[cfg(feature = "two-encoders")]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotorFollower {
    standstill: Standstill,
    pub seen: SeenMotor,
}

impl Follower {
    /// Updates the position of the motor for the next tick, counts since power-on.
    #[cfg(feature = "two-encoders")]
    pub fn see_motor(&mut self, position: i32) {
        let seen = SeenMotor { position, ..SeenMotor::default() };
        let first = MotorFollower { seen, ..MotorFollower::default() };
        let of_motor = self.motor.get_or_insert(first);
        of_motor.seen = SeenMotor {
            travel: position.wrapping_sub(of_motor.seen.position),
            position,
            standstill: of_motor.standstill.update(position),
        };
    }

    #[inline]
    pub fn update(&mut self, encoder: &Encoder, input: Input) {
        let state =
            self.encoder.get_or_insert(EncoderState::start(input.counter, self.seen.position));
        let travel = encoder.update(state, input.counter);
        let position = state.counts();
        self.seen = Seen {
            travel,
            position,
            standstill: self.standstill.update(position),
            #[cfg(feature = "two-encoders")]
            motor: self.motor.map(|of_motor| of_motor.seen),
        };
        self.supply = input.supply;
    }
}
