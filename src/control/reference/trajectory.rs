//! The trajectory reference: linear segments with parabolic blends. It is Paul's method (R. P.
//! Paul, *Robot Manipulators*, MIT Press 1981), which the thesis uses for its tracking benchmark
//! (section 3.3.1, Fig. 25).
//!
//! Corners `(t_i, p_i)` are joined by straight lines of rate `r_i = (p_(i+1) - p_i) / (t_(i+1) -
//! t_i)`, with rest before the first and after the last. Within the half blend time `tau` of a
//! corner, with `s = t - t_i`:
//!
//! ```text
//! position     = p_i + r_(i-1) s + (r_i - r_(i-1)) (s + tau)^2 / (4 tau)
//! velocity     = r_(i-1) + (r_i - r_(i-1)) (s + tau) / (2 tau)
//! acceleration = (r_i - r_(i-1)) / (2 tau)
//! ```
//!
//! This is the parabola that meets both lines with their slopes: position and velocity are
//! continuous. It does not pass through the corner but cuts it by `(r_i - r_(i-1)) tau / 4`. The
//! thesis prints neither corner times nor blend times, and its Fig. 25 is not in its text: those of
//! the experiment `trajectory` are our choice.
//!
//! Does badly: the acceleration jumps at both ends of a blend, which excites a flexible joint.

use heapless::Vec;

use super::Setpoint;
use crate::control::controller::SAMPLE_TIME;
use crate::control::encoder::RESOLUTION;
use crate::units::error::{Allowed, HUGE, InvalidValue, above, between};
use crate::units::position::{Position, Rate};
use crate::units::value::Key;

/// The largest number of corners.
pub const MAX_CORNERS: usize = 16;

/// Key of the configured value `half_blend_s`.
pub(crate) const HALF_BLEND: Key = Key(0x0603);
/// Key of the first corner's time. Each corner has four keys, of which three are used; the time's
/// key is the first of them. The keys of the next corner follow.
pub(crate) const CORNER_TIMES: Key = Key(0x0700);

/// A corner of a trajectory, in which two straight lines would meet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "device", derive(serde::Serialize, serde::Deserialize))]
pub struct Corner {
    /// Time of the corner, ticks.
    pub tick: u32,
    /// Position of the corner.
    pub position: Position,
}

/// A corner, with the prepared values of the blend around it and of the line after it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blend {
    corner: Corner,
    /// The first tick of the blend.
    from: u32,
    /// Rate of the line after the corner.
    rate: Rate,
    /// Rate before the corner, counts per tick.
    rate_before: f32,
    /// Change of the rate at the corner, counts per tick.
    rate_change: f32,
}

/// A motion through corners, ready to be followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    blends: Vec<Blend, MAX_CORNERS>,
    /// Half the time of a blend, ticks; not necessarily whole.
    half_blend: f32,
    /// Factor from counts per tick to deg/s.
    velocity_scale: f32,
    /// Factor from counts per tick per tick to deg/s^2.
    acceleration_scale: f32,
}

impl Trajectory {
    /// Prepares the motion through `corners`, blended for `half_blend_s` on either side of each,
    /// for a loop with `sample_time` (s) and an encoder of `resolution` (deg).
    ///
    /// # Errors
    /// Returns an error that names `corner_times_s` unless there are 1 to [`MAX_CORNERS`] corners
    /// that follow each other by two half blends or more, the first of them no earlier than half a
    /// blend. Returns one that names `half_blend_s` unless it is at least half a tick.
    pub fn new(
        corners: &[Corner],
        half_blend_s: f32,
        sample_time: f32,
        resolution: f32,
    ) -> Result<Self, InvalidValue> {
        Self::validate(corners, half_blend_s, sample_time, resolution)?;
        let mut trajectory = Self::EMPTY;
        trajectory.set(corners, half_blend_s, sample_time, resolution);
        Ok(trajectory)
    }

    /// Validates a motion as [`new`](Self::new) does, without preparing it.
    ///
    /// # Errors
    /// Returns the same errors as [`new`](Self::new).
    pub fn validate(
        corners: &[Corner],
        half_blend_s: f32,
        sample_time: f32,
        resolution: f32,
    ) -> Result<(), InvalidValue> {
        between(CORNER_TIMES, corners.len() as f32, 1.0, MAX_CORNERS as f32)?;
        above(SAMPLE_TIME, sample_time, 0.0, 1.0)?;
        above(RESOLUTION, resolution, 0.0, HUGE)?;
        between(HALF_BLEND, half_blend_s, 0.5 * sample_time, HUGE)?;
        // A quotient of two decimals may come out above the whole number that it is.
        let shortest = half_blend_s / sample_time * (1.0 - 1e-6);
        let mut before: Option<u32> = None;
        for corner in corners {
            let (gap, needed) = match before {
                None => (Some(corner.tick), shortest),
                Some(before) => (corner.tick.checked_sub(before), 2.0 * shortest),
            };
            if gap.is_none_or(|gap| (gap as f32) < needed) {
                let found = corner.tick as f32 * sample_time;
                let allowed = match before {
                    None => Allowed::Between(half_blend_s, HUGE),
                    Some(_) => Allowed::LaterBy(2.0 * half_blend_s),
                };
                return Err(InvalidValue { key: CORNER_TIMES, found, allowed });
            }
            before = Some(corner.tick);
        }
        Ok(())
    }

