//! Levels of the twist, which two encoders show for a gear of unknown slack and stiffness.
//!
//! The twist is `w = y - l`, the motor's position less the load's, both in deg of the joint. The
//! load's friction holds the load while `w` is within a range, and releases it at either end. The
//! middle of that range is the twist without torque, the neutral twist `N`.
//!
//! ```text
//! motor and load have rested for N_q ticks:  w_hi = max(w_hi, w),  w_lo = min(w_lo, w)
//! first count of the load after a rest:     forwards   d_hi = min(d_hi, largest w since the rest)
//!                                           backwards  d_lo = max(d_lo, smallest w since the rest)
//! N = clamp(N, (w_hi + d_lo) / 2, (d_hi + w_lo) / 2)        0 at arming
//! S = max(W+ - W-, w_hi - w_lo) / 2
//! ```
//!
//! A twist at which the load rests is within the range, one at which it leaves is not. So the upper
//! end lies between `w_hi` and `d_hi`, the lower one between `d_lo` and `w_lo`, and their middle
//! within the bounds of the third line. `W+` and `W-` are the twists at which a bump is expected to
//! move the load ([`bump_memory`](super::bump_memory)); they cover `w_hi` and `w_lo`. `S` is half
//! the width of the range.
//!
//! A new motion ends at another place with another friction. So at its start `w_hi` and `w_lo` move
//! towards `N`, and `d_hi` and `d_lo` away from it, each by a tenth of its distance, so that a
//! later observation can correct it.
//!
//! Guarantees: `w_hi <= d_hi` and `d_lo <= w_lo` after every tick. Does badly: friction that
//! depends on the place makes the range another one at each place, and `N` the middle of all; a
//! wrong ratio of the encoders turns the way of the joint into twist.

/// The ticks of rest that a level needs, and its first value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwistLevels {
    /// Ticks for which both sides have to rest, N_q.
    rest_ticks: u16,
    /// Twist at which a bump is assumed to move the load, before any bump was seen, deg.
    first: f32,
}

/// The levels after the last tick, deg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TwistState {
    /// Neutral twist N.
    pub neutral: f32,
    /// Twists W- and W+ at which a bump moves the load: backwards and forwards.
    pub breakaway: [f32; 2],
    /// Whether a bump has shown each of these twists.
    pub is_seen: [bool; 2],
    /// Smallest and largest twist at which both sides have rested, w_lo and w_hi.
    rested: [f32; 2],
    /// Twists at which the load has left its rest, d_lo and d_hi; infinite: it has not yet.
    left: [f32; 2],
    /// Smallest and largest twist since the last rest.
    extremes: [f32; 2],
    /// Position of the load at its last rest.
    load_rested: f32,
    /// Whether the load has left that rest.
    has_left: bool,
}

/// Inputs of a tick, from both sides.
#[derive(Clone, Copy, Debug)]
pub struct BothSides {
    /// Twist w, deg.
    pub twist: f32,
    /// Position of the load, and its mean at rest, deg.
    pub load: [f32; 2],
    /// Ticks for which motor and load have rested.
    pub rested_ticks: [u16; 2],
    /// Whether the load has rested for as long as the law requires of a rest.
    pub load_rests: bool,
}

impl TwistLevels {
    /// Prepares the levels: the ticks of rest, and half the width of the range that is assumed at
    /// first (deg).
    pub const fn new(rest_ticks: u16, first: f32) -> Self {
        Self { rest_ticks, first }
    }

    /// Returns the initial levels, for an unknown gear.
    pub fn start(&self) -> TwistState {
        TwistState {
            breakaway: [-self.first, self.first],
            left: [f32::NEG_INFINITY, f32::INFINITY],
            ..TwistState::default()
        }
    }

    /// Updates the levels with one tick.
    #[inline]
    pub fn update(&self, levels: &mut TwistState, seen: &BothSides) {
        let BothSides {
            twist, load: [load, mean], rested_ticks: [motor_ticks, load_ticks], ..
        } = *seen;
        if motor_ticks >= self.rest_ticks && load_ticks >= self.rest_ticks {
            levels.rest_at(twist);
        } else if !levels.has_left {
            let [smallest, largest] = &mut levels.extremes;
            *smallest = smallest.min(twist);
            *largest = largest.max(twist);
            if load_ticks == 0 {
                levels.has_left = true;
                let [backwards, forwards] = &mut levels.left;
                if load > levels.load_rested {
                    *forwards = forwards.min(*largest);
                } else {
                    *backwards = backwards.max(*smallest);
                }
            }
        }
        if seen.load_rests {
            levels.load_rested = mean;
        }
        let [lowest, highest] = levels.rested;
        let [backwards, forwards] = &mut levels.left;
        *forwards = forwards.max(highest);
        *backwards = backwards.min(lowest);
        let (least, most) = (0.5 * (highest + *backwards), 0.5 * (*forwards + lowest));
        levels.neutral = if least > most {
            0.5 * (least + most)
        } else {
            // Not `clamp`, which panics where a bound is not a number.
            levels.neutral.max(least).min(most)
        };
    }
}

impl TwistState {
    /// Returns half the width S of the range of twists that the load's friction holds, deg.
    #[inline]
    pub fn half_width(&self) -> f32 {
        let [lowest, highest] = self.rested;
        let [backwards, forwards] = self.breakaway;
        0.5 * (forwards - backwards).max(highest - lowest)
    }

