//! Findings of an identification, as the link reports them, and the doubts about them.

use serde::{Deserialize, Serialize};

use super::model::{Model, ModelEstimate, Search};
use super::plan::{PLACES, SPEEDS};
use crate::safety::open_loop::Bound;

/// Relative residual beyond which a fit is poor. A joint that matches the model leaves only the
/// rounding of drive and encoder, which is a hundredth or less.
const POOR: f32 = 0.05;
/// Largest difference of the breakaway between places, as a share of the median, for the friction
/// to count as even. The drive's rounding of a small level is up to 0.03 of it.
const UNEVEN: f32 = 0.15;
/// Largest difference between a breakaway after a reversal and the next one in the same sense, as a
/// share of the next one, without lost motion.
const LOST: f32 = 0.15;
/// Counts by which a joint gives way before it breaks away, and the number of such pushes that
/// shows lost motion: in 20 pushes on each of 240 stiff joints (seed 7), one joint did so in one
/// push.
pub(super) const GIVES_WAY: u32 = 2;
const GIVES_WAY_OFTEN: u8 = 3;
/// Least share of the inertia at low frequency that a pulse from rest meets without lost motion.
/// With viscous friction, a pulse meets more than the whole inertia; with a shaft that winds up,
/// only that of the driven side.
const LIGHT: f32 = 0.85;
/// Least number of rows for a fit of eight parameters to be trusted.
const FEW: u32 = 24;

/// How an identification has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// The identification has not ended.
    #[default]
    Running,
    /// All steps were done.
    Done,
    /// The encoder counts against the effort.
    Reversed,
    /// The joint moved the same way under both efforts: a load moves it.
    Pulled,
    /// The joint did not move up to the effort bound.
    Still,
    /// The joint kept moving without effort.
    RunsOn,
    /// The joint exceeded the travel bound.
    Travel,
    /// The joint exceeded the speed bound.
    Speed,
    /// The time ran out.
    Time,
    /// The motion required more effort than the effort bound.
    Capped,
    /// Effort beyond the friction moved the joint by less than a quarter of what was due: an end
    /// stop, or an encoder that broke.
    NoProgress,
}

impl From<Bound> for Outcome {
    fn from(bound: Bound) -> Self {
        match bound {
            Bound::Travel => Self::Travel,
            Bound::Speed => Self::Speed,
            Bound::Time => Self::Time,
            Bound::Effort => Self::Capped,
        }
    }
}

/// Breakaway efforts in one sense, V, without their sign and with the load; zero: not found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BreakawayLevels {
    /// The least effort of all places.
    pub least: f32,
    /// The median.
    pub median: f32,
    /// The largest.
    pub largest: f32,
    /// Number of places.
    pub places: u8,
}

/// A point of the friction map: the means over all windows of a leg near its speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapPoint {
    /// Velocity, deg/s.
    pub velocity: f32,
    /// Effort, V.
    pub effort: f32,
    /// Number of windows; zero: the joint did not slide evenly at this speed.
    pub windows: u16,
}

/// Doubts about a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Doubts {
    /// The rows do not determine the parameters.
    pub no_fit: bool,
    /// The relative residual of the fit is more than a twentieth.
    pub poor_fit: bool,
    /// The regression has fewer than 24 rows.
    pub few_rows: bool,
    /// The breakaway differs between the places by more than 15 %. The mean of both senses, which
    /// is free of the load, is compared; if the fit has no gravity, each sense is compared as well.
    pub uneven: bool,
    /// Backlash, bristles, or a shaft that winds up: the breakaway after a reversal differs from
    /// the next one in the same sense by more than 15 %; or the joint gave way before it broke
    /// away, three times or more; or a pulse met less than 0.85 of the inertia.
    pub lost_motion: bool,
    /// Inertia or constant friction came out as negative or as zero, or viscous friction as
    /// negative by more than two standard deviations.
    pub unphysical: bool,
}

impl Doubts {
    /// Returns whether there is no doubt.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// Result of an identification, which is reported after its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How it has ended.
    pub outcome: Outcome,
    /// Number of steps that were done.
    pub steps: u8,
    /// The breakaway in the positive and in the negative sense.
    pub breakaway: [BreakawayLevels; 2],
    /// The parameters, if the rows determine them.
    pub estimate: Option<ModelEstimate>,
    /// Difference between the highest and the lowest position, deg.
    pub range: f32,
    /// Doubts about the result.
    pub doubts: Doubts,
}

/// Readings of an identification, from which a [`Summary`] is computed outside the tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    /// How it has ended.
    pub outcome: Outcome,
    /// Number of steps that were done.
    pub steps: u8,
    /// The breakaway of each place in both senses, V; zero: not found.
    pub levels: [[f32; PLACES]; 2],
    /// Largest difference between a breakaway after a reversal and the next one, as a share of the
    /// next.
    pub lost: f32,
    /// Number of pushes in which the joint gave way before it broke away.
    pub gave_way: u8,
    /// The inertia that the pulses have met, V/(deg/s^2); zero: not found.
    pub met: f32,
    /// Difference between the highest and the lowest position, deg: the angle gone through.
    pub range: f32,
    /// The regression.
    pub model: Model,
    /// The map: each speed in both senses, the fastest first.
    pub map: [[MapPoint; 2]; SPEEDS],
}