    /// A trajectory without corners; [`set`](Self::set) adds them.
    pub(crate) const EMPTY: Self =
        Self { blends: Vec::new(), half_blend: 0.0, velocity_scale: 0.0, acceleration_scale: 0.0 };

    /// Prepares a validated motion in place, in an empty trajectory, so that half a kilobyte is not
    /// copied.
    pub(crate) fn set(
        &mut self,
        corners: &[Corner],
        half_blend_s: f32,
        sample_time: f32,
        resolution: f32,
    ) {
        self.half_blend = half_blend_s / sample_time;
        self.velocity_scale = resolution / sample_time;
        self.acceleration_scale = self.velocity_scale / sample_time;
        let mut rate_before = 0.0;
        for (i, &corner) in corners.iter().enumerate() {
            let rate = match corners.get(i + 1) {
                Some(next) => Rate::between(
                    corner.position,
                    next.position,
                    next.tick.saturating_sub(corner.tick),
                ),
                None => Rate::ZERO,
            };
            let rate_change = rate.counts_per_tick() - rate_before;
            let from = corner.tick.saturating_sub(self.half_blend as u32);
            // Cannot fail: the number of corners has been validated.
            let _ = self.blends.push(Blend { corner, from, rate, rate_before, rate_change });
            rate_before = rate.counts_per_tick();
        }
    }

    /// Returns the corners, in their order.
    pub fn corners(&self) -> impl Iterator<Item = Corner> {
        self.blends.iter().map(|blend| blend.corner)
    }

    /// Returns the set point at a tick.
    ///
    /// ```
    /// use stiction::{units::position::Position, control::reference::{Corner, Trajectory}};
    /// // 100 counts of 1 deg in 10 ticks of 1 s, blended over +-2 ticks.
    /// let corners = [(5, 0), (15, 100)]
    ///     .map(|(tick, counts)| Corner { tick, position: Position::from_counts(counts) });
    /// let trajectory = Trajectory::new(&corners, 2.0, 1.0, 1.0).unwrap();
    /// assert_eq!(trajectory.at(3).position.ahead_of(0), 0.0);
    /// assert_eq!(trajectory.at(5).position.ahead_of(0), 5.0); // 10 * (0 + 2)^2 / (4 * 2)
    /// assert_eq!(trajectory.at(5).velocity, 5.0);
    /// assert_eq!(trajectory.at(10).position.ahead_of(0), 50.0);
    /// assert_eq!(trajectory.at(99).position.ahead_of(100), 0.0);
    /// ```
    // Inlined in each of its places: a call would cost the tick a dozen instructions.
    #[inline(always)]
    pub fn at(&self, tick: u32) -> Setpoint {
        let Some(first) = self.blends.first() else { return Setpoint::default() };
        // Blends do not overlap. The set point is in the last one that has begun, or on the line
        // after it.
        let begun = self.blends.iter().take_while(|blend| blend.from <= tick).last();
        let Some(blend) = begun else { return Setpoint::at_rest(first.corner.position) };
        let since = match tick.checked_sub(blend.corner.tick) {
            // The tick is limited: years after the last corner, the result is still after that
            // corner.
            Some(after) => after.min(i32::MAX.unsigned_abs()) as i32,
            None => -((blend.corner.tick - tick).min(i32::MAX.unsigned_abs()) as i32),
        };
        if (since as f32) < self.half_blend {
            self.blended(blend, since as f32)
        } else {
            let velocity = (blend.rate_before + blend.rate_change) * self.velocity_scale;
            let position = blend.corner.position.advanced(blend.rate, since);
            Setpoint { position, velocity, acceleration: 0.0 }
        }
    }

    fn blended(&self, blend: &Blend, since: f32) -> Setpoint {
        let into = since + self.half_blend;
        let slope = blend.rate_change / (2.0 * self.half_blend);
        let displacement = blend.rate_before * since + 0.5 * slope * into * into;
        Setpoint {
            position: blend.corner.position.displaced(displacement),
            velocity: (blend.rate_before + slope * into) * self.velocity_scale,
            acceleration: slope * self.acceleration_scale,
        }
    }
}
