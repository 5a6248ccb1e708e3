//! Plausibility checks: standstill, wrong units, wrong signs. A value outside the range of existing
//! machines lowers the verdict ([`Implausible`]); a log that cannot be of a machine is refused.

use super::model::{FittedModel, FittedParameter};
use super::reading::MotionLog;
use super::time_grid::TimeGrid;
use super::units::LogUnits;
use super::{LogStatistics, samples};
use files::error::rounded;

/// Range of sample times of control loops and loggers, s.
const SAMPLE_TIMES: [f64; 2] = [5e-6, 0.1];

/// Largest plausible speeds: m/s, rad/s (20000 1/min).
const FASTEST: [f64; 2] = [50.0, 2100.0];

/// Least speeds that count as motion: m/s, rad/s.
const SLOWEST: [f64; 2] = [1e-6, 1e-6];

/// Range of travels, m and rad. Below it the friction is that of bristles (presliding); above it no
/// linear axis is built.
const TRAVELS: [[f64; 2]; 2] = [[1e-5, 1e3], [1e-5, f64::INFINITY]];

/// Range of the friction of a linear axis, as a multiple of the weight. A rolling guide has 0.001
/// or more; a tenth of that is accepted. No guide has 100.
const OF_WEIGHT: [f64; 2] = [1e-4, 100.0];

/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.806_65;

/// Range of masses (kg) and inertias (kg m^2): from the rotor of a watch to a telescope.
const INERTIAS: [[f64; 2]; 2] = [[1e-5, 1e7], [1e-12, 1e8]];

/// Factor beyond its range from which a value makes the whole result useless.
const FAR: f64 = 10.0;

/// A value outside the range of existing machines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Implausible {
    /// Sentence with the value and the option to correct.
    pub words: String,
    /// Whether the value is beyond its range by more than a factor of ten: the whole result is
    /// useless.
    pub is_far: bool,
}

impl Implausible {
    /// Checks a value; returns `None` if it is within its range.
    fn of(value: f64, [least, most]: [f64; 2], words: impl FnOnce() -> String) -> Option<Self> {
        if (least..=most).contains(&value) {
            return None;
        }
        let is_far = !(least / FAR..=most * FAR).contains(&value);
        Some(Self { words: words(), is_far })
    }
}

/// Returns warnings about the rows of a log.
pub fn reading(log: &MotionLog) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(row) = log.first_missing {
        warnings.push(format!(
            "{} rows lack a number and were left out; the first is row {row}",
            log.missing
        ));
    }
    if let Some((row, cells)) = log.first_long {
        warnings.push(format!(
            "{} rows have more cells than the first row of the file and were left out; the first \
             is row {row} with {cells}",
            log.long
        ));
    }
    if log.has_units_row {
        warnings.push("the row below the header has no numbers and was left out".into());
    }
    if let Some(row) = log.first_equal {
        warnings.push(format!(
            "times are rounded (row {row} has the time of the row before); even steps are assumed"
        ));
    }
    warnings
}

/// Checks the time between samples.
pub fn step(grid: &TimeGrid) -> Option<Implausible> {
    Implausible::of(grid.step_s, SAMPLE_TIMES, || {
        format!(
            "the sample time is {} s, which is implausible; set the unit of the time column with \
             --time-unit",
            rounded(grid.step_s)
        )
    })
}

/// Returns warnings about gaps, jumps and uneven times.
pub fn times(grid: &TimeGrid) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(at) = grid.first_gap_s {
        let gaps = if grid.gaps == 1 { "1 gap".into() } else { format!("{} gaps", grid.gaps) };
        warnings.push(format!(
            "the log has {gaps}, the first after {} s; the parts were filtered separately",
            rounded(at)
        ));
    }
    if let Some(at) = grid.jumps_s.first() {
        let times = if grid.jumps_s.len() == 1 {
            "once".into()
        } else {
            format!("{} times", grid.jumps_s.len())
        };
        warnings.push(format!(
            "the position jumps {times}, first at {} s, like a counter that overflows; the parts \
             were filtered separately",
            rounded(*at)
        ));
    }
    if grid.is_interpolated {
        warnings.push("times are uneven; samples were interpolated onto even steps".into());
    }
    warnings
}

