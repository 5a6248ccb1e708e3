//! The profile of a move: velocity, acceleration and jerk are limited, and the set point lands on
//! its target exactly.
//!
//! ```text
//! target -> approach.rs  speed of bounded change  -> average over T -> set point, p', p''
//!           every k-th tick                          (and over k)
//! ```
//!
//! The first stage is the fastest approach with `v_m` and `a_m` (`approach.rs`). The second is a
//! moving average over `T = N k` ticks (L. Biagiotti and C. Melchiorri, *FIR filters for online
//! trajectory planning with time- and frequency-domain specifications*, Control Engineering
//! Practice 20 (2012), 1385). An average stays within the limits of speed and acceleration, and
//! ends `T` after the first stage. In a tick the acceleration changes by `(a(t) - a(t - T)) / T`.
//! An approach can turn from `a_m` to `-a_m` at once, so the jerk is bounded by `2 a_m / T`:
//! `T >= 2 a_m / j_m`.
//!
//! The first stage runs every `k` ticks, and its speed goes from one value to the next in a
//! straight line (an average over `k`). `k` is two ticks: one plans the next speed, and the other
//! one sets it. If `T` is more than 128 ticks, the most that the ring can hold with `k` = 2, `k` is
//! four.
//!
//! All sums are whole numbers (`grid.rs`): nothing drifts, and a set point at rest is exactly at
//! rest. The ring holds the changes of the speed, so that a constant speed is a ring of zeros.
//!
//! Guarantees: velocity and acceleration stay exactly within their limits, for every target and
//! every change of it, at rest and in motion; the jerk stays within its limit to 1e-5 of it (a
//! length that is a power of two but for the rounding of decimals is rounded to that power). The
//! set point lands on the target's count and stays there, and never passes a target at which it can
//! still stop. A tick needs a bounded number of instructions, none of them in a loop. Does badly:
//! `T` is a power of two of ticks, so that up to half of the jerk is not used. A fraction of a
//! count is rounded to the grid, 2^-8 counts at the worst. `T` is 256 ticks at the most. The
//! profile does not consider friction: a joint trails it.

mod approach;
pub mod bounded_acceleration;
mod derived;
mod grid;
mod limits;

pub use bounded_acceleration::{BoundedAcceleration, LimitedReference};
pub use limits::ProfileLimits;

use crate::control::reference::Setpoint;
use crate::units::error::InvalidValue;
use crate::units::position::Position;
use grid::Grid;

/// Entries of the ring.
const RING: usize = 64;

/// A profiled move: its limits, its target, and its present state.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    grid: Grid,
    /// Units of the first stage in a count.
    units: f32,
    /// The target: counts, and the rest in units of the first stage.
    target: Place,
    /// Position of the first stage.
    place: Place,
    /// Present speed of the first stage and its planned next speed, units per k ticks.
    speed: i32,
    wanted: i32,
    /// Ticks since the first stage ran. Negative: the remaining ticks for which the set point
    /// waits.
    phase: i32,
    /// Number of entries of `ring` that this move has not filled yet. They count as zero.
    empty: u32,
    /// Index of the ring's entry for the next change.
    next: u32,
    /// Change of the acceleration, acceleration and velocity of the set point, units of the sums.
    jerk: i32,
    acceleration: i32,
    velocity: i32,
    /// The set point: counts, and the rest in units of the sums.
    counts: i32,
    rest: i32,
    /// Changes of the first stage's speed, units per k ticks.
    ring: [i32; RING],
}

/// Limits of a move, prepared for the ticks of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MoveLimits(Grid);

/// A position: counts, and the rest in units of the first stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    counts: i32,
    rest: i32,
}

