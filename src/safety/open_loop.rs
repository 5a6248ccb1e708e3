//! The bounded open loop: it passes an effort on only while the joint stays within its bounds.
//!
//! ```text
//! effort of this tick -> |effort|            <= effort   -+
//! position            -> |position - start|  <= travel    +-> the effort, or what ends it
//!                     -> travel in any time t <= speed t + 8 counts
//!                     -> ticks               <= ticks    -+
//! ```
//!
//! An identification sets an effort for each tick: a ramp, a step, a sum of sines. No law runs
//! meanwhile, and neither the encoder's direction nor the friction is known. So the device, not a
//! client, checks the bounds in each tick.
//!
//! The speed is bounded by a cumulative sum (Page, *Continuous Inspection Schemes*, Biometrika 41,
//! 1954), one for each direction: it adds up the travel beyond the bound, and never falls below
//! zero. The sum exceeds 8 counts exactly if the joint has travelled by more than `speed t + 8
//! counts` in some time `t` that ends now. So a single count in a tick, which may be many deg/s at
//! a short sample time, does not exceed the bound. A true excess is detected at the first count
//! that shows it.
//!
//! Guarantees: the effort is never more than its bound. When the loop ends, the joint is at most
//! the travel of one tick beyond the bound that ended it. The loop ends after [`Bounds::ticks`] at
//! the latest.
//!
//! Does badly: it relies on the encoder. With a dead encoder, only effort and time bound the
//! travel; the monitors of the servo stay on for that reason.

/// Travel beyond the speed's bound that still counts as noise, counts: twice the travel that a
/// joint at rest may show ([`crate::safety::monitor::Standstill`]).
pub const SLACK: u32 = 8;

/// Travel beyond the speed's bound above which [`OpenLoopState::drives_on`] returns true, counts: a
/// slower joint shows as much by a single count. The rest of the slack is for the travel while the
/// joint slows down.
const LETS_GO: f32 = 1.0;

/// The bounds of an open loop, in the units of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest effort either way, V.
    pub effort: f32,
    /// Largest distance from the start, counts.
    pub travel: u32,
    /// Largest speed either way, counts a tick.
    pub speed: f32,
    /// Longest time, ticks.
    pub ticks: u32,
}

/// The bound that ended an open loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// The joint went farther than it may.
    Travel,
    /// The joint was faster than it may be.
    Speed,
    /// The time is over.
    Time,
    /// The requested effort was larger than its bound.
    Effort,
}

/// The state of an open loop from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenLoopState {
    elapsed: u32,
    /// Position at the start, counts.
    start: i32,
    /// Present position, counts.
    counts: i32,
    /// Travel beyond the speed's bound, up and down, counts.
    beyond: [f32; 2],
}

impl OpenLoopState {
    /// Returns the state of a loop that begins with the joint at `counts`.
    pub const fn start(counts: i32) -> Self {
        Self { elapsed: 0, start: counts, counts, beyond: [0.0; 2] }
    }

    /// Restarts the sum of the travel beyond the speed's bound, for a joint at rest.
    pub(crate) const fn rests(&mut self) {
        self.beyond = [0.0; 2];
    }

    /// Returns the distance from the start, counts.
    pub const fn distance(&self) -> u32 {
        self.counts.wrapping_sub(self.start).unsigned_abs()
    }

    /// Returns whether an effort drives the joint further beyond the speed's bound, which it has
    /// exceeded at the last admitted position. An identification then applies no effort: the joint
    /// has broken free under its full breakaway effort, and friction may slow it down before the
    /// slack is used up. This does not work for every joint: docs/how-to/identify.md has the share
    /// that ends by the bound.
    ///
    /// ```
    /// use stiction::safety::open_loop::{Bounds, OpenLoopState};
    /// let bounds = Bounds { effort: 1.0, travel: 100, speed: 2.0, ticks: 1000 };
    /// let mut state = OpenLoopState::start(0);
    /// bounds.admit(&mut state, 3, 1.0).unwrap(); // a count too many
    /// assert!(!state.drives_on(1.0));
    /// bounds.admit(&mut state, 6, 1.0).unwrap(); // two
    /// assert!(state.drives_on(1.0) && !state.drives_on(-1.0));
    /// ```
    pub fn drives_on(&self, effort: f32) -> bool {
        let [up, down] = self.beyond;
        (if effort > 0.0 { up } else { down }) > LETS_GO
    }
}