impl BreakawayLevels {
    fn of(levels: &[f32; PLACES]) -> Self {
        let mut sorted = *levels;
        sorted.sort_unstable_by(f32::total_cmp);
        let missing = sorted.iter().take_while(|level| **level <= 0.0).count();
        let found = sorted.get(missing..).unwrap_or_default();
        let middle = found.get(found.len() / 2).zip(found.get(found.len().wrapping_sub(1) / 2));
        Self {
            least: found.first().copied().unwrap_or(0.0),
            median: middle.map_or(0.0, |(one, other)| 0.5 * (one + other)),
            largest: found.last().copied().unwrap_or(0.0),
            places: found.len() as u8,
        }
    }

    fn is_uneven(&self) -> bool {
        self.largest - self.least > UNEVEN * self.median
    }
}

/// Returns whether the friction depends on the place. A load raises the breakaway in one sense and
/// lowers it in the other, so the mean of both is compared. If no load varies with the place, each
/// sense is compared as well.
fn is_uneven(levels: &[[f32; PLACES]; 2], load_may_vary: bool) -> bool {
    let [positive, negative] = levels;
    let mut without_load = [0.0; PLACES];
    for ((mean, one), other) in without_load.iter_mut().zip(positive).zip(negative) {
        *mean = if *one > 0.0 && *other > 0.0 { 0.5 * (one + other) } else { 0.0 };
    }
    BreakawayLevels::of(&without_load).is_uneven()
        || !load_may_vary && levels.iter().any(|one| BreakawayLevels::of(one).is_uneven())
}

impl Findings {
    /// Returns the summary of the readings after a whole search: dozens of fits at once, for a
    /// host.
    pub fn summary(&self) -> Summary {
        self.summary_of(&Search::whole(&self.model, self.range))
    }

    /// Returns the summary of the readings at the end of a search.
    #[inline(never)]
    pub fn summary_of(&self, search: &Search) -> Summary {
        let [positive, negative] = &self.levels;
        let breakaway = [BreakawayLevels::of(positive), BreakawayLevels::of(negative)];
        let estimate = self.model.estimate_at(search);
        let found_gravity = estimate.is_none_or(|found| found.gravity[0][1] > 0.0);
        let mut doubts = Doubts {
            no_fit: estimate.is_none(),
            uneven: is_uneven(&self.levels, found_gravity),
            lost_motion: self.lost > LOST || self.gave_way >= GIVES_WAY_OFTEN,
            ..Doubts::default()
        };
        if let Some(found) = &estimate {
            // NaN is a poor fit.
            let fits = found.relative_residual <= POOR;
            doubts.poor_fit = !fits;
            doubts.few_rows = found.rows < FEW;
            let [inertia, _] = found.inertia;
            doubts.lost_motion |= self.met > 0.0 && self.met < LIGHT * inertia;
            let positive = [found.inertia[0], found.coulomb[0]];
            // Zero viscous friction is possible; a negative one beyond its deviation is not.
            doubts.unphysical = !positive.iter().all(|value| *value > 0.0)
                || found.viscous[0] < -2.0 * found.viscous[1];
        }
        let Self { outcome, steps, range, .. } = *self;
        Summary { outcome, steps, breakaway, estimate, range, doubts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_the_order_statistics_of_what_was_found() {
        let of = |levels| {
            let BreakawayLevels { least, median, largest, places } = BreakawayLevels::of(&levels);
            ([least, median, largest], places)
        };
        assert_eq!(of([0.3, 0.5, 0.1, 0.2, 0.4]), ([0.1, 0.3, 0.5], 5));
        assert_eq!(of([0.0, 0.5, 0.0, 0.25, 0.0]), ([0.25, 0.375, 0.5], 2));
        assert_eq!(of([0.0; 5]), ([0.0; 3], 0));
        let spread =
            |largest| BreakawayLevels { least: 0.93, median: 1.0, largest, places: 5 }.is_uneven();
        assert_eq!([1.07, 1.09].map(spread), [false, true]);
    }

    #[test]
    fn a_load_that_varies_with_the_place_is_no_friction_that_does() {
        let pendulum = [[0.5, 0.6, 0.65, 0.6, 0.5], [0.5, 0.4, 0.35, 0.4, 0.5]];
        assert_eq!([true, false].map(|vary| is_uneven(&pendulum, vary)), [false, true]);
        let [up, _] = pendulum;
        assert_eq!([true, false].map(|vary| is_uneven(&[up, up], vary)), [true, true]);
        // A place without a reading one way shows nothing of the friction.
        let [up, mut down] = pendulum;
        down[2] = 0.0;
        assert!(!is_uneven(&[up, down], true));
        // Nothing has distinguished the load from friction.
        let of = |levels| Findings { levels, ..Findings::default() }.summary().doubts;
        assert!(of(pendulum).no_fit && !of(pendulum).uneven && of([up, up]).uneven);
    }

    #[test]
    fn a_joint_that_often_gives_way_before_it_breaks_away_is_doubted() {
        let of = |gave_way| Findings { gave_way, ..Findings::default() }.summary();
        assert_eq!([2, 3].map(|times| of(times).doubts.lost_motion), [false, true]);
    }
}
