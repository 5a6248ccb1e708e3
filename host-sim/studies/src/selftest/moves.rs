//! Targets of the moves: long moves over the whole range, and short ones in the range of friction.

use stiction::Parameters;

/// Fractional part of the golden ratio: any number of its multiples fills a range evenly.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Length of a short move, as a share of the range.
const SHORT: f64 = 1.0 / 50.0;

/// Least length of a short move, counts: twice the default tolerance of a goal.
const SHORTEST_COUNTS: f64 = 4.0;

/// Largest default range, deg: most joints have this much room.
const MOST_DEG: f64 = 10.0;

/// Largest range as a share of the room between the position limits.
pub(super) const ROOM: f64 = 0.9;

/// Range of the moves to either side of the position at arming.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveRange {
    /// Farthest target, deg.
    pub deg: f64,
    /// Angle of a count, deg.
    pub count_deg: f64,
}

impl MoveRange {
    /// Derives the default range from a device's limits: the length of a profiled move of 1 s from
    /// rest to rest, `min(v, a / 4)`, at most 10 deg and at most the room between `position_deg`
    /// and the nearer position limit.
    pub fn derived(parameters: &Parameters, position_deg: f64) -> Self {
        let Parameters { profile, controller, .. } = parameters;
        let in_a_second = f64::from(profile.velocity).min(0.25 * f64::from(profile.acceleration));
        let deg = in_a_second.min(MOST_DEG).min(ROOM * room(parameters, position_deg));
        Self { deg, count_deg: controller.encoder.resolution.into() }
    }

    /// Returns the least range with both long and short moves: ten times the shortest move, deg.
    pub fn least_deg(&self) -> f64 {
        10.0 * SHORTEST_COUNTS * self.count_deg
    }
}

/// Returns the length of the longest move, deg; the first one starts at zero.
pub fn longest_way(targets: &[f64]) -> f64 {
    let from = std::iter::once(&0.0).chain(targets);
    from.zip(targets).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
}

/// Returns the distance to the nearer position limit, deg.
pub fn room(parameters: &Parameters, position_deg: f64) -> f64 {
    let [least, most] =
        [parameters.limits.position_min, parameters.limits.position_max].map(f64::from);
    if least == 0.0 && most == 0.0 {
        return f64::INFINITY;
    }
    (most - position_deg).min(position_deg - least).max(0.0)
}

/// Returns the targets of `count` moves, deg, on whole counts. The position at arming is zero.
///
/// The first, third and so on go over the range: to `R (2 frac(n g) - 1)` with the golden ratio g.
/// The moves between them are short: `R / 50` (at least 4 counts) towards zero. In such a move a
/// joint sticks before it slides. The last move goes back to zero.
pub fn targets(range: MoveRange, count: usize) -> Vec<f64> {
    let MoveRange { deg, count_deg } = range;
    let on_a_count = |deg: f64| (deg / count_deg).round() * count_deg;
    let short = (SHORT * deg).max(SHORTEST_COUNTS * count_deg);
    let mut at = 0.0;
    (0..count)
        .map(|number| {
            let turn = number / 2;
            let to = match number {
                _ if number + 1 == count => 0.0,
                _ if number % 2 == 0 => {
                    deg * 2.0f64.mul_add(((turn + 1) as f64 * GOLDEN).fract(), -1.0)
                }
                // Towards the middle, so that no short move leaves the range.
                _ if at > 0.0 => at - short,
                _ => at + short,
            };
            at = on_a_count(to);
            at
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_stay_in_range_are_long_and_short_by_turns_and_lead_back() {
        let range = MoveRange { deg: 10.0, count_deg: 0.01 };
        let targets = targets(range, 20);
        assert_eq!((targets.len(), targets[19]), (20, 0.0));
        assert!(targets.iter().all(|to| to.abs() <= 10.0), "{targets:?}");
        let ways: Vec<f64> = std::iter::once(targets[0])
            .chain(targets.windows(2).map(|pair| pair[1] - pair[0]))
            .collect();
        for (number, way) in ways.iter().enumerate().take(19) {
            let is_short = (way.abs() - 0.2).abs() < 1e-9;
            assert_eq!(is_short, number % 2 == 1, "move {number} over {way}");
        }
        // Both ways, short and long.
        for short in [0, 1] {
            let some = || ways.iter().skip(short).step_by(2);
            assert!(some().any(|way| *way > 0.0) && some().any(|way| *way < 0.0), "{ways:?}");
        }
        // A range of a few counts still moves.
        let small = super::targets(MoveRange { deg: 0.05, count_deg: 0.01 }, 4);
        assert!((small[1] - small[0]).abs() > 0.039, "{small:?}");
    }

    #[test]
    fn the_range_is_what_a_second_allows_and_what_the_limits_of_the_position_leave() {
        let mut parameters = Parameters {
            motion: stiction::Motion::Hold,
            ..simulator::experiment::for_a_device(&plan()).unwrap()
        };
        (parameters.profile.velocity, parameters.profile.acceleration) = (200.0, 1000.0);
        assert_eq!(MoveRange::derived(&parameters, 3.0).deg, 10.0);
        parameters.profile.velocity = 6.0;
        assert_eq!(MoveRange::derived(&parameters, 3.0).deg, 6.0);
        parameters.profile.acceleration = 16.0;
        assert_eq!(MoveRange::derived(&parameters, 3.0).deg, 4.0);
        (parameters.limits.position_min, parameters.limits.position_max) = (-4.0, 5.0);
        assert!((MoveRange::derived(&parameters, 3.0).deg - 1.8).abs() < 1e-12);
        assert_eq!(MoveRange::derived(&parameters, 6.0).deg, 0.0);
    }

    fn plan() -> simulator::experiment::RunPlan {
        let document = simulator::experiment::Document::open("step-response").unwrap();
        simulator::experiment::Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0)
    }
}
