//! Identification of inertia and friction from a log of time, position and effort (inverse
//! dynamics).
//!
//! ```text
//! CSV -> reading -> time_grid -> cut_off -> gear, if the log has both sides of one
//!     -> moments (butterworth, derivative, gate) -> least_squares over the columns of a model
//!     -> free_run, misfit, proposal -> verdict -> output
//! ```
//!
//! The equation of [`model`] holds for a rigid machine in motion. Position and effort pass the same
//! low-pass, so the equation holds for the filtered signals as well, and least squares solves it
//! for the coefficients. `docs/how-to/identify.md` has guarantees and measurements.
//!
//! The variance of a coefficient is that of [`least_squares`] plus the square of half its change
//! with a cut-off a third lower: a coefficient that depends on the filter is uncertain by that
//! much. The inertia's standard deviation also includes half of the noise's share ([`cut_off`]).

pub mod butterworth;
pub mod cut_off;
pub mod derivative;
pub mod effort_unit;
pub mod encoding;
pub mod figures;
pub mod free_run;
pub mod gate;
pub mod gear;
pub mod implausible;
pub mod into_machine;
pub mod least_squares;
pub mod machine_file;
pub mod misfit;
pub mod model;
pub mod moments;
pub mod motor_constants;
pub mod output;
pub mod proposal;
pub mod reading;
pub mod regression;
pub mod time_grid;
pub mod units;
pub mod verdict;

#[cfg(test)]
mod tests;

use cut_off::CutOff;
use free_run::FreeRun;
use gear::{IdentifiedGear, SideCounts};
use implausible::Implausible;
use misfit::Misfit;
use model::{FittedModel, FittedParameter, RegressionSample};
use moments::FilteredLog;
use motor_constants::MotorConstants;
use proposal::Proposal;
use reading::MotionLog;
use time_grid::TimeGrid;
use units::LogUnits;
use verdict::{FitVerdict, Objections};

/// Ratio of the cut-off to the lower cut-off at which coefficients are compared.
const LOWER: f64 = 1.5;

/// Settings for the identification from a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    /// Units of the log.
    pub scale: LogUnits,
    /// Whether friction differs between the directions; `None`: chosen from the log.
    pub is_asymmetric: Option<bool>,
    /// Whether the model has a Stribeck term.
    pub has_stribeck: bool,
    /// Whether the model has gravity.
    pub has_gravity: bool,
    /// Cut-off of the low-pass, Hz; `None`: chosen from the log.
    pub cut_off_hz: Option<f64>,
    /// Delay until the logged effort acts, s; `None`: estimated.
    pub effort_delay_s: Option<f64>,
    /// Whether the column beside the position is the motor's current, A, and the effort its
    /// voltage, V. It is the motor's position otherwise.
    pub has_motor_current: bool,
}

impl FitSettings {
    /// Returns these settings if they are valid together.
    ///
    /// # Errors
    /// Returns a sentence with the invalid setting.
    pub fn checked(self) -> Result<Self, String> {
        if let Some(delay) = self.effort_delay_s.filter(|delay| !delay.is_finite()) {
            return Err(format!("--effort-delay {delay}: must be a number of seconds"));
        }
        if self.scale.is_linear && self.has_gravity {
            return Err(
                "--gravity needs a load that turns; on a machine along a line gravity is a \
                        constant load, which `offset` includes"
                    .into(),
            );
        }
        Ok(self)
    }
}

