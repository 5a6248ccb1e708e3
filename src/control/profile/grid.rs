//! The grid of a profile: the whole units in which it counts, and the lengths of its averages.
//!
//! ```text
//! T = N k >= 2 a_m / (j_m h)    ticks; N and k are powers of two, k > 2 only if N is at its most
//! V = floor(v_m k 2^s),  D = floor(a_m k^2 2^s)    units of 2^-s counts per k ticks
//! ```
//!
//! with `v_m` in counts per tick and `a_m` in counts per tick per tick. Both are rounded down, so
//! that no limit is exceeded. The unit is as small as 32 bits allow: the unit of the averages' sums
//! is `2^-s / (N k^3)` counts, and neither a count nor the travel of a tick has more than 2^30 of
//! these units.

use super::approach::Approach;
use super::limits::ProfileLimits;
use crate::units::error::{Allowed, InvalidValue};
use crate::units::value::{Key, Table, key};

/// Most entries of the ring: N, as a power of two.
const MOST_ENTRIES: u32 = 6;
/// Fewest and most ticks between two entries: k, as powers of two. The work of a step is done in
/// two ticks.
const FEWEST_TICKS: u32 = 1;
const MOST_TICKS: u32 = 2;
/// Most bits of a count's fraction in the set point, and of the set point's travel in a tick.
const MOST_BITS: u32 = 30;
/// V and D stay below 2^22: sums of four of them are exact in an `f32`.
const LARGEST: u32 = 22;
/// Fewest bits s of the unit of 2^-s counts, to which a target's fraction of a count is rounded.
const FEWEST_BITS: u32 = 8;
/// The least V and D: rounding down reduces them by no more than a fifth.
const LEAST: f32 = 4.0;
/// Factor on a quotient of decimals that should be a power of two, and can be a little above it.
const ROUNDING: f32 = 1.0 - 1e-5;

const VELOCITY: Key = key(ProfileLimits::ABOUT, "velocity");
const ACCELERATION: Key = key(ProfileLimits::ABOUT, "acceleration");
const JERK: Key = key(ProfileLimits::ABOUT, "jerk");

/// Units of a profile, prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub approach: Approach,
    /// s, and the bits of the sums' unit.
    pub bits: u32,
    pub sums: u32,
    /// Mask of the bits of a rest in the sums' unit that an `f32` below one can hold.
    pub shown: i32,
    /// The logarithms of N and k to base 2.
    pub entries: u32,
    pub ticks: u32,
    /// k itself, signed since the phase is signed.
    pub period: i32,
    /// The largest speed that the sums have room for, units.
    pub largest: i32,
    /// Factors from a unit of the sums to a count, to deg/s and to deg/s^2.
    pub fraction: f32,
    pub velocity_scale: f32,
    pub acceleration_scale: f32,
}

/// Lengths of the averages and scales of a count, from which all other units follow.
#[derive(Clone, Copy)]
struct Frame {
    entries: u32,
    ticks: u32,
    /// Deg/s of a count per tick.
    velocity: f32,
    /// Deg/s^2 of a count per tick per tick.
    acceleration: f32,
}

impl Frame {
    /// Returns the lengths for averages over at least `span` ticks, or the longest ones if `span`
    /// is longer.
    fn new(span: f32, sample_time: f32, resolution: f32) -> Self {
        let most = MOST_ENTRIES + MOST_TICKS;
        let fits = |length: &u32| span * ROUNDING <= power(*length);
        let length = (FEWEST_TICKS..most).find(fits).unwrap_or(most);
        let entries = (length - FEWEST_TICKS).min(MOST_ENTRIES);
        Self {
            entries,
            ticks: length - entries,
            velocity: resolution / sample_time,
            acceleration: resolution / sample_time / sample_time,
        }
    }

    /// Returns the largest velocity and acceleration, deg/s and deg/s^2.
    fn most(&self) -> [f32; 2] {
        let below = power(self.largest() - FEWEST_BITS);
        [
            below / power(self.ticks) * self.velocity,
            below / power(2 * self.ticks) * self.acceleration,
        ]
    }

    /// Returns the bits of the largest V and D.
    const fn largest(&self) -> u32 {
        let sum = MOST_BITS - self.entries - 2 * self.ticks;
        if sum < LARGEST { sum } else { LARGEST }
    }

    /// Returns the largest velocity in counts per k ticks, and the largest acceleration in counts
    /// per (k ticks)^2.
    fn in_counts(&self, limits: &ProfileLimits) -> [f32; 2] {
        let velocity = limits.velocity / self.velocity * power(self.ticks);
        [velocity, limits.acceleration / self.acceleration * power(2 * self.ticks)]
    }

    /// Returns the most bits of the unit with which V and D do not exceed their largest values.
    fn bits(&self, limits: &ProfileLimits) -> u32 {
        let [velocity, acceleration] = self.in_counts(limits);
        let larger = if velocity > acceleration { velocity } else { acceleration };
        let fits = |bits: &u32| larger * power(*bits) <= power(self.largest());
        let finest = LARGEST.min(MOST_BITS - self.entries - 3 * self.ticks);
        (FEWEST_BITS..=finest).rev().find(fits).unwrap_or(FEWEST_BITS)
    }

