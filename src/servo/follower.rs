//! The follower of the joint: it knows where the joint is, whether or not the loop is closed.

use super::Input;
use crate::control::encoder::{Encoder, EncoderState};
use crate::safety::monitor::{Seen, Standstill};

/// The position of the joint, its rest and the supply, as of the last tick, armed or not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Follower {
    /// The encoder's state; none before the first tick.
    pub encoder: Option<EncoderState>,
    pub standstill: Standstill,
    pub seen: Seen,
    pub supply: u16,
}

impl Follower {
    #[inline]
    pub fn update(&mut self, encoder: &Encoder, input: Input) {
        let state =
            self.encoder.get_or_insert(EncoderState::start(input.counter, self.seen.position));
        let travel = encoder.update(state, input.counter);
        let position = state.counts();
        self.seen = Seen { travel, position, standstill: self.standstill.update(position) };
        self.supply = input.supply;
    }
}
