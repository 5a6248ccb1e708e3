//! Resamples a log to even time steps: rounded times, jitter, lost rows and gaps.
//!
//! ```text
//! h      the median of the steps
//! gap    a step above 4.5 h: the parts before and after it are filtered separately
//! jump   a step of the position above 0.02 of its range and 20 times the steps beside it: as a gap
//! even   |t_i - (t_0 + i h)| <= 1 in the last digit that is written, or 0.02 h: taken as t_0 + i h
//! else   interpolated onto t_0 + i h: the position by the cubic through four points (Lagrange),
//!        the effort by a straight line
//! ```
//!
//! Reason: an exact sample time with rounded time stamps would look like jitter, and jitter
//! differentiated twice is noise. Limits: time stamps that jitter while the samples do not, such as
//! those of a computer that reads a bus, are used unchanged.

use std::borrow::Cow;

use super::reading::MotionLog;

/// Least time step of a gap, in ordinary steps.
const GAP: f64 = 4.5;

/// Least jump of the position, as a share of its range.
const JUMP_OF_RANGE: f64 = 0.02;
/// Least ratio of a jump to the steps beside it.
const JUMP_OF_STEPS: f64 = 20.0;
/// Distances from a jump to the steps beside it, samples. The nearest step is skipped: it can be
/// half of the jump.
const BESIDE: [usize; 3] = [2, 3, 4];

/// Largest jitter of even steps, as a share of a step.
const EVEN: f64 = 0.02;

/// Least distance of neighbours for cubic interpolation, as a share of a step.
const TOO_NEAR: f64 = 0.2;

/// A stretch without gaps, in even steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Time of its first sample, s.
    pub begin_s: f64,
    /// Position of each sample.
    pub position: Vec<f64>,
    /// Effort of each sample.
    pub effort: Vec<f64>,
    /// Position of the other side of a gear at each sample; empty if the log has one side.
    pub beside: Vec<f64>,
    /// Correction of the effort to that of one rigid body; empty without a gear.
    pub carried: Vec<f64>,
}

impl Stretch {
    /// Returns the effort with its correction to that of one rigid body.
    pub fn driving(&self) -> Cow<'_, [f64]> {
        if self.carried.is_empty() {
            return Cow::Borrowed(&self.effort);
        }
        Cow::Owned(self.effort.iter().zip(&self.carried).map(|(one, other)| one + other).collect())
    }
}

/// A log in even steps.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeGrid {
    /// Time between samples, s.
    pub step_s: f64,
    /// Parts between gaps and jumps.
    pub stretches: Vec<Stretch>,
    /// Number of gaps.
    pub gaps: usize,
    /// Start of the first gap, s.
    pub first_gap_s: Option<f64>,
    /// Times at which the position jumps, s; the parts before and after are filtered separately.
    pub jumps_s: Vec<f64>,
    /// Whether samples were interpolated.
    pub is_interpolated: bool,
}

impl TimeGrid {
    /// Creates the grid of a log with columns in SI units.
    ///
    /// # Errors
    /// Returns a sentence if the times do not increase.
    pub fn of(log: &MotionLog, time_digit_s: f64) -> Result<Self, String> {
        let mut steps: Vec<f64> = log.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        // The median can be 0 if times are rounded to more than a step.
        let span =
            log.time.last().copied().unwrap_or(0.0) - log.time.first().copied().unwrap_or(0.0);
        let mean = span / (log.time.len() - 1) as f64;
        let step = if log.first_equal.is_some() { mean } else { median };
        if !(step > 0.0 && step.is_finite()) {
            return Err("the time does not increase; name the column of the time".into());
        }
        let gap = GAP * step + time_digit_s;
        let mut bounds = vec![0];
        let gaps: Vec<usize> =
            (1..log.time.len()).filter(|i| log.time[*i] - log.time[i - 1] > gap).collect();
        let first_gap_s = gaps.first().map(|i| log.time[i - 1]);
        let of_motor = if log.has_motor_current { Vec::new() } else { jumps(&log.motor) };
        let mut jumps = [jumps(&log.position), of_motor].concat();
        jumps.sort_unstable();
        jumps.dedup();
        // In means of several rows, one jump can become two.
        let jumps_s: Vec<f64> = jumps
            .iter()
            .filter(|i| jumps.binary_search(&(*i - 1)).is_err() && gaps.binary_search(i).is_err())
            .map(|i| log.time[*i])
            .collect();
        bounds.extend(&gaps);
        bounds.extend(&jumps);
        bounds.sort_unstable();
        bounds.dedup();
        bounds.push(log.time.len());
        let gaps = gaps.len();
        let parts: Vec<[usize; 2]> = bounds.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        // The mean step over the whole log, without its gaps.
        let (mut time, mut count) = (0.0, 0.0);
        for [from, to] in &parts {
            let span = log.time[to - 1] - log.time[*from];
            let steps = (span / step).round();
            if steps as usize + 1 == to - from {
                (time, count) = (time + span, count + steps);
            }
        }
        let step_s = if count > 0.0 { time / count } else { step };
        let mut grid = Self {
            step_s,
            stretches: Vec::new(),
            gaps,
            first_gap_s,
            jumps_s,
            is_interpolated: false,
        };
        for part in parts {
            let is_even = is_even(&log.time[part[0]..part[1]], step_s, time_digit_s);
            if !is_even && let Some(row) = log.first_equal {
                return Err(format!(
                    "row {row}: its time equals that of the row before; times must increase, or \
                     be rounded from even steps"
                ));
            }
            grid.is_interpolated |= !is_even;
            if part[1] - part[0] > 1 {
                grid.stretches.push(stretch(log, part, step_s, is_even));
            }
        }
        Ok(grid)
    }
}

