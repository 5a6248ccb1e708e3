//! The link that armed or moved the servo has fallen silent: a cable pulled, a host that hangs.
//!
//! On as soon as a link has armed, or has moved what had armed by itself, until the servo is
//! stopped. A sign of life is a new request of its session ([`crate::link`]).

use super::limits::{Limits, Units};

/// Silence against its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkTimeout {
    ticks: u32,
}

/// How long nothing was heard.
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
    /// From now on silence trips, or no longer.
    pub const fn watch(watched: bool) -> Self {
        Self { watched, silent: 0 }
    }

    /// Whether silence trips.
    pub const fn is_watched(self) -> bool {
        self.watched
    }

    /// A sign of life.
    pub const fn heard(&mut self) {
        self.silent = 0;
    }
}