/// A machine identified from a log.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedMachine {
    /// Units of the log.
    pub scale: LogUnits,
    /// Model with its coefficients.
    pub fitted: FittedModel,
    /// Reported parameters.
    pub parameters: Vec<(&'static str, FittedParameter)>,
    /// Relative residuals of the symmetric and the asymmetric model, without a Stribeck term, %.
    pub compared: Vec<(&'static str, f64)>,
    /// Cut-off of the low-pass.
    pub cut_off: CutOff,
    /// Delay until the logged effort acts, s.
    pub effort_delay_s: f64,
    /// Simulation of the machine with the logged effort.
    pub free_run: FreeRun,
    /// Causes of the residual that the model leaves out.
    pub misfits: Vec<Misfit>,
    /// Terms that would lower the residual.
    pub proposals: Vec<Proposal>,
    /// Verdict on the fit.
    pub verdict: FitVerdict,
    /// Warnings to read before the numbers are used.
    pub warnings: Vec<String>,
    /// The gear, or the reason why it was not identified; `None` if the log has no position of the
    /// motor.
    pub gear: Option<Result<IdentifiedGear, String>>,
    /// The motor's constants, or the reason why they were not identified; `None` if the log has no
    /// current of the motor.
    pub motor: Option<Result<MotorConstants, String>>,
    /// Rows of the regression.
    pub moments: Vec<RegressionSample>,
    /// Statistics of the log.
    pub read: LogStatistics,
}

/// Statistics of a log.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LogStatistics {
    /// Number of rows with all numbers.
    pub rows: u64,
    /// Number of rows that lack a number.
    pub missing_rows: u64,
    /// Number of rows with more cells than the first one.
    pub long_rows: u64,
    /// Number of rows that are averaged into a sample.
    pub rows_per_sample: u64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Total time of all stretches, s.
    pub duration_s: f64,
    /// Number of gaps.
    pub gaps: usize,
    /// Share of the samples that the regression can use: in motion, and not saturated.
    pub used: f64,
    /// Share of the samples at standstill or creeping.
    pub standstill: f64,
    /// Share of the samples with a saturated effort.
    pub saturated: f64,
    /// Largest minus smallest position of the stretch that moves farthest, m or rad.
    pub travel: f64,
    /// Largest speed, m/s or rad/s.
    pub top_speed: f64,
    /// Largest absolute effort, N or N m; in the log's unit without a gain.
    pub top_effort: f64,
    /// Smallest change of the position between two rows, m or rad: one count of a counted position.
    pub count: f64,
}

