//! Selects the samples of a log that the regression uses: those of a machine in motion.
//!
//! Left out are: standstill and creeping, below `max(0.05 v_99, 2 c fc)` with the speed v_99 that a
//! hundredth of the samples exceeds, the count c and the cut-off fc; the samples that the low-pass
//! mixes with them, `0.5/fc` on either side; the same around a saturated effort; and `1/fc` at the
//! ends of a stretch. At standstill the friction equals the effort, whatever that is. Below two
//! counts in a period of the cut-off, the staircase of the counts passes the low-pass.
//!
//! An effort counts as saturated while it holds its largest or smallest value for three samples or
//! more, if twice as many samples lie there as in the next fiftieth of its range, and if at most a
//! fifth of all samples do. An effort that switches between two values is not saturated.

use super::time_grid::TimeGrid;

/// Creeping speed as a share of the fast speed; below it friction differs (Stribeck, bristles).
pub const CREEPING: f64 = 0.05;

/// Creeping speed as a share of the fast speed, if the model has a Stribeck term.
pub const CREEPING_WITH_STRIBECK: f64 = 0.01;

/// Least speed, in counts per period of the cut-off.
const COUNTS: f64 = 2.0;

/// Largest creeping speed due to counts, as a share of the fast speed.
const MOST_OF_SPEED: f64 = 0.25;

/// Reach of the low-pass, in periods of the cut-off; the next one is tried if too few samples are
/// left.
pub const MIXED: [f64; 4] = [0.5, 0.35, 0.2, 0.1];

/// Least share of the moving samples that must be left.
const LEFT: f64 = 0.3;

/// Width of the band next to an end of the effort's range, as a share of the range.
const NEXT: f64 = 0.02;

/// Least ratio of samples at an end to samples in the band next to it. It is 0.5 for a sine in 100
/// codes, and 3 for one that is cut at 0.95.
const CROWDED: f64 = 2.0;

/// Largest share of samples at an end that counts as saturation.
const LARGEST_SHARE: f64 = 0.2;

/// Returns the speed below which a machine creeps, from the fast speed or from counts.
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

/// Returns the ends of the effort's range that count as saturated.
pub fn saturated(grid: &TimeGrid) -> [Option<f64>; 2] {
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

/// Samples that the regression uses.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// For each stretch and sample, whether it is used.
    pub used: Vec<Vec<bool>>,
    /// Share of the samples at standstill or creeping.
    pub standstill: f64,
    /// Share of the samples with a saturated effort.
    pub saturated: f64,
}

/// Selects the samples that are neither creeping nor saturated, nor mixed with such samples.
/// `reaches` are those of the low-pass, as in [`MIXED`].
pub fn gate(
    grid: &TimeGrid,
    velocities: &[&[f64]],
    [creeping, cut_off_hz]: [f64; 2],
    reaches: &[f64],
) -> Gate {
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
    for mixed in reaches {
        let reach = (mixed * period).ceil() as usize;
        used = grid
            .stretches
            .iter()
            .zip(velocities)
            .map(|(stretch, velocity)| {
                let shut =
                    |i: usize| velocity[i].abs() < creeping || is_saturated(stretch.effort[i]);
                let mut open = apart(velocity.len(), reach, |i| {
                    // The direction can change between two samples without a slow one.
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

/// Returns which of n samples are farther than `reach` from every excluded sample.
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
