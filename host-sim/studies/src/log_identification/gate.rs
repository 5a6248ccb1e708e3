//! Which moments of a log tell something of a machine in motion.
//!
//! Left out are: standstill and creeping, below `max(0.05 v_99, 2 c fc)` with the speed v_99 that a
//! hundredth of the samples exceeds, the count c and the cut-off fc; what the low-pass mixes with
//! them, `0.5/fc` on either side; the same around a saturated effort; and `1/fc` at the ends of a
//! stretch. At standstill friction is whatever the effort is. Below two counts in a period of the
//! cut-off, the staircase of the counts passes the low-pass.
//!
//! An effort counts as saturated where it holds its largest or its smallest value for three samples
//! or more, if twice as many samples lie there as in the next fiftieth of its range, and if at most
//! a fifth of all samples do. An effort that is switched between two values is known, not
//! saturated.

use super::time_grid::Grid;

/// Part of the fast end of the speeds below which a machine creeps, and its friction is another one
/// (Stribeck, bristles).
pub const CREEPING: f64 = 0.05;

/// The same, if the model has a Stribeck term.
pub const CREEPING_WITH_STRIBECK: f64 = 0.01;

/// A count's speed is this many counts in a period of the cut-off.
const COUNTS: f64 = 2.0;

/// The count's bound on the speed does not take more than this part of the speeds.
const MOST_OF_SPEED: f64 = 0.25;

/// How far the low-pass mixes moments, in periods of the cut-off; less, if too little is left.
const MIXED: [f64; 4] = [0.5, 0.35, 0.2, 0.1];

/// Part of the moving samples that is to be left.
const LEFT: f64 = 0.3;

/// Part of an effort's range next to its ends.
const NEXT: f64 = 0.02;

/// So many times as many samples lie at the end as next to it. Of a sine in a hundred codes it is a
/// half, of one that is cut at 0.95 it is 3.
const CROWDED: f64 = 2.0;

/// A larger share at an end is no saturation.
const LARGEST_SHARE: f64 = 0.2;

/// The speed below which a machine creeps: a part of the fast ones, or that of counts.
pub fn creeping(velocities: &[&[f64]], part: f64, count: f64, cut_off_hz: f64) -> f64 {
    let mut speeds: Vec<f64> =
        velocities.iter().flat_map(|part| part.iter().map(|v| v.abs())).collect();
    if speeds.is_empty() {
        return 0.0;
    }
    let place = (speeds.len() * 99 / 100).min(speeds.len() - 1);
    let fast = *speeds.select_nth_unstable_by(place, f64::total_cmp).1;
    (part * fast).max((COUNTS * count * cut_off_hz).min(MOST_OF_SPEED * fast))
}

/// The ends of the effort's range that count as saturated.
pub fn saturated(grid: &Grid) -> [Option<f64>; 2] {
    let all = || grid.stretches.iter().flat_map(|one| one.effort.iter().copied());
    let low = all().fold(f64::INFINITY, f64::min);
    let high = all().fold(f64::NEG_INFINITY, f64::max);
    let next = NEXT * (high - low);
    let count = |is: &dyn Fn(f64) -> bool| all().filter(|effort| is(*effort)).count() as f64;
    let total = all().count() as f64;
    [low, high].map(|end| {
        let at = count(&|effort| effort == end);
        let beside = count(&|effort| effort != end && (effort - end).abs() < next);
        let is_saturated = at >= 3.0 && at <= LARGEST_SHARE * total && at > CROWDED * beside;
        let holds = grid.stretches.iter().any(|one| {
            one.effort.windows(3).any(|three| three.iter().all(|effort| *effort == end))
        });
        (is_saturated && holds && beside > 0.0 && high > low).then_some(end)
    })
}

/// What a gate leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// For each stretch, whether a sample is used.
    pub used: Vec<Vec<bool>>,
    /// Part of the samples that stand still or creep.
    pub standstill: f64,
    /// Part of the samples whose effort is saturated.
    pub saturated: f64,
}

/// Opens the gate for what is neither creeping nor saturated, nor mixed with either.
pub fn gate(grid: &Grid, velocities: &[&[f64]], creeping: f64, cut_off_hz: f64) -> Gate {
    let period = 1.0 / (cut_off_hz * grid.step_s);
    let ends = saturated(grid);
    let is_saturated = |effort: f64| ends.contains(&Some(effort));
    let total: usize = velocities.iter().map(|part| part.len()).sum();
    let share = |count: usize| count as f64 / total.max(1) as f64;
    let still = velocities.iter().flat_map(|part| part.iter()).filter(|v| v.abs() < creeping);
    let still = still.count();
    let efforts = grid.stretches.iter().flat_map(|one| one.effort.iter());
    let cut = efforts.filter(|effort| is_saturated(**effort)).count();
    let mut used = Vec::new();
    for mixed in MIXED {
        let reach = (mixed * period).ceil() as usize;
        used = grid
            .stretches
            .iter()
            .zip(velocities)
            .map(|(stretch, velocity)| {
                let shut =
                    |i: usize| velocity[i].abs() < creeping || is_saturated(stretch.effort[i]);
                let mut open = apart(velocity.len(), reach, |i| {
                    // From one sample to the next the direction may change without a slow one.
                    shut(i) || i > 0 && velocity[i] * velocity[i - 1] < 0.0
                });
                let edge = (period.ceil() as usize).min(open.len());
                let end = open.len() - edge;
                open[..edge].fill(false);
                open[end..].fill(false);
                open
            })
            .collect();
        let left = used.iter().flatten().filter(|open| **open).count();
        if left as f64 >= LEFT * (total - still) as f64 {
            break;
        }
    }
    Gate { used, standstill: share(still), saturated: share(cut) }
}

/// Which of n samples are farther than `reach` from every sample that is shut.
fn apart(n: usize, reach: usize, is_shut: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut open = vec![true; n];
    let mut since = usize::MAX;
    for (i, open) in open.iter_mut().enumerate() {
        since = if is_shut(i) { 0 } else { since.saturating_add(1) };
        *open = since > reach;
    }
    since = usize::MAX;
    for (i, open) in open.iter_mut().enumerate().rev() {
        since = if is_shut(i) { 0 } else { since.saturating_add(1) };
        *open &= since > reach;
    }
    open
}
