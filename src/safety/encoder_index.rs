//! The check of the counts by the encoder's index.
//!
//! ```text
//! index    __|~|_______________________|~|______________________|~|____
//! counts     a |<-------- N ---------->|c|<-------- N ---------->|
//!            r = c - a - N round((c - a) / N)       |r| > width + 2: counts were lost or added
//! ```
//!
//! `N` is the number of counts between two passes of the index in one sense: four times the lines
//! of an incremental encoder, in counts of the timer, however many turns of the encoder a turn of
//! the joint has. `a` is the count of the first pass after the position became known: counts that
//! are lost slowly add up in `r`.
//!
//! The tolerance follows from the width of the index. Its rising edge is at its one end in one
//! sense and at its other end in the other sense, so that two passes without a lost count are apart
//! by a multiple of `N`, or by `width` more or less. Each of the two counts can be off by one,
//! since the edges of index and lines come through filters of their own.
//!
//! A joint that has gone farther than `N + width + 2` from the last pass, or from the start of the
//! check, without another one has an encoder with false counts or without an index.
//!
//! Guarantees: with a sound index, no number of counts from `2 width + 3` to `N - 2 width - 3` is
//! lost between two passes without a report at the second one.
//!
//! Does badly: a whole multiple of `N` counts is not seen, and nor are `width + 2` counts or, if
//! both senses are used, up to `2 width + 2`. Nothing is seen before the next pass. A spike on the
//! line of the index that the filter passes is a fault, although the counts are right.

/// Largest error of the difference of two counts of the same edge.
const FLICKER: i32 = 2;

/// The check of the counts, prepared for an encoder with an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexCheck {
    /// N, counts.
    every: i32,
    /// Largest deviation, counts.
    tolerance: i32,
}

/// The state of the check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IndexState {
    /// A place of the index: that of the first pass, and whole multiples of N from it, counts.
    place: Option<i32>,
    /// The last pass, or the start of the check, counts.
    last: Option<i32>,
    /// Number of passes since the start of the check.
    passes: u32,
    /// The deviation of the last pass, counts.
    deviation: i32,
}

impl IndexState {
    /// Returns the state of a check that starts with the index at a place, if that is known.
    pub const fn start(place: Option<i32>) -> Self {
        Self { place, last: place, passes: 0, deviation: 0 }
    }

    /// Returns the number of passes of the index since the start of the check, and the deviation of
    /// the last one from a whole number of turns, counts.
    pub const fn passes(&self) -> (u32, i32) {
        (self.passes, self.deviation)
    }
}

impl IndexCheck {
    /// Prepares the check of an encoder with `every` counts between two passes of an index that is
    /// `width` counts wide; none without an index.
    pub fn of(every: u32, width: u32) -> Option<Self> {
        let (every, width) = (every.min(1 << 24) as i32, width.min(1 << 20) as i32);
        (every > 0).then_some(Self { every, tolerance: width + FLICKER })
    }

    /// Updates the check with the position of the last tick and that of a pass since then, if there
    /// was one, counts. Returns the deviation in counts if it is not within the tolerance: of the
    /// pass, or of a joint that should have passed the index by now.
    pub fn update(&self, state: &mut IndexState, position: i32, pass: Option<i32>) -> Option<i32> {
        let Some(pass) = pass else {
            let last = *state.last.get_or_insert(position);
            let way = position.wrapping_sub(last);
            let is_missed = way.unsigned_abs() > (self.every + self.tolerance).unsigned_abs();
            return is_missed.then_some(way);
        };
        let place = state.place.unwrap_or(pass);
        // N is positive, so that neither division can fail.
        let ahead = pass.wrapping_sub(place).checked_rem_euclid(self.every).unwrap_or(0);
        let deviation = if ahead > self.every / 2 { ahead - self.every } else { ahead };
        // The place moves along: a difference of places that are far apart would wrap.
        state.place = Some(pass.wrapping_sub(deviation));
        state.last = Some(pass);
        (state.passes, state.deviation) = (state.passes.saturating_add(1), deviation);
        (deviation.abs() > self.tolerance).then_some(deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVERY: i32 = 4000;
    const WIDTH: i32 = 4;

    fn check() -> IndexCheck {
        IndexCheck::of(EVERY as u32, WIDTH as u32).unwrap()
    }

    /// Passes in both senses, over the wrap of the counts, with a flicker of a count each.
    #[test]
    fn passes_of_an_index_with_a_width_are_no_deviation_in_either_sense() {
        let mut state = IndexState::default();
        let start = i32::MAX - 2 * EVERY;
        for turn in [0, 1, 2, 3, 3, 2, 1, 0, -1, -2, -2, -1, 0] {
            for edge in [0, WIDTH, -1, WIDTH + 1] {
                let pass = start.wrapping_add(turn * EVERY + edge);
                assert_eq!(check().update(&mut state, pass, Some(pass)), None, "{turn}, {edge}");
            }
        }
        assert_eq!(state.passes(), (52, WIDTH + 1));
    }

    /// The first pass is at zero: the deviation of a later one is what was lost until then.
    #[test]
    fn counts_that_are_lost_slowly_add_up_to_a_deviation() {
        let mut state = IndexState::default();
        let found = (0..20).find_map(|turn| {
            let pass = turn * (EVERY - 1);
            check().update(&mut state, pass, Some(pass)).map(|deviation| (turn, deviation))
        });
        // One count a turn: seven are one more than the width and two.
        assert_eq!(found, Some((7, -7)));
        for (added, expected) in [(6, None), (7, Some(7)), (-7, Some(-7)), (1999, Some(1999))] {
            let mut state = IndexState::start(Some(0));
            let pass = 3 * EVERY + added;
            assert_eq!(check().update(&mut state, pass, Some(pass)), expected, "{added}");
        }
    }

    #[test]
    fn a_turn_without_an_index_is_a_deviation_from_wherever_the_check_starts() {
        for sense in [-1, 1] {
            let mut state = IndexState::default();
            assert_eq!(check().update(&mut state, 500, None), None);
            let farthest = EVERY + WIDTH + 2;
            assert_eq!(check().update(&mut state, 500 + sense * farthest, None), None);
            let beyond = sense * (farthest + 1);
            assert_eq!(check().update(&mut state, 500 + beyond, None), Some(beyond));
            // A pass restarts the way.
            let pass = 500 + beyond;
            assert_eq!(check().update(&mut state, pass, Some(pass)), None);
            assert_eq!(check().update(&mut state, pass + sense * farthest, None), None);
        }
        assert!(IndexCheck::of(0, 4).is_none());
    }
}
