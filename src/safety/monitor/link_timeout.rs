//! The link that armed or moved the servo has fallen silent: a cable pulled, a host that hangs.
//!
//! On from the moment when a link arms the servo, or moves a servo that armed automatically, until
//! the servo is stopped. A sign of life is a new request of its session ([`crate::link`]).

use super::limits::{Limits, Units};

/// Monitor of the link's silence.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkTimeout {
    ticks: u32,
}

/// Time of the link's silence, and whether it is watched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LinkState {
    watched: bool,
    silent: u32,
}

impl LinkTimeout {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        Self { ticks: Units::threshold(limits.link_timeout, units.tick) }
    }

    #[inline]
    pub const fn check(&self, state: &mut LinkState) -> Option<u32> {
        state.silent = state.silent.saturating_add(1);
        if state.watched && state.silent > self.ticks { Some(state.silent) } else { None }
    }
}

impl LinkState {
    /// Returns a state without silence so far. Silence trips if `watched`.
    pub const fn watch(watched: bool) -> Self {
        Self { watched, silent: 0 }
    }

    /// Returns whether silence trips.
    pub const fn is_watched(self) -> bool {
        self.watched
    }

    /// Restarts the time of silence, after a sign of life.
    pub const fn heard(&mut self) {
        self.silent = 0;
    }
}