/// Identifies the machine of a log.
///
/// # Errors
/// Returns a sentence with the reason why the log does not identify its machine, and a remedy.
pub fn identify(mut log: MotionLog, request: &FitSettings) -> Result<IdentifiedMachine, String> {
    let mut warnings = implausible::reading(&log);
    request.scale.apply(&mut log);
    log.has_motor_current = request.has_motor_current;
    let count = if log.smallest_change.is_finite() { log.smallest_change } else { 0.0 };
    let finite = |change: f64| if change.is_finite() { change / log.folded as f64 } else { 0.0 };
    let counts =
        SideCounts { motor: finite(log.smallest_motor_change), load: finite(log.smallest_change) };
    let (rows, missing_rows, long_rows) = (log.rows, log.missing, log.long);
    let folded = log.folded;
    let mut grid = TimeGrid::of(&log, log.time_digit)?;
    drop(log);
    let mut implausible: Vec<Implausible> = implausible::step(&grid).into_iter().collect();
    warnings.extend(implausible.iter().map(|value| value.words.clone()));
    warnings.extend(implausible::times(&grid));
    implausible::still(&grid)?;
    let highest = cut_off::highest(grid.step_s);
    if let Some(hz) = request.cut_off_hz.filter(|hz| !(*hz > 0.0 && *hz <= highest)) {
        return Err(format!(
            "--cut-off is {hz}; it must be above 0 and at most an eighth of the sampling \
             frequency, here {}",
            files::error::rounded(highest)
        ));
    }
    // The mean of several rows has a finer resolution.
    let cut_off = cut_off::choose(&grid, count / folded as f64, request.cut_off_hz);
    let has_motor = grid.stretches.iter().any(|one| !one.beside.is_empty());
    let has_gear = has_motor && !request.has_motor_current;
    let gear = has_gear.then(|| gear::identify(&grid, counts, request));
    let mut request = *request;
    if let Some(Ok(gear)) = &gear
        && let Some(delay_s) = gear.carry(&mut grid, &request.scale, counts, cut_off.hz)
    {
        request.effort_delay_s = Some(delay_s);
    }
    let slow = if request.has_stribeck { gate::CREEPING_WITH_STRIBECK } else { gate::CREEPING };
    let filtered = FilteredLog::of(&grid, [slow, count, cut_off.hz]);
    let has_current = has_motor && request.has_motor_current;
    let motor = has_current.then(|| motor_constants::identify(&grid, &filtered, &request.scale));
    let (fitted, compared, effort_delay_s, moments) =
        regression::regress(&filtered, &request, grid.step_s)?;
    let mut parameters = fitted.parameters();
    // Filtered one after the other, since each is as large as the log.
    let below = |part: f64| {
        FilteredLog::of(&grid, [slow, count, cut_off.hz / part]).moments(effort_delay_s)
    };
    widen(&mut parameters, &fitted, &below(LOWER));
    if let Some((_, inertia)) = parameters.first_mut() {
        inertia.sd = inertia.sd.hypot(0.5 * cut_off.noise.min(1.0) * inertia.value);
    }
    implausible::signs(&parameters, &request.scale)?;
    let free_run = free_run::free_run(&fitted, &grid, &filtered, effort_delay_s);
    let independent = (filtered.independent(moments.len()), filtered.creeping);
    let proposals = proposal::proposals(&fitted, &moments, independent, request.scale.is_linear);
    let misfits = misfit::misfits(&fitted, &moments, &below(misfit::SMOOTHER));
    let read = LogStatistics {
        rows,
        missing_rows,
        long_rows,
        rows_per_sample: folded,
        sample_time_s: grid.step_s,
        duration_s: grid.step_s * samples(&grid) as f64,
        gaps: grid.gaps,
        used: share_used(&filtered),
        standstill: filtered.gate.standstill,
        saturated: filtered.gate.saturated,
        travel: travel(&grid),
        top_speed: largest(filtered.stretches.iter().flat_map(|one| &one.velocity)),
        top_effort: largest(grid.stretches.iter().flat_map(|one| &one.effort)),
        count,
    };
    let of_machine = implausible::machine(&fitted, &read, &request.scale);
    let more = implausible::scale(&read, &request.scale).into_iter().chain(of_machine);
    let more: Vec<Implausible> = more.collect();
    warnings.extend(more.iter().map(|value| value.words.clone()));
    implausible.extend(more);
    warnings.extend(implausible::effort(&request.scale));
    let against =
        Objections { implausible: &implausible, misfits: &misfits, proposals: &proposals };
    let verdict = verdict::of(&fitted, &parameters, &free_run, against, &cut_off, &read);
    Ok(IdentifiedMachine {
        scale: request.scale,
        fitted,
        parameters,
        compared,
        cut_off,
        effort_delay_s,
        free_run,
        misfits,
        proposals,
        verdict,
        warnings,
        gear,
        motor,
        moments,
        read,
    })
}

/// Adds half of a coefficient's change with a lower cut-off to its standard deviation.
fn widen(
    parameters: &mut [(&'static str, FittedParameter)],
    fitted: &FittedModel,
    lower: &[RegressionSample],
) {
    let Ok(other) = regression::fit(fitted.model, lower) else { return };
    for ((_, one), (_, other)) in parameters.iter_mut().zip(other.parameters()) {
        one.sd = one.sd.hypot(0.5 * (one.value - other.value));
    }
}

fn samples(grid: &TimeGrid) -> usize {
    grid.stretches.iter().map(|one| one.position.len()).sum()
}

/// Returns the travel of the stretch that moves farthest. A counter that overflows separates
/// stretches.
fn travel(grid: &TimeGrid) -> f64 {
    let of = |positions: &Vec<f64>| {
        let low = positions.iter().copied().fold(f64::INFINITY, f64::min);
        let high = positions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (high - low).max(0.0)
    };
    grid.stretches.iter().map(|one| of(&one.position)).fold(0.0, f64::max)
}

fn share_used(filtered: &FilteredLog) -> f64 {
    let all = filtered.gate.used.iter().flatten();
    let used = all.clone().filter(|used| **used).count();
    used as f64 / all.count().max(1) as f64
}

fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.fold(0.0, |largest, value| largest.max(value.abs()))
}