    /// Returns the least velocity and acceleration for a unit, deg/s and deg/s^2.
    fn least(&self, bits: u32) -> [f32; 2] {
        let unit = LEAST / power(bits);
        [unit / power(self.ticks) * self.velocity, unit / power(2 * self.ticks) * self.acceleration]
    }
}

impl ProfileLimits {
    /// Returns the nearest limits of speed, acceleration and jerk that the generator can keep, for
    /// a sample time (s) and the angle of an encoder count (deg).
    pub fn nearest(&self, sample_time: f32, resolution: f32) -> Self {
        Grid::nearest(self, sample_time, resolution)
    }

    /// Refuses limits that the generator cannot keep at a sample time (s) and an angle of a count
    /// (deg).
    ///
    /// # Errors
    /// Returns an error that names the limit, with its bounds for the present other limits.
    pub(crate) fn check(&self, sample_time: f32, resolution: f32) -> Result<(), InvalidValue> {
        Grid::new(self, sample_time, resolution).map(|_| ())
    }
}

impl Grid {
    /// Prepares the units for limits.
    ///
    /// # Errors
    /// Returns an error that names the limit that cannot be kept in whole units, with its bounds
    /// for the present other limits.
    pub fn new(
        limits: &ProfileLimits,
        sample_time: f32,
        resolution: f32,
    ) -> Result<Self, InvalidValue> {
        let span = span(limits, sample_time);
        let longest = power(MOST_ENTRIES + MOST_TICKS);
        // NaN is in no range.
        if !(0.0..=longest).contains(&(span * ROUNDING)) {
            let least = 2.0 * limits.acceleration / (longest * sample_time);
            return Err(InvalidValue {
                key: JERK,
                found: limits.jerk,
                allowed: Allowed::Between(least, 1e15),
            });
        }
        let frame = Frame::new(span, sample_time, resolution);
        let bits = frame.bits(limits);
        let bounds = [VELOCITY, ACCELERATION].into_iter().zip(frame.least(bits)).zip(frame.most());
        for (found, ((key, least), most)) in
            [limits.velocity, limits.acceleration].into_iter().zip(bounds)
        {
            let allowed = Allowed::Between(least, most);
            if !allowed.includes(found) {
                return Err(InvalidValue { key, found, allowed });
            }
        }
        let [fastest, change] = frame.in_counts(limits).map(|x| (x * power(bits)) as i32);
        let sums = bits + frame.entries + 3 * frame.ticks;
        let a_count = 1.0 / power(sums);
        Ok(Self {
            approach: Approach::new(fastest, change),
            bits,
            sums,
            shown: !((1 << sums.saturating_sub(24)) - 1),
            entries: frame.entries,
            ticks: frame.ticks,
            period: 1 << frame.ticks,
            largest: 1 << frame.largest(),
            fraction: a_count,
            velocity_scale: a_count * frame.velocity,
            acceleration_scale: a_count * frame.acceleration,
        })
    }

    /// Returns the limits that can be kept and are nearest to these.
    pub fn nearest(limits: &ProfileLimits, sample_time: f32, resolution: f32) -> ProfileLimits {
        let longest = power(MOST_ENTRIES + MOST_TICKS);
        let span = within(span(limits, sample_time), 0.0, longest);
        let frame = Frame::new(span, sample_time, resolution);
        // Slightly inside, so that no rounding exceeds a bound again.
        let [fastest, most] = frame.most().map(|most| most * ROUNDING);
        let at_most = ProfileLimits {
            velocity: within(limits.velocity, 0.0, fastest),
            acceleration: within(limits.acceleration, 0.0, most),
            ..*limits
        };
        let [slowest, least] = frame.least(frame.bits(&at_most)).map(|least| least / ROUNDING);
        let acceleration = within(at_most.acceleration, least, most);
        let is_as_asked = acceleration == limits.acceleration && span < longest;
        ProfileLimits {
            velocity: within(at_most.velocity, slowest, fastest),
            acceleration,
            jerk: if is_as_asked { limits.jerk } else { 2.0 * acceleration / (span * sample_time) },
        }
    }

    /// Returns the length T of the average, ticks.
    pub const fn span(&self) -> u32 {
        1 << (self.entries + self.ticks)
    }
}

/// Returns the shortest average that keeps the limit of the jerk, ticks: in that time, an
/// acceleration that reverses changes by twice the largest one.
fn span(limits: &ProfileLimits, sample_time: f32) -> f32 {
    2.0 * limits.acceleration / (limits.jerk * sample_time)
}

/// Returns a power of two as a float; the exponents here are far within its range.
fn power(of_two: u32) -> f32 {
    (1u64 << of_two) as f32
}

fn within(x: f32, low: f32, high: f32) -> f32 {
    if x > high {
        high
    } else if x < low {
        low
    } else {
        x
    }
}
