//! Measures of a move from the samples of a device: positions are counts of its encoder, the effort
//! is the reported output.
//!
//! | measure | over | meaning |
//! |---|---|---|
//! | settled | from the end of the set point's motion | time until the joint stays within the goal's tolerance, 2 counts by default |
//! | rest | last second | largest distance from the target |
//! | reversals | last second | retreats of more than a count from the last extreme |
//! | held effort | last second | root mean square: its square is the motor's heat |
//! | sticks | where the set point has more than half of its speed | times that the joint comes to a stop |
//! | sliding effort | as for sticks | mean effort in the sense of the motion: that of friction |
//! | accelerating effort | where the set point has more than half of its acceleration | mean of the effort in the sense of the acceleration: what inertia costs |
//!
//! Settling and rest are measured at the encoder. A simulated device reports its load as well; for
//! it, both are also measured at the load ([`AtLoad`]).

use stiction::link::Sample;

use crate::ensemble::{self, Reversals, TrackingJudge};
use files::goal::PositionGoal;
use simulator::device::signals::Signals;
use simulator::settling::Settling;

/// Time at the end of a move in which the joint is judged at rest, s.
pub const REST_S: f64 = 1.0;

/// Signals that the measures need.
pub const SIGNALS: [&str; 6] = [
    "counts",
    "reference_velocity_deg_per_s",
    "reference_acceleration_deg_per_s2",
    "velocity_deg_per_s",
    "v_applied_v",
    "status",
];

/// Mean of values, as sum and count.
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

    /// Returns the mean; `None` without values.
    pub fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

impl std::iter::Sum for Mean {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self { sum: a.sum + b.sum, count: a.count + b.count })
    }
}

/// Settling and rest of a move at the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AtLoad {
    /// Time from the end of the set point's motion until the load stays within the goal's
    /// tolerance, s; `None` if it does not stay.
    pub settled_s: Option<f64>,
    /// Whether the load settled later than the goal allows.
    pub is_late: bool,
    /// Largest distance from the target in the last second, counts.
    pub rest_counts: f64,
}

impl AtLoad {
    /// Returns whether the load met the goal.
    pub const fn success(&self) -> bool {
        self.settled_s.is_some() && !self.is_late
    }
}

/// Measures of a move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MoveMeasures {
    /// Target, deg.
    pub to_deg: f64,
    /// Time from the end of the set point's motion until the encoder's side stays within the goal's
    /// tolerance, s; `None` if it does not stay.
    pub settled_s: Option<f64>,
    /// Whether the encoder's side settled later than the goal allows.
    pub is_late: bool,
    /// Measures at the load; `None` if the device does not report its load.
    pub at_load: Option<AtLoad>,
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

impl MoveMeasures {
    /// Returns whether the encoder's side met the goal.
    pub const fn success(&self) -> bool {
        self.settled_s.is_some() && !self.is_late
    }
}

/// Measures a move to `to_deg` from its samples, by a goal; `None` without samples.
/// `load_ahead_deg` is the load's angle minus that of the encoder's side in each sample, deg, if
/// the device reports it.
pub fn measures(
    samples: &[Sample],
    load_ahead_deg: &[Option<f64>],
    signals: &Signals,
    (to_deg, goal): (f64, &PositionGoal),
    [count_deg, sample_time_s]: [f64; 2],
) -> Option<MoveMeasures> {
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
    let mut found = MoveMeasures { to_deg, ..MoveMeasures::default() };
    let (mut reversals, mut square) = (Reversals::default(), Mean::default());
    let mut sides = [Settling::new(goal, count_deg); 2];
    let mut at_load = Some(AtLoad::default());
    for (k, sample) in (0..).zip(samples) {
        let [position, velocity, pull, measured, effort] =
            [0, 1, 2, 3, 4].map(|place| number(sample, place));
        let distance = (target - position).abs();
        let ahead_deg = load_ahead_deg.get(k as usize).copied().flatten();
        // A move is judged at the load only if all its samples have the load.
        at_load = at_load.filter(|_| ahead_deg.is_some());
        let at_the_load = target - position - ahead_deg.unwrap_or(f64::NAN) / count_deg;
        if time_s(sample) >= over_s {
            sides[0].see(time_s(sample), target - position);
            sides[1].see(time_s(sample), at_the_load);
        }
        judge.see(&ensemble::CaseSample {
            speed: velocity,
            speed_ratio: if velocity == 0.0 { 0.0 } else { measured / velocity },
            ..ensemble::CaseSample::default()
        });
        if velocity.abs() > 0.5 * speed {
            found.sliding_v.see(effort * velocity.signum());
        }
        if pull.abs() > 0.5 * acceleration {
            found.accelerating_v.see(effort * pull.signum());
        }
        if time_s(sample) > end_s - REST_S {
            found.rest_counts = found.rest_counts.max(distance);
            if let Some(load) = &mut at_load {
                load.rest_counts = load.rest_counts.max(at_the_load.abs());
            }
            reversals.see(k, position);
            square.see(effort * effort);
        }
    }
    let settled = sides.map(|side| side.settled_s().map(|at_s| (at_s - over_s).max(0.0)));
    let is_late = sides.map(|side| side.settled_s().is_some() && !side.is_success(over_s));
    (found.settled_s, found.is_late) = (settled[0], is_late[0]);
    found.at_load =
        at_load.map(|load| AtLoad { settled_s: settled[1], is_late: is_late[1], ..load });
    found.reversals = reversals.count();
    found.sticks = judge.measures(sample_time_s).sticks;
    found.held_v = square.value().unwrap_or(0.0).sqrt();
    Some(found)
}