/// Returns the indices of the first samples after each jump of the position.
fn jumps(position: &[f64]) -> Vec<usize> {
    let (low, high) = position
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(*q), high.max(*q)));
    let least = JUMP_OF_RANGE * (high - low);
    let step =
        |i: usize| position.get(i).zip(position.get(i.wrapping_sub(1))).map(|(b, a)| (b - a).abs());
    let is_jump = |i: &usize| {
        let own = step(*i).unwrap_or(0.0);
        own > least && {
            let beside = BESIDE.iter().flat_map(|far| [step(i + far), step(i.wrapping_sub(*far))]);
            own > JUMP_OF_STEPS * beside.flatten().fold(0.0, f64::max)
        }
    };
    (1..position.len()).filter(is_jump).collect()
}

/// Returns whether the samples are `step` (s) apart, within the larger of a small jitter and the
/// resolution of the times, `digit` (s).
fn is_even(time: &[f64], step: f64, digit: f64) -> bool {
    let Some(first) = time.first() else { return true };
    // Half of the last digit at either end, and rounding in binary.
    let allowed = (1.01 * digit).max(EVEN * step);
    let line = |i: usize| first + step * i as f64;
    time.iter().enumerate().all(|(i, at)| (at - line(i)).abs() <= allowed)
}

fn stretch(log: &MotionLog, [from, to]: [usize; 2], step: f64, is_even: bool) -> Stretch {
    let [time, position, effort] =
        [&log.time, &log.position, &log.effort].map(|series| &series[from..to]);
    let beside = log.motor.get(from..to).unwrap_or_default();
    let begin_s = time.first().copied().unwrap_or(0.0);
    if is_even {
        let [position, effort, beside] = [position, effort, beside].map(<[f64]>::to_vec);
        return Stretch { begin_s, position, effort, beside, carried: Vec::new() };
    }
    let end = time.last().copied().unwrap_or(begin_s);
    let count = ((end - begin_s) / step + 1e-9).floor() as usize + 1;
    let mut place = 0;
    let [positions, efforts] = [0; 2].map(|_| Vec::with_capacity(count));
    let mut even = Stretch {
        begin_s,
        position: positions,
        effort: efforts,
        beside: Vec::new(),
        carried: Vec::new(),
    };
    for i in 0..count {
        let at = begin_s + step * i as f64;
        while place + 2 < time.len() && time[place + 1] < at {
            place += 1;
        }
        even.position.push(cubic(time, position, place, at, step));
        even.effort.push(linear(time, effort, place, at));
        if !beside.is_empty() {
            even.beside.push(cubic(time, beside, place, at, step));
        }
    }
    even
}

fn linear(time: &[f64], values: &[f64], place: usize, at: f64) -> f64 {
    let share = (at - time[place]) / (time[place + 1] - time[place]);
    values[place] + share * (values[place + 1] - values[place])
}

/// Interpolates by the cubic through the four samples around a time, or linearly if there are
/// fewer.
fn cubic(time: &[f64], values: &[f64], place: usize, at: f64, step: f64) -> f64 {
    let four = place.checked_sub(1).and_then(|first| time.get(first..first + 4));
    let Some(t) = four.filter(|t| t.windows(2).all(|two| two[1] - two[0] > TOO_NEAR * step)) else {
        return linear(time, values, place, at);
    };
    let mut sum = 0.0;
    for i in 0..4 {
        let others = (0..4).filter(|j| *j != i);
        let weight: f64 = others.map(|j| (at - t[j]) / (t[i] - t[j])).product();
        sum += weight * values[place - 1 + i];
    }
    sum
}