    /// Returns the least twist of a bump forwards or backwards, if the load has left its rest in
    /// that direction: 97 % of the way from the neutral twist to where it did.
    pub fn least_peak(&self, forward: bool) -> Option<f32> {
        let left = self.left[usize::from(forward)];
        left.is_finite().then_some(self.neutral + 0.97 * (left - self.neutral))
    }

    /// Moves the levels by a tenth, so that observations at another place can correct them.
    pub fn ease(&mut self) {
        let neutral = self.neutral;
        self.rested.iter_mut().for_each(|level| *level -= 0.1 * (*level - neutral));
        for level in self.left.iter_mut().filter(|level| level.is_finite()) {
            *level += 0.1 * (*level - neutral);
        }
    }

    /// Keeps the breakaway twists on their sides of the neutral one.
    pub fn order(&mut self) {
        let [backwards, forwards] = &mut self.breakaway;
        *forwards = forwards.max(self.neutral);
        *backwards = backwards.min(self.neutral);
    }

    /// Moves the origins of both sides: `load` is the move of the load's origin, and `twist` the
    /// change of every twist, deg.
    pub fn rebase(&mut self, load: f32, twist: f32) {
        self.load_rested -= load;
        self.neutral += twist;
        let levels = [&mut self.breakaway, &mut self.rested, &mut self.left, &mut self.extremes];
        levels.into_iter().flatten().for_each(|level| *level += twist);
    }

    /// Updates the levels with a twist at which both sides rest.
    fn rest_at(&mut self, twist: f32) {
        let [backwards, forwards] = &mut self.breakaway;
        let mirrored = 2.0 * self.neutral - twist;
        if twist > self.rested[1] {
            self.rested[1] = twist;
            if twist > *forwards {
                *forwards = twist;
                if !self.is_seen[0] {
                    *backwards = backwards.min(mirrored);
                }
            }
        }
        if twist < self.rested[0] {
            self.rested[0] = twist;
            if twist < *backwards {
                *backwards = twist;
                if !self.is_seen[1] {
                    *forwards = forwards.max(mirrored);
                }
            }
        }
        self.extremes = [twist; 2];
        self.has_left = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVELS: TwistLevels = TwistLevels::new(20, 4.0);

    /// Runs ticks in which both sides rest at the twist `rests`, and the load then leaves its rest
    /// at the twist `leaves`, both deg.
    fn rest_and_leave(levels: &mut TwistState, rests: f32, leaves: f32) {
        let seen = |twist, load, ticks| BothSides {
            twist,
            load: [load, 0.0],
            rested_ticks: [ticks; 2],
            load_rests: ticks > 0,
        };
        LEVELS.update(levels, &seen(rests, 0.0, 20));
        let step = leaves.signum();
        LEVELS.update(levels, &seen(leaves, step, 0));
        // Ticks after the first count have no effect on the level.
        LEVELS.update(levels, &seen(10.0 * leaves, 5.0 * step, 0));
    }

    /// A gear that releases its load at -30 and at 50 has its neutral twist at 10.
    #[test]
    fn neutral_twist_is_the_middle_of_where_the_load_leaves() {
        let mut levels = LEVELS.start();
        assert_eq!((levels.neutral, levels.half_width()), (0.0, 4.0));
        rest_and_leave(&mut levels, 49.0, 50.0);
        // The lower end is unknown: 0 is still possible.
        assert_eq!(levels.neutral, 0.0);
        rest_and_leave(&mut levels, -29.0, -30.0);
        // Between (49 - 30) / 2 and (50 - 29) / 2.
        assert_eq!(levels.neutral, 9.5);
        assert_eq!(levels.half_width(), 49.0, "W- was mirrored at the neutral twist of that time");
        assert_eq!(levels.least_peak(true), Some(9.5 + 0.97 * 40.5));
    }

    #[test]
    fn load_that_rested_there_rules_out_that_it_leaves_earlier() {
        let mut levels = LEVELS.start();
        rest_and_leave(&mut levels, 0.0, 20.0);
        assert_eq!(levels.left[1], 20.0);
        rest_and_leave(&mut levels, 30.0, 31.0);
        assert_eq!(levels.left[1], 30.0, "the smaller one of the two, but where it has rested");
        assert_eq!(levels.least_peak(false), None, "it has never left backwards");
    }

    #[test]
    fn eased_levels_move_a_tenth_and_unseen_ones_stay_unseen() {
        let mut levels = LEVELS.start();
        rest_and_leave(&mut levels, 10.0, 20.0);
        levels.ease();
        assert_eq!((levels.rested[1], levels.left), (9.0, [f32::NEG_INFINITY, 22.0]));
    }

    #[test]
    fn other_origins_change_no_twist_but_by_their_own_difference() {
        let mut levels = LEVELS.start();
        rest_and_leave(&mut levels, 10.0, 20.0);
        rest_and_leave(&mut levels, -10.0, -20.0);
        let mut moved = levels;
        moved.rebase(1000.0, 0.25);
        assert_eq!(moved.neutral - levels.neutral, 0.25);
        assert_eq!(moved.half_width(), levels.half_width());
        assert_eq!(moved.load_rested, levels.load_rested - 1000.0);
    }
}