impl Profile {
    /// Prepares a move to `target` from rest at zero, for ticks of `sample_time` (s) and counts of
    /// `resolution` (deg).
    ///
    /// # Errors
    /// Returns an error that names the limit that cannot be kept at that sample time and
    /// resolution.
    ///
    /// ```
    /// use stiction::units::position::Position;
    /// use stiction::control::profile::{Profile, ProfileLimits};
    /// // 6 counts with 2 counts a tick, 1 count a tick squared, and hardly a limit of the jerk.
    /// let limits = ProfileLimits { velocity: 2.0, acceleration: 1.0, jerk: 1e6 };
    /// let mut profile = Profile::new(Position::from_counts(6), &limits, 1.0, 1.0).unwrap();
    /// let way = [(); 8].map(|()| profile.update().position.ahead_of(0));
    /// assert_eq!(way, [0.5, 2.0, 3.75, 5.0, 5.75, 6.0, 6.0, 6.0]);
    /// ```
    pub fn new(
        target: Position,
        limits: &ProfileLimits,
        sample_time: f32,
        resolution: f32,
    ) -> Result<Self, InvalidValue> {
        let mut profile = Self {
            grid: Grid::new(limits, sample_time, resolution)?,
            units: 0.0,
            target: Place::default(),
            place: Place::default(),
            speed: 0,
            wanted: 0,
            phase: 0,
            empty: 0,
            next: 0,
            jerk: 0,
            acceleration: 0,
            velocity: 0,
            counts: 0,
            rest: 0,
            ring: [0; RING],
        };
        profile.units = (1 << profile.grid.bits) as f32;
        profile.restart();
        profile.aim(target);
        Ok(profile)
    }

    /// Sets another target. The move goes on from its present position and speed.
    pub fn aim(&mut self, target: Position) {
        let rest = (target.fraction * self.units) as i32;
        self.target = Place { counts: target.counts, rest };
        self.plan();
    }

    /// Returns the target.
    pub fn target(&self) -> Position {
        let fraction = self.target.rest as f32 / self.units;
        Position { counts: self.target.counts, fraction }
    }

    /// Sets the set point to a position and to a velocity (deg/s), as if that velocity had been
    /// constant until now. The target stays.
    pub fn start_at(&mut self, position: Position, velocity: f32) {
        let Grid { bits, sums, entries, ticks, largest, velocity_scale, .. } = self.grid;
        let (span, k) = (i64::from(self.grid.span()), 1i64 << ticks);
        self.restart();
        // A speed beyond the limit is kept as far as the sums have room.
        let sum = velocity / velocity_scale;
        let speed = (sum / (1 << (entries + 2 * ticks)) as f32) as i32;
        self.speed = speed.max(-largest).min(largest);
        self.velocity = self.speed << (entries + 2 * ticks);
        // How far the set point still goes if the first stage stops: half of the averages' length.
        let lag = (i64::from(self.speed) * (span + k - 2)) << (sums - bits - 1 - ticks);
        let begin = i64::from((position.fraction * self.units) as i32) << (sums - bits);
        let place = (begin + lag) >> (sums - bits);
        self.place = Place::beyond(position.counts, place, bits);
        let rest = (place << (sums - bits)) - lag;
        self.counts = position.counts.wrapping_add((rest >> sums) as i32);
        self.rest = (rest & ((1 << sums) - 1)) as i32;
        self.plan();
    }

    /// Restarts the move from rest at zero, to its present target.
    pub fn restart(&mut self) {
        (self.phase, self.empty) = (0, 1 << self.grid.entries);
        (self.next, self.speed) = (0, 0);
        (self.jerk, self.acceleration, self.velocity) = (0, 0, 0);
        (self.counts, self.rest, self.place) = (0, 0, Place::default());
        self.plan();
    }

    /// Returns other limits of a move, prepared for ticks of `sample_time` (s) and counts of
    /// `resolution` (deg).
    ///
    /// # Errors
    /// Returns an error that names the limit that cannot be kept at that sample time and
    /// resolution.
    pub(crate) fn limits(
        limits: &ProfileLimits,
        sample_time: f32,
        resolution: f32,
    ) -> Result<MoveLimits, InvalidValue> {
        Ok(MoveLimits(Grid::new(limits, sample_time, resolution)?))
    }

    /// Sets other limits, and the set point to rest at a position. The target stays.
    pub(crate) fn rest_with(&mut self, limits: &MoveLimits, position: Position) {
        let target = self.target();
        self.grid = limits.0;
        self.units = (1 << self.grid.bits) as f32;
        // The place has the units of the limits before.
        self.start_at(position, 0.0);
        self.aim(target);
    }

    /// Delays the start of a set point at rest by `ticks` ticks. A moving set point is not delayed:
    /// it would go on at its present speed meanwhile.
    pub fn wait(&mut self, ticks: u32) {
        if self.speed == 0 && self.velocity == 0 {
            // A soft start is 10^5 ticks at the most.
            self.phase = -(ticks.min(1 << 30) as i32);
        }
    }

