//! Filtered log, and the rows of the regression.

use super::butterworth::LowPass;
use super::derivative::derivatives;
use super::gate::{self, Gate};
use super::model::RegressionSample;
use super::time_grid::TimeGrid;

/// Rows per period of the cut-off; more rows add no information.
const ROWS_A_PERIOD: f64 = 10.0;

/// Largest number of rows.
const MOST_ROWS: usize = 200_000;

/// A filtered stretch.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredStretch {
    /// Position.
    pub position: Vec<f64>,
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
    /// Direction, -1 to 1.
    pub direction: Vec<f64>,
    /// Effort.
    pub effort: Vec<f64>,
}

/// A filtered log.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredLog {
    /// Cut-off, Hz.
    pub cut_off_hz: f64,
    /// Speed below which the machine creeps.
    pub creeping: f64,
    /// Stretches of the grid.
    pub stretches: Vec<FilteredStretch>,
    /// Samples that the regression uses.
    pub gate: Gate,
    step_s: f64,
    begins_s: Vec<f64>,
}

impl FilteredLog {
    /// Filters a log. `slow` is the creeping speed as a share of the fast speed, `count` the size
    /// of a count of the position.
    pub fn of(grid: &TimeGrid, filter: [f64; 3]) -> Self {
        Self::within(grid, filter, &gate::MIXED)
    }

    /// Filters a log as [`of`](Self::of) does, with these reaches of the low-pass for the gate.
    pub fn within(grid: &TimeGrid, [slow, count, cut_off_hz]: [f64; 3], reaches: &[f64]) -> Self {
        let h = grid.step_s;
        let low_pass = LowPass::new(cut_off_hz * h);
        let mut stretches: Vec<FilteredStretch> = grid
            .stretches
            .iter()
            .map(|stretch| {
                let position = low_pass.apply(&stretch.position);
                let [velocity, acceleration] = derivatives(&position, h);
                let effort = low_pass.apply(&stretch.driving());
                FilteredStretch { position, velocity, acceleration, direction: Vec::new(), effort }
            })
            .collect();
        let velocities: Vec<&[f64]> = stretches.iter().map(|one| &one.velocity[..]).collect();
        let creeping = gate::creeping(&velocities, slow, count, cut_off_hz);
        let gate = gate::gate(grid, &velocities, [creeping, cut_off_hz], reaches);
        for smooth in &mut stretches {
            let signs: Vec<f64> = smooth.velocity.iter().map(|v| v.signum()).collect();
            smooth.direction = low_pass.apply(&signs);
        }
        let begins_s = grid.stretches.iter().map(|one| one.begin_s).collect();
        Self { cut_off_hz, creeping, stretches, gate, step_s: h, begins_s }
    }

    /// Returns the number of samples between two rows of the regression.
    fn stride(&self) -> usize {
        let used: usize = self.gate.used.iter().flatten().filter(|used| **used).count();
        let stride = 1.0 / (self.cut_off_hz * self.step_s * ROWS_A_PERIOD);
        (stride as usize).max(used.div_ceil(MOST_ROWS)).max(1)
    }

    /// Returns the number of independent rows among `rows`: two per period of the cut-off.
    pub fn independent(&self, rows: usize) -> f64 {
        let periods = self.cut_off_hz * self.step_s * self.stride() as f64;
        (rows as f64 * (2.0 * periods).min(1.0)).max(2.0)
    }

    /// Returns a series, filtered by the low-pass of this log.
    pub fn low_pass(&self, series: &[f64]) -> Vec<f64> {
        LowPass::new(self.cut_off_hz * self.step_s).apply(series)
    }

    /// Returns the indices of stretch and sample of each row of the regression.
    pub fn places(&self) -> Vec<[usize; 2]> {
        let stride = self.stride();
        let of = |(stretch, used): (usize, &Vec<bool>)| {
            let places = (0..used.len()).step_by(stride).filter(|i| used[*i]);
            places.map(|i| [stretch, i]).collect::<Vec<_>>()
        };
        self.gate.used.iter().enumerate().flat_map(of).collect()
    }

    /// Returns the effort at a place, if it acts `delay_s` later than in the log.
    pub fn effort(&self, [stretch, sample]: [usize; 2], delay_s: f64) -> f64 {
        earlier(&self.stretches[stretch].effort, sample, delay_s / self.step_s)
    }

    /// Returns the rows of the regression for an effort that acts `delay_s` later than in the log.
    pub fn moments(&self, delay_s: f64) -> Vec<RegressionSample> {
        let stride = self.stride();
        let mut moments = Vec::new();
        for ((smooth, used), begin) in
            self.stretches.iter().zip(&self.gate.used).zip(&self.begins_s)
        {
            let mut way = Way::new(self.creeping);
            for (i, used) in used.iter().enumerate() {
                let (position, velocity) = (smooth.position[i], smooth.velocity[i]);
                let since_reversal = way.since_reversal(position, velocity);
                if !used || i % stride != 0 {
                    continue;
                }
                moments.push(RegressionSample {
                    time_s: begin + self.step_s * i as f64,
                    position,
                    velocity,
                    acceleration: smooth.acceleration[i],
                    direction: smooth.direction[i],
                    effort: earlier(&smooth.effort, i, delay_s / self.step_s),
                    since_reversal,
                });
            }
        }
        moments
    }
}

/// Returns the value of a series `samples` samples before a place, interpolated by the cubic
/// through four neighbours.
pub fn earlier(series: &[f64], place: usize, samples: f64) -> f64 {
    let at = place as f64 - samples;
    let base = at.floor();
    let share = at - base;
    if share == 0.0 || base < 1.0 || base as usize + 2 >= series.len() {
        return series[(at.round().max(0.0) as usize).min(series.len() - 1)];
    }
    let i = base as usize;
    let x = share;
    series[i - 1] * (-x * (x - 1.0) * (x - 2.0) / 6.0)
        + series[i] * ((x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0)
        + series[i + 1] * (-(x + 1.0) * x * (x - 2.0) / 2.0)
        + series[i + 2] * ((x + 1.0) * x * (x - 1.0) / 6.0)
}

/// State from which the distance since the last reversal follows.
struct Way {
    creeping: f64,
    sign: f64,
    /// Position at the last change of the velocity's sign.
    crossing: f64,
    former: Option<[f64; 2]>,
    reversal: Option<f64>,
}

impl Way {
    const fn new(creeping: f64) -> Self {
        Self { creeping, sign: 0.0, crossing: 0.0, former: None, reversal: None }
    }

    fn since_reversal(&mut self, position: f64, velocity: f64) -> f64 {
        if self.former.is_some_and(|[_, before]| before * velocity <= 0.0) {
            self.crossing = position;
        }
        self.former = Some([position, velocity]);
        if velocity.abs() > self.creeping && velocity.signum() != self.sign {
            if self.sign != 0.0 {
                self.reversal = Some(self.crossing);
            }
            self.sign = velocity.signum();
        }
        self.reversal.map_or(f64::INFINITY, |from| (position - from).abs())
    }
}
