//! Where the moves lead: long ones over the whole range, and short ones among friction.

use stiction::Parameters;

/// Fractional part of the golden ratio: its multiples fill a range evenly, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// A short move is this share of the range.
const SHORT: f64 = 1.0 / 50.0;

/// But no shorter than this, counts: twice the band within which a joint counts as settled.
const SHORTEST_COUNTS: f64 = 4.0;

/// A range that nobody has asked for is no wider than this, deg: most joints have so much room.
const MOST_DEG: f64 = 10.0;

/// Share of the room between the limits of the position that is used.
pub(super) const ROOM: f64 = 0.9;

/// The range of the moves to either side of where the joint is armed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveRange {
    /// The farthest target, deg.
    pub deg: f64,
    /// An angle of a count, deg.
    pub count_deg: f64,
}

impl MoveRange {
    /// Derives the range from a device's limits: as far as a profiled move from rest to rest goes
    /// in a second, `min(v, a / 4)`, but no more than 10 deg, and no farther than the limits of the
    /// position leave room around `position_deg`, where the joint is.
    pub fn derived(parameters: &Parameters, position_deg: f64) -> Self {
        let Parameters { profile, controller, .. } = parameters;
        let in_a_second = f64::from(profile.velocity).min(0.25 * f64::from(profile.acceleration));
        let deg = in_a_second.min(MOST_DEG).min(ROOM * room(parameters, position_deg));
        Self { deg, count_deg: controller.encoder.resolution.into() }
    }

    /// The least range of moves that are long and short: ten times the shortest.
    pub fn least_deg(&self) -> f64 {
        10.0 * SHORTEST_COUNTS * self.count_deg
    }
}

/// The longest way of one of the moves, deg; the first begins at zero.
pub fn longest_way(targets: &[f64]) -> f64 {
    let from = std::iter::once(&0.0).chain(targets);
    from.zip(targets).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
}

/// The room between the limits of the position on the nearer side, deg.
pub fn room(parameters: &Parameters, position_deg: f64) -> f64 {
    let [least, most] =
        [parameters.limits.position_min, parameters.limits.position_max].map(f64::from);
    if least == 0.0 && most == 0.0 {
        return f64::INFINITY;
    }
    (most - position_deg).min(position_deg - least).max(0.0)
}

/// The targets of `count` moves in the zero of the arming, deg, on whole counts.
///
/// The first, third and so on lead over the range: to `R (2 frac(n g) - 1)` with the golden ratio
/// g. Each between them is short, `R / 50` (at least 4 counts) onwards and back by turns: there a
/// joint sticks before it slides. The last one leads back to zero.
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
                // Towards the middle, so that no short move leads out of the range.
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
            ..crate::experiment::for_a_device(&plan()).unwrap()
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

    fn plan() -> crate::experiment::RunPlan {
        let document = crate::experiment::Document::open("step-response").unwrap();
        crate::experiment::Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0)
    }
}