    /// Stops the move as fast as the limits allow, on the first whole count.
    pub fn stop(&mut self) {
        // A set point that has arrived stays, also between two counts.
        if self.speed != 0 || self.place != self.target {
            self.target = Place { counts: self.stops_at(), rest: 0 };
        }
        self.plan();
    }

    /// Returns the count on which the set point comes to rest if it brakes from now on: the first
    /// whole count that the limits allow.
    ///
    /// Wherever the target is, no later set point is beyond both the target and this count. If the
    /// target is too near to stop at, the first stage brakes in every step, and then turns back
    /// from this count. If the first stage can stop at the target, it does not pass it. The
    /// averages are never beyond the values that they average.
    pub fn stops_at(&self) -> i32 {
        let bits = self.grid.bits;
        let way = self.grid.approach.stopping_distance(self.speed);
        let up = if self.speed > 0 { (1 << bits) - 1 } else { 0 };
        let rest = i64::from(self.place.rest) + way + up;
        Place::beyond(self.place.counts, rest, bits).counts
    }

    /// Returns whether the set point still moves, or will move.
    pub fn is_moving(&self) -> bool {
        // A set point that turns can have neither velocity nor acceleration for a tick, while the
        // first stage rests on the target already.
        let Place { counts, rest } = self.place;
        let has_arrived =
            (self.counts, self.rest) == (counts, rest << (self.grid.sums - self.grid.bits));
        let rests = self.speed == 0 && self.velocity == 0 && self.acceleration == 0;
        !has_arrived || !rests || self.place != self.target
    }

    /// Runs a tick, and returns the set point.
    #[inline]
    pub fn update(&mut self) -> Setpoint {
        if self.phase == 0 {
            self.step();
        }
        self.phase += 1;
        if self.phase >= self.grid.period {
            self.phase = 0;
            self.plan();
        }
        self.acceleration += self.jerk;
        self.velocity += self.acceleration;
        let (rest, bits) = (self.rest + self.velocity, self.grid.sums);
        self.counts = self.counts.wrapping_add(rest >> bits);
        self.rest = rest & ((1 << bits) - 1);
        self.setpoint()
    }

    /// Returns the set point of the last tick.
    #[inline]
    pub fn setpoint(&self) -> Setpoint {
        // Not rounded: a fraction is below one.
        let fraction = (self.rest & self.grid.shown) as f32 * self.grid.fraction;
        Setpoint {
            position: Position { counts: self.counts, fraction },
            velocity: self.velocity as f32 * self.grid.velocity_scale,
            acceleration: self.acceleration as f32 * self.grid.acceleration_scale,
        }
    }

    /// Plans the next speed of the first stage, from its distance to the target.
    #[inline]
    fn plan(&mut self) {
        let ahead = self.target.counts.wrapping_sub(self.place.counts) as f32;
        // Whole and exact where it matters: near the target.
        let distance = ahead * self.units + (self.target.rest - self.place.rest) as f32;
        self.wanted = self.grid.approach.wanted(distance, self.speed);
    }

    /// Runs the first stage, and puts the change of its speed into the ring.
    #[inline]
    fn step(&mut self) {
        let speed = self.grid.approach.next(self.wanted, self.speed);
        let change = speed - self.speed;
        self.speed = speed;
        let rest = self.place.rest + speed;
        self.place.counts = self.place.counts.wrapping_add(rest >> self.grid.bits);
        self.place.rest = rest & ((1 << self.grid.bits) - 1);
        let mut left = 0;
        if let Some(entry) = self.ring.get_mut(self.next as usize) {
            // The entry of an earlier move does not count in this one.
            left = if self.empty == 0 { *entry } else { 0 };
            *entry = change;
        }
        if self.empty != 0 {
            self.empty -= 1;
        }
        self.next = (self.next + 1) & ((1 << self.grid.entries) - 1);
        self.jerk = change - left;
    }
}

impl Place {
    /// Returns the place that lies `units` units beyond a count.
    const fn beyond(counts: i32, units: i64, bits: u32) -> Self {
        let counts = counts.wrapping_add((units >> bits) as i32);
        Self { counts, rest: (units & ((1 << bits) - 1)) as i32 }
    }
}