/// Refuses a log with a constant position or a constant effort.
pub fn still(grid: &TimeGrid) -> Result<(), String> {
    let range = |of: fn(&super::time_grid::Stretch) -> &Vec<f64>| {
        let all = grid.stretches.iter().flat_map(of);
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        });
        (high - low).max(0.0)
    };
    if samples(grid) == 0 || range(|one| &one.position) == 0.0 {
        return Err(
            "the position never changes; name the column of the position, or log a motion".into()
        );
    }
    if range(|one| &one.effort) == 0.0 {
        return Err("the effort never changes; name the column of the motor's current, torque, \
                    force or voltage"
            .into());
    }
    Ok(())
}

/// Checks the largest speed.
pub fn scale(read: &LogStatistics, scale: &LogUnits) -> Option<Implausible> {
    let place = usize::from(!scale.is_linear);
    Implausible::of(read.top_speed, [SLOWEST[place], FASTEST[place]], || {
        format!(
            "the top speed is {} {}/s, which is implausible; set the units of the columns with \
             --position-unit and --time-unit",
            rounded(read.top_speed),
            scale.position_unit()
        )
    })
}

/// Returns a warning if the unit of the effort is assumed.
pub fn effort(scale: &LogUnits) -> Option<String> {
    scale.is_assumed().then(|| {
        "the unit of the effort is unknown and assumed to be 1 N: all masses and forces scale with \
         it; set it with --effort-gain"
            .into()
    })
}

/// Checks travel, friction and inertia. The ratio of friction to weight does not depend on the unit
/// of the effort.
pub fn machine(fitted: &FittedModel, read: &LogStatistics, scale: &LogUnits) -> Vec<Implausible> {
    let place = usize::from(!scale.is_linear);
    let travel = Implausible::of(read.travel, TRAVELS[place], || {
        format!(
            "the travel is {} {}, which is implausible; set the unit of the position with \
             --position-unit",
            rounded(read.travel),
            scale.position_unit()
        )
    });
    let friction = fitted.coulomb();
    let of_weight = friction.value / (GRAVITY * fitted.inertia());
    // An air bearing has no friction; that does not show a wrong unit.
    let is_known = scale.is_linear && friction.value > 2.0 * friction.sd;
    let friction = is_known.then(|| {
        Implausible::of(of_weight, OF_WEIGHT, || {
            format!(
                "the friction is {} times the weight of the moving mass, which is implausible; set \
                 the unit of the position with --position-unit",
                rounded(of_weight)
            )
        })
    });
    let inertia = scale.effort.map(|_| {
        Implausible::of(fitted.inertia(), INERTIAS[place], || {
            format!(
                "the inertia is {} {}, which is implausible; set the units of the columns with \
                 --effort-gain and --position-unit",
                rounded(fitted.inertia()),
                scale.unit_of("inertia")
            )
        })
    });
    [travel, friction.flatten(), inertia.flatten()].into_iter().flatten().collect()
}

/// Refuses an inertia that is not positive.
pub fn signs(parameters: &[(&str, FittedParameter)], scale: &LogUnits) -> Result<(), String> {
    let find = |name: &str| {
        parameters.iter().find(|(one, _)| *one == name).map_or(0.0, |(_, found)| found.value)
    };
    let inertia = find("inertia");
    if inertia > 0.0 {
        return Ok(());
    }
    let friction = find("coulomb") + find("coulomb_positive") + find("coulomb_negative");
    let (found, unit) = (rounded(inertia), scale.unit_of("inertia"));
    Err(if friction < 0.0 {
        format!(
            "inertia ({found} {unit}) and friction are negative: effort and position count in \
             opposite directions; reverse one of them, for example with a negative --effort-gain"
        )
    } else {
        format!(
            "the inertia is {found} {unit}, which is impossible: the log hardly accelerates, or \
             the position is too coarse; log quicker motions, or set --cut-off"
        )
    })
}
