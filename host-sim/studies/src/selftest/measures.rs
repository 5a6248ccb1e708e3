//! What a move is judged by, as far as a device shows it: positions are counts of its encoder, the
//! effort is what it says that it applies.
//!
//! | measure | over | meaning |
//! |---|---|---|
//! | settled | from the end of the set point's motion | time until the joint stays within 2 counts of the target |
//! | rest | last second | largest distance from the target |
//! | reversals | last second | retreats of more than a count from the last extreme |
//! | held effort | last second | root mean square: its square is the motor's heat |
//! | sticks | where the set point has more than half of its speed | times that the joint comes to a stop |
//! | sliding effort | there | mean of the effort in the sense of the motion: what friction costs |
//! | accelerating effort | where the set point has more than half of its acceleration | mean of the effort in the sense of the acceleration: what inertia costs |

use stiction::link::Sample;

use crate::device::signals::Signals;
use crate::ensemble::{self, BAND_COUNTS, Reversals, TrackingJudge};

/// The joint is judged at rest in so much time at the end of a move, s.
pub const REST_S: f64 = 1.0;

/// The signals that are looked at.
pub const SIGNALS: [&str; 6] = [
    "counts",
    "reference_velocity_deg_per_s",
    "reference_acceleration_deg_per_s2",
    "velocity_deg_per_s",
    "v_applied_v",
    "status",
];

/// A sum and how many there are in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    #[cfg(test)]
    pub(super) const fn of(value: f64) -> Self {
        Self { sum: value, count: 1 }
    }

    fn see(&mut self, value: f64) {
        (self.sum, self.count) = (self.sum + value, self.count + 1);
    }

    /// The mean; none of nothing.
    pub fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

impl std::iter::Sum for Mean {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self { sum: a.sum + b.sum, count: a.count + b.count })
    }
}

/// What a move has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Where it led to, deg.
    pub to_deg: f64,
    /// Time from the end of the set point's motion until the joint stays within 2 counts, s; none
    /// if it was outside at the end.
    pub settled_s: Option<f64>,
    /// Largest distance from the target in the last second, counts.
    pub rest_counts: f64,
    /// Reversals in the last second.
    pub reversals: u32,
    /// Stops on the way.
    pub sticks: u32,
    /// Root mean square of the effort in the last second, V.
    pub held_v: f64,
    /// Effort in the sense of the motion at more than half of the speed, V.
    pub sliding_v: Mean,
    /// Effort in the sense of the acceleration at more than half of it, V.
    pub accelerating_v: Mean,
}

/// Judges the samples of a move to `to_deg`; none if there are none.
pub fn measures(
    samples: &[Sample],
    signals: &Signals,
    to_deg: f64,
    [count_deg, sample_time_s]: [f64; 2],
) -> Option<Measures> {
    let first = samples.first()?.clock;
    let target = (to_deg / count_deg).round();
    let number = |sample: &Sample, place: usize| signals.number(sample, SIGNALS[place]);
    let time_s = |sample: &Sample| f64::from(sample.clock.wrapping_sub(first)) * sample_time_s;
    let top = |place| samples.iter().map(|one| number(one, place).abs()).fold(0.0, f64::max);
    let [speed, acceleration] = [top(1), top(2)];
    let moves = |sample: &&Sample| number(sample, 1) != 0.0;
    let over_s = samples.iter().rev().find(moves).map_or(0.0, time_s);
    let end_s = samples.last().map_or(0.0, time_s);
    let last = samples.len() as u32 - 1;
    let mut judge = TrackingJudge::new([0, last], speed);
    let mut found = Measures { to_deg, ..Measures::default() };
    let (mut reversals, mut square) = (Reversals::default(), Mean::default());
    let mut inside_since = None;
    for (k, sample) in (0..).zip(samples) {
        let [position, velocity, pull, measured, effort] =
            [0, 1, 2, 3, 4].map(|place| number(sample, place));
        let distance = (target - position).abs();
        if distance > BAND_COUNTS {
            inside_since = None;
        } else if inside_since.is_none() {
            inside_since = Some(time_s(sample));
        }
        judge.see(&ensemble::Sample {
            speed: velocity,
            speed_ratio: if velocity == 0.0 { 0.0 } else { measured / velocity },
            ..ensemble::Sample::default()
        });
        if velocity.abs() > 0.5 * speed {
            found.sliding_v.see(effort * velocity.signum());
        }
        if pull.abs() > 0.5 * acceleration {
            found.accelerating_v.see(effort * pull.signum());
        }
        if time_s(sample) > end_s - REST_S {
            found.rest_counts = found.rest_counts.max(distance);
            reversals.see(k, position);
            square.see(effort * effort);
        }
    }
    found.settled_s = inside_since.map(|since_s: f64| (since_s - over_s).max(0.0));
    found.reversals = reversals.count();
    found.sticks = judge.measures(sample_time_s).sticks;
    found.held_v = square.value().unwrap_or(0.0).sqrt();
    Some(found)
}