impl Bounds {
    /// Checks the joint's position (counts) and the effort (V) requested from now on, and returns
    /// that effort. Must be called once a tick.
    ///
    /// ```
    /// use stiction::safety::open_loop::{Bound, Bounds, OpenLoopState};
    /// let bounds = Bounds { effort: 1.0, travel: 100, speed: 2.0, ticks: 1000 };
    /// let mut state = OpenLoopState::start(-7);
    /// assert_eq!(bounds.admit(&mut state, -7, 0.5), Ok(0.5));
    /// assert_eq!(bounds.admit(&mut state, 3, -1.0), Ok(-1.0)); // 10 counts: 2 and the slack
    /// assert_eq!(bounds.admit(&mut state, 6, 0.5), Err(Bound::Speed));
    /// assert_eq!(bounds.admit(&mut state, 6, 1.5), Err(Bound::Effort));
    /// ```
    ///
    /// # Errors
    /// Returns the bound that ends the loop. The motion's bounds are checked first: after
    /// [`Bound::Effort`] the caller may request a smaller effort.
    pub fn admit(&self, state: &mut OpenLoopState, counts: i32, effort: f32) -> Result<f32, Bound> {
        let travel = counts.wrapping_sub(state.counts) as f32;
        state.counts = counts;
        state.elapsed = state.elapsed.saturating_add(1);
        let [up, down] = state.beyond;
        state.beyond = [(up + travel - self.speed).max(0.0), (down - travel - self.speed).max(0.0)];
        if state.distance() > self.travel {
            return Err(Bound::Travel);
        }
        if state.beyond.iter().any(|beyond| *beyond > SLACK as f32) {
            return Err(Bound::Speed);
        }
        if state.elapsed > self.ticks {
            return Err(Bound::Time);
        }
        // NaN is within no bound.
        if effort.abs() <= self.effort { Ok(effort) } else { Err(Bound::Effort) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { effort: 0.5, travel: 200, speed: 0.3, ticks: 400 };

    /// Runs a joint that is at `counts(tick)`, and returns the tick that ends the loop and the
    /// bound.
    fn ended(bounds: &Bounds, counts: impl Fn(u32) -> i32) -> (u32, Bound) {
        let mut state = OpenLoopState::start(counts(0));
        (1..10_000)
            .find_map(|tick| {
                bounds.admit(&mut state, counts(tick), 0.5).err().map(|bound| (tick, bound))
            })
            .unwrap()
    }

    #[test]
    fn each_bound_ends_the_loop_on_both_sides_and_not_before() {
        // A joint at rest, or one that flickers across an edge: the time.
        assert_eq!(ended(&BOUNDS, |_| 5), (401, Bound::Time));
        assert_eq!(ended(&BOUNDS, |tick| tick as i32 % 2), (401, Bound::Time));
        for sign in [1, -1] {
            // 0.29 counts a tick are slow enough for ever, so the travel ends it: at 201 counts.
            let slow = |tick: u32| sign * (tick * 29 / 100) as i32;
            let longer = Bounds { ticks: 5_000, ..BOUNDS };
            assert_eq!(ended(&longer, slow), (694, Bound::Travel));
            // A count every other tick: from tick 1 to tick 2 n there are n counts in 2 n - 1
            // ticks, 0.4 n + 0.3 too many. More than 8 they are from n = 20 on.
            let fast = |tick: u32| sign * (tick / 2) as i32;
            assert_eq!(ended(&longer, fast), (40, Bound::Speed));
        }
        let mut state = OpenLoopState::start(0);
        for (effort, is_let) in
            [(0.5, true), (-0.5, true), (0.501, false), (-0.501, false), (f32::NAN, false)]
        {
            assert_eq!(BOUNDS.admit(&mut state, 0, effort).is_ok(), is_let, "{effort}");
        }
    }

    /// The second method looks at every window there is.
    #[test]
    fn the_speed_is_too_high_exactly_if_it_is_in_some_window() {
        let mut random = 1u32;
        let mut next = move || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            random >> 16
        };
        let bounds = Bounds { travel: u32::MAX, ticks: u32::MAX, speed: 1.5, ..BOUNDS };
        let mut tripped = 0;
        for _ in 0..300 {
            let mut counts = [0i32; 40];
            let drift = (next() % 5) as i32 - 2;
            for tick in 1..40 {
                counts[tick] = counts[tick - 1] + drift + (next() % 5) as i32 - 2;
            }
            let mut state = OpenLoopState::start(0);
            for tick in 1..40 {
                let is_fast = (0..tick).any(|from| {
                    let travel = (counts[tick] - counts[from]).unsigned_abs() as f32;
                    travel > 1.5 * (tick - from) as f32 + SLACK as f32
                });
                let found = bounds.admit(&mut state, counts[tick], 0.0);
                assert_eq!(found == Err(Bound::Speed), is_fast, "{counts:?} at {tick}");
                if is_fast {
                    tripped += 1;
                    break;
                }
            }
        }
        assert!((50..250).contains(&tripped), "{tripped} of 300");
    }
}