/// Summary of all moves of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SessionFigures {
    /// Number of moves that missed the goal at the encoder.
    pub missed: u32,
    /// Number of moves that missed the goal at the load; `None` if a move has no measures there.
    pub missed_at_load: Option<u32>,
    /// Mean settling time of the moves that settled, s.
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

impl SessionFigures {
    /// Summarizes the moves of a session.
    pub fn of(moves: &[MoveMeasures]) -> Self {
        let mut settled = Mean::default();
        moves.iter().filter_map(|one| one.settled_s).for_each(|time_s| settled.see(time_s));
        let count = moves.len().max(1) as f64;
        Self {
            missed: moves.iter().filter(|one| !one.success()).count() as u32,
            missed_at_load: moves.iter().try_fold(0, |missed, one| {
                one.at_load.map(|load| missed + u32::from(!load.success()))
            }),
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
    use stiction::control::signal::index;

    /// Returns a sample of a core with every signal. Its values are in the order of the signals'
    /// indices.
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

    /// Returns the measures of a move of 4 s. The set point moves at 100 counts/s for 1 s; the
    /// joint follows 0.25 s later, and rests at 99 counts. The effort is 0.5 V for friction, plus
    /// or minus 0.3 V while the set point starts or stops, for 0.1 s each.
    fn moved(sticks_at_s: f64) -> MoveMeasures {
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
        judged(&samples, &[], PositionGoal::default())
    }

    fn judged(samples: &[Sample], ahead: &[Option<f64>], goal: PositionGoal) -> MoveMeasures {
        measures(samples, ahead, &Signals::of_core(), (1.0, &goal), [0.01, 0.001]).unwrap()
    }

    /// The encoder arrives 0.2 s after the set point, at 100 of 100 counts; the load stays 40
    /// counts behind it.
    #[test]
    fn a_move_is_judged_at_the_load_where_it_is_known_in_every_sample() {
        let samples: Vec<Sample> = (0..300)
            .map(|k| {
                let t = f64::from(k) * 0.01;
                let velocity = if t < 1.0 { 1.0 } else { 0.0 };
                let counts = if t < 1.185 { 50.0 } else { 100.0 };
                sample(7 + 10 * k, [counts, velocity, 0.0, velocity, 0.0])
            })
            .collect();
        let mut ahead = vec![Some(-0.4); samples.len()];
        let found = judged(&samples, &ahead, PositionGoal::default());
        let at_load = found.at_load.unwrap();
        assert!(found.success() && (found.settled_s.unwrap() - 0.2).abs() < 1e-6, "{found:?}");
        assert_eq!((at_load.settled_s, at_load.success()), (None, false));
        assert!((at_load.rest_counts - 40.0).abs() < 1e-9);
        // The file's goal decides: a tolerance that the load keeps, and a time that is too short.
        let wide = PositionGoal { tolerance_deg: Some(0.401), ..PositionGoal::default() };
        assert!(judged(&samples, &ahead, wide).at_load.unwrap().success());
        let soon = PositionGoal { settle_s: Some(0.19), ..wide };
        let late = judged(&samples, &ahead, soon);
        assert!(!late.success() && late.is_late && !late.at_load.unwrap().success());
        let figures = SessionFigures::of(&[found, late]);
        assert_eq!((figures.missed, figures.missed_at_load), (1, Some(2)));
        ahead[150] = None;
        let unknown = judged(&samples, &ahead, wide);
        assert_eq!(
            (unknown.at_load, SessionFigures::of(&[found, unknown]).missed_at_load),
            (None, None)
        );
    }

    #[test]
    fn a_move_is_judged_by_the_formulas_of_the_table() {
        let found = moved(0.5);
        // Within 2 counts of 100 from 98 on, at 1.23 s; the set point's last motion is at 0.99 s.
        assert!((found.settled_s.unwrap() - 0.24).abs() < 0.011, "{found:?}");
        assert_eq!((found.rest_counts, found.reversals, found.sticks), (1.0, 0, 1));
        assert!((found.held_v - 0.2).abs() < 1e-6);
        // The 0.3 V of start and stop cancel in the sliding effort, and friction cancels in the
        // accelerating effort.
        assert!((found.sliding_v.value().unwrap() - 0.5).abs() < 1e-6, "{found:?}");
        assert!((found.accelerating_v.value().unwrap() - 0.3).abs() < 1e-6, "{found:?}");
        assert_eq!(moved(9.0).sticks, 0);
    }

    #[test]
    fn figures_of_moves_are_sums_means_and_the_worst() {
        let one =
            MoveMeasures { settled_s: Some(0.2), rest_counts: 1.0, held_v: 0.3, ..moved(0.5) };
        let two = MoveMeasures { settled_s: None, rest_counts: 9.0, held_v: 0.4, ..moved(9.0) };
        let figures = SessionFigures::of(&[one, two]);
        assert_eq!((figures.missed, figures.settled_s), (1, Some(0.2)));
        assert_eq!((figures.rest_counts, figures.sticks), (9.0, 1));
        assert!((figures.held_v - 0.125f64.sqrt()).abs() < 1e-12);
        assert!((figures.sliding_v.unwrap() - 0.5).abs() < 1e-6);
    }
}