/// What all moves of a session come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Moves that did not settle.
    pub missed: u32,
    /// Mean settling of those that did, s.
    pub settled_s: Option<f64>,
    /// Largest rest error, counts.
    pub rest_counts: f64,
    /// Reversals of all moves.
    pub reversals: u32,
    /// Stops on the way of all moves.
    pub sticks: u32,
    /// Root mean square of the effort at rest, V.
    pub held_v: f64,
    /// Mean sliding effort, V.
    pub sliding_v: Option<f64>,
    /// Mean accelerating effort, V.
    pub accelerating_v: Option<f64>,
}

impl Figures {
    /// Sums up the moves of a session.
    pub fn of(moves: &[Measures]) -> Self {
        let mut settled = Mean::default();
        moves.iter().filter_map(|one| one.settled_s).for_each(|time_s| settled.see(time_s));
        let count = moves.len().max(1) as f64;
        Self {
            missed: moves.iter().filter(|one| one.settled_s.is_none()).count() as u32,
            settled_s: settled.value(),
            rest_counts: moves.iter().map(|one| one.rest_counts).fold(0.0, f64::max),
            reversals: moves.iter().map(|one| one.reversals).sum(),
            sticks: moves.iter().map(|one| one.sticks).sum(),
            held_v: (moves.iter().map(|one| one.held_v.powi(2)).sum::<f64>() / count).sqrt(),
            sliding_v: moves.iter().map(|one| one.sliding_v).sum::<Mean>().value(),
            accelerating_v: moves.iter().map(|one| one.accelerating_v).sum::<Mean>().value(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::signal::index;

    /// A sample in a core that has every signal; its values stand in the order of the places.
    fn sample(clock: u32, values: [f64; 5]) -> Sample {
        let [counts, velocity, acceleration, measured, applied] = values;
        let mut all = [
            (index("counts"), (counts as i32).to_le_bytes()),
            (index("reference_velocity"), (velocity as f32).to_le_bytes()),
            (index("reference_acceleration"), (acceleration as f32).to_le_bytes()),
            (index("velocity"), (measured as f32).to_le_bytes()),
            (index("v_applied"), (applied as f32).to_le_bytes()),
        ];
        all.sort_by_key(|(place, _)| *place);
        let signals = all.iter().fold(0, |mask, (place, _)| mask | 1 << place);
        Sample { number: 0, clock, signals, values: all.iter().flat_map(|(_, b)| *b).collect() }
    }

    /// A second of set point at 100 counts a second, a joint that is behind by 0.25 s and rests at
    /// 99 for the other two; 0.5 V for friction, 0.3 V for a begin and an end of 0.1 s.
    fn moved(sticks_at_s: f64) -> Measures {
        let samples: Vec<Sample> = (0..400)
            .map(|k| {
                let t = f64::from(k) * 0.01;
                let velocity = if t < 1.0 { 1.0 } else { 0.0 };
                let pull = if t < 0.1 {
                    10.0
                } else if (0.9..1.0).contains(&t) {
                    -10.0
                } else {
                    0.0
                };
                let counts = (100.0 * (t - 0.25)).clamp(0.0, 99.0).floor();
                let sticks = (sticks_at_s..sticks_at_s + 0.05).contains(&t);
                let measured = if sticks || t < 0.25 { 0.0 } else { 1.0 };
                let applied = if t < 1.0 { 0.5 + 0.03 * pull } else { 0.2 };
                sample(7 + 10 * k, [counts, velocity, pull, measured, applied])
            })
            .collect();
        measures(&samples, &Signals::of_core(), 1.0, [0.01, 0.001]).unwrap()
    }

    #[test]
    fn a_move_is_judged_by_the_formulas_of_the_table() {
        let found = moved(0.5);
        // Within 2 counts of 100 from 98 on, at 1.23 s; the set point's last motion is at 0.99 s.
        assert!((found.settled_s.unwrap() - 0.24).abs() < 0.011, "{found:?}");
        assert_eq!((found.rest_counts, found.reversals, found.sticks), (1.0, 0, 1));
        assert!((found.held_v - 0.2).abs() < 1e-6);
        // Begin and end of 0.3 V cancel in one, and friction in the other.
        assert!((found.sliding_v.value().unwrap() - 0.5).abs() < 1e-6, "{found:?}");
        assert!((found.accelerating_v.value().unwrap() - 0.3).abs() < 1e-6, "{found:?}");
        assert_eq!(moved(9.0).sticks, 0);
    }

    #[test]
    fn figures_of_moves_are_sums_means_and_the_worst() {
        let one = Measures { settled_s: Some(0.2), rest_counts: 1.0, held_v: 0.3, ..moved(0.5) };
        let two = Measures { settled_s: None, rest_counts: 9.0, held_v: 0.4, ..moved(9.0) };
        let figures = Figures::of(&[one, two]);
        assert_eq!((figures.missed, figures.settled_s), (1, Some(0.2)));
        assert_eq!((figures.rest_counts, figures.sticks), (9.0, 1));
        assert!((figures.held_v - 0.125f64.sqrt()).abs() < 1e-12);
        assert!((figures.sliding_v.unwrap() - 0.5).abs() < 1e-6);
    }
}
