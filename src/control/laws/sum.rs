//! The sum of laws that a controller adds to its PD loop, or the one law that replaces PD.

use heapless::Vec;

use super::{Alone, AloneState, Gains, LawInput, LawState, Loop, MAX_TERMS, PreparedLaw, Robust};
use crate::control::signal::MAX_LAW_SIGNALS;

/// A sum of laws; the empty sum is plain PD.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compensator {
    terms: Vec<PreparedLaw, MAX_TERMS>,
    /// The law that is too large for a sum, if that law is configured.
    alone: Option<Alone>,
    /// Whether the law replaces PD, stored so that a tick does not have to look it up.
    replaces_pd: bool,
    /// Whether a law publishes signals of its own.
    publishes: bool,
}

/// The states of a sum's laws from tick to tick. The law that is too large for a sum has a place of
/// its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatorState {
    terms: [LawState; MAX_TERMS],
    alone: AloneState,
}

impl Default for CompensatorState {
    fn default() -> Self {
        Self {
            terms: [LawState::None; MAX_TERMS],
            alone: AloneState::Robust(<Robust as super::Law>::State::default()),
        }
    }
}

impl CompensatorState {
    /// Resets the states of the laws, in place.
    pub(crate) fn forget(&mut self) {
        self.terms.fill(LawState::None);
        self.alone.forget();
    }

    /// Called when a motion starts. Only the law that is too large for a sum can give up.
    pub(crate) fn begin_motion(&mut self) {
        self.alone.begin_motion();
    }
}

impl Compensator {
    /// Prepares the sum for a loop. The gains have been validated.
    pub fn new(gains: &Vec<Gains, MAX_TERMS>, around: &Loop) -> Self {
        let mut terms = Vec::new();
        for law in gains.iter().filter_map(|gains| PreparedLaw::new(gains, around)) {
            // Cannot fail: both vectors have the same capacity.
            let _ = terms.push(law);
        }
        let alone = gains.first().and_then(|gains| Alone::new(gains, around));
        let replaces_pd = gains.first().is_some_and(Gains::replaces_pd);
        let publishes = gains.iter().any(|gains| !gains.signals().is_empty());
        Self { terms, alone, replaces_pd, publishes }
    }

    /// Returns the state that the sum starts from.
    pub fn rest(&self) -> CompensatorState {
        let mut state = CompensatorState::default();
        if let Some(law) = &self.alone {
            state.alone = law.rest();
        }
        for (law, state) in self.terms.iter().zip(&mut state.terms) {
            *state = law.rest();
        }
        state
    }

    /// Resets the state of each law of the sum to that of a joint at rest.
    pub fn begin_anew(&self, state: &mut CompensatorState) {
        for (law, state) in self.terms.iter().zip(&mut state.terms) {
            *state = law.rest();
        }
        state.alone.forget();
    }

    /// Returns whether the law replaces PD.
    #[inline]
    pub const fn replaces_pd(&self) -> bool {
        self.replaces_pd
    }

    /// Returns the sum's v_c for one tick, V.
    #[inline]
    pub fn update(&self, state: &mut CompensatorState, input: &LawInput) -> f32 {
        // This check costs the sums nothing: their loop checks whether it is empty, anyway.
        if self.terms.is_empty() {
            return self.alone.as_ref().map_or(0.0, |law| law.update(&mut state.alone, input));
        }
        let mut v_c = 0.0;
        for (law, state) in self.terms.iter().zip(&mut state.terms) {
            v_c += law.update(state, input);
        }
        v_c
    }

    /// Returns whether the law has ended its attempts to reach the set point. Only the law that is
    /// too large for a sum makes attempts.
    #[inline]
    pub fn has_given_up(&self, state: &CompensatorState) -> bool {
        self.alone.as_ref().is_some_and(|law| law.has_given_up(&state.alone))
    }

    /// Returns the values of the signals of the first law that publishes any.
    #[inline]
    pub fn signals(&self, state: &CompensatorState) -> Option<[f32; MAX_LAW_SIGNALS]> {
        if !self.publishes {
            return None;
        }
        if let Some(law) = &self.alone {
            return law.signals(&state.alone);
        }
        self.terms.iter().zip(&state.terms).find_map(|(law, state)| law.signals(state))
    }
}
