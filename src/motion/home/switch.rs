//! The homing switch: from the level of its input to the count of its edge.
//!
//! ```text
//! input     ____|~|_|~~~~~~~~~~~~~~~~|_|~|________
//! at it     ____________|~~~~~~~~~~~~~~~~~~~|_____
//! edge              ^   after `ticks` ticks of one level, from the first of them on
//! ```
//!
//! A level counts once it has been the same for `ticks` ticks in a row. The edge is the joint's
//! position in the first of these ticks, so that the filter does not shift it: the true edge is
//! between that tick and the one before. Bounces end before the first of them.
//!
//! Does badly: a contact that bounces for longer than the filter has several edges. The position
//! has the resolution of a tick: that of the speed times the sample time.

use crate::control::device_config::HomeSwitch;

/// The filter of a homing switch, with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SwitchFilter {
    /// Whether the input is high at the switch.
    is_high_at: bool,
    /// Number of ticks for which a level has to be the same.
    ticks: u32,
    /// Whether the joint is at the switch.
    is_at: bool,
    /// Number of ticks with the other level, and the position in the first of them, counts.
    other: u32,
    since: i32,
}

impl SwitchFilter {
    /// Returns the filter of a switch; none without a switch.
    pub fn of(kind: HomeSwitch, ticks: u32) -> Option<Self> {
        let is_high_at = match kind {
            HomeSwitch::None => return None,
            HomeSwitch::NormallyClosed => true,
            HomeSwitch::NormallyOpen => false,
        };
        Some(Self { is_high_at, ticks: ticks.max(1), is_at: false, other: 0, since: 0 })
    }

    /// Restarts with a joint that is not at the switch.
    pub fn restart(&mut self) {
        (self.is_at, self.other) = (false, 0);
    }

    /// Updates the filter with the level of the input and the position of a tick, counts. Returns
    /// the count of the edge at which the joint has come to the switch.
    pub fn update(&mut self, is_high: bool, counts: i32) -> Option<i32> {
        if (is_high == self.is_high_at) == self.is_at {
            self.other = 0;
            return None;
        }
        if self.other == 0 {
            self.since = counts;
        }
        self.other = self.other.saturating_add(1);
        if self.other < self.ticks {
            return None;
        }
        (self.is_at, self.other) = (!self.is_at, 0);
        self.is_at.then_some(self.since)
    }

    /// Returns whether the joint is at the switch, or may be: the level has changed, but not for
    /// long enough yet.
    pub const fn may_be_at(&self) -> bool {
        self.is_at || self.other > 0
    }

    /// Returns whether the joint is at the switch.
    pub const fn is_at(&self) -> bool {
        self.is_at
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    /// Positions count the ticks. Bounces of one and two ticks end before the third.
    #[test]
    fn the_edge_is_where_the_first_of_enough_ticks_was() {
        for (kind, at) in [(HomeSwitch::NormallyClosed, b'1'), (HomeSwitch::NormallyOpen, b'0')] {
            let mut filter = SwitchFilter::of(kind, 3).unwrap();
            let levels = b"..#..##.#####.##..##...#####";
            let edges: Vec<(i32, i32)> = levels
                .iter()
                .zip(0..)
                .filter_map(|(level, tick)| {
                    let is_high = (*level == b'#') == (at == b'1');
                    filter.update(is_high, tick).map(|edge| (tick, edge))
                })
                .collect();
            // The gaps of one and two ticks are none; that of three is.
            assert_eq!(edges, [(10, 8), (25, 23)], "{kind:?}");
            assert!(filter.is_at());
            filter.restart();
            assert!(!filter.may_be_at());
        }
        assert!(SwitchFilter::of(HomeSwitch::None, 3).is_none());
    }
}
