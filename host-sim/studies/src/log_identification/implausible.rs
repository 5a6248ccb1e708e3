//! What cannot be so: standstill, wrong units, wrong signs. A value out of the bounds of what is
//! built lowers the verdict ([`Implausible`]); a log that describes no machine is refused.

use super::model::{Fitted, Parameter};
use super::reading::Log;
use super::time_grid::Grid;
use super::units::Scale;
use super::{Read, samples};
use crate::error::rounded;

/// Times between samples that control loops and loggers have, s.
const SAMPLE_TIMES: [f64; 2] = [5e-6, 0.1];

/// Speeds that no positioned machine reaches: m/s, rad/s (20000 1/min).
const FASTEST: [f64; 2] = [50.0, 2100.0];

/// Speeds below which a motion is none: m/s, rad/s.
const SLOWEST: [f64; 2] = [1e-6, 1e-6];

/// Travels that no machine has that slides: below the first friction is that of bristles
/// (presliding), and above the second no line is built. m, rad.
const TRAVELS: [[f64; 2]; 2] = [[1e-5, 1e3], [1e-5, f64::INFINITY]];

/// Friction along a line as a part of the weight. A rolling guide has 0.001 and more, a tenth of
/// which is allowed here; and what needs a hundred times its weight to be moved has no guide that
/// anyone builds.
const OF_WEIGHT: [f64; 2] = [1e-4, 100.0];

/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.806_65;

/// Masses (kg) and inertias (kg m^2) that a motor moves: from the rotor of a watch to a telescope.
const INERTIAS: [[f64; 2]; 2] = [[1e-5, 1e7], [1e-12, 1e8]];

/// Factor out of its bounds by which a value makes the whole result useless.
const FAR: f64 = 10.0;

/// A value out of the bounds of what is built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Implausible {
    /// The value, and which option is meant.
    pub words: String,
    /// Whether it is out of its bounds by more than a factor of ten: nothing of the result is to be
    /// used.
    pub is_far: bool,
}

impl Implausible {
    /// Returns that of a value; none if the value is within its bounds.
    fn of(value: f64, [least, most]: [f64; 2], words: impl FnOnce() -> String) -> Option<Self> {
        if (least..=most).contains(&value) {
            return None;
        }
        let is_far = !(least / FAR..=most * FAR).contains(&value);
        Some(Self { words: words(), is_far })
    }
}

/// What was handled while a log was read.
pub fn reading(log: &Log) -> Vec<String> {
    let mut told = Vec::new();
    if let Some(row) = log.first_missing {
        told.push(format!(
            "{} rows lack a number and were left out; the first is row {row}",
            log.missing
        ));
    }
    if let Some((row, cells)) = log.first_long {
        told.push(format!(
            "{} rows have more cells than the first row of the file and were left out; the first \
             is row {row} with {cells}",
            log.long
        ));
    }
    if log.has_units_row {
        told.push("the row below the header is no numbers and was left out".into());
    }
    if let Some(row) = log.first_equal {
        told.push(format!(
            "times are rounded (row {row} has that of the row before); even steps are assumed"
        ));
    }
    told
}

/// The time between samples, if no loop and no logger has it.
pub fn step(grid: &Grid) -> Option<Implausible> {
    Implausible::of(grid.step_s, SAMPLE_TIMES, || {
        format!(
            "samples come out {} s apart, which is implausible; --time-unit says what the time \
             column counts in",
            rounded(grid.step_s)
        )
    })
}

/// What the times look like.
pub fn times(grid: &Grid) -> Vec<String> {
    let mut told = Vec::new();
    if let Some(at) = grid.first_gap_s {
        let gaps = if grid.gaps == 1 { "1 gap".into() } else { format!("{} gaps", grid.gaps) };
        told.push(format!(
            "the log has {gaps}, the first behind {} s; what is between was filtered apart",
            rounded(at)
        ));
    }
    if let Some(at) = grid.jumps_s.first() {
        let times = if grid.jumps_s.len() == 1 {
            "once".into()
        } else {
            format!("{} times", grid.jumps_s.len())
        };
        told.push(format!(
            "the position jumps {times}, first at {} s, as a counter does that runs over; what is \
             between was filtered apart",
            rounded(*at)
        ));
    }
    if grid.is_interpolated {
        told.push("times are uneven; samples were interpolated onto even steps".into());
    }
    told
}

/// Refuses a log in which nothing moves, or nothing drives.
pub fn still(grid: &Grid) -> Result<(), String> {
    let range = |of: fn(&super::time_grid::Stretch) -> &Vec<f64>| {
        let all = grid.stretches.iter().flat_map(of);
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        });
        (high - low).max(0.0)
    };
    if samples(grid) == 0 || range(|one| &one.position) == 0.0 {
        return Err(
            "the position never changes; name the column that has it, or log a motion".into()
        );
    }
    if range(|one| &one.effort) == 0.0 {
        return Err("the effort never changes; name the column of the motor's current, torque, \
                    force or voltage"
            .into());
    }
    Ok(())
}

/// Speeds that cannot be so.
pub fn scale(read: &Read, scale: &Scale) -> Option<Implausible> {
    let place = usize::from(!scale.is_linear);
    Implausible::of(read.top_speed, [SLOWEST[place], FASTEST[place]], || {
        format!(
            "the top speed comes out as {} {}/s, which is implausible; --position-unit and \
             --time-unit say what the columns are in",
            rounded(read.top_speed),
            scale.position_unit()
        )
    })
}

/// What is taken for the unit of an effort that nobody has said.
pub fn effort(scale: &Scale) -> Option<String> {
    scale.is_assumed().then(|| {
        "nothing says what a unit of the effort is; it is taken as 1 N, and kg and N hold only if \
         it is: --effort-gain says otherwise"
            .into()
    })
}

/// A machine that nobody builds. Whatever the effort is in, it does not change the part that
/// friction is of the weight.
pub fn machine(fitted: &Fitted, read: &Read, scale: &Scale) -> Vec<Implausible> {
    let place = usize::from(!scale.is_linear);
    let travel = Implausible::of(read.travel, TRAVELS[place], || {
        format!(
            "the travel comes out as {} {}, which is implausible; --position-unit says what the \
             position is in",
            rounded(read.travel),
            scale.position_unit()
        )
    });
    let friction = fitted.coulomb();
    let of_weight = friction.value / (GRAVITY * fitted.inertia());
    // On air there is no friction, and that is no wrong unit.
    let is_known = scale.is_linear && friction.value > 2.0 * friction.sd;
    let friction = is_known.then(|| {
        Implausible::of(of_weight, OF_WEIGHT, || {
            format!(
                "friction comes out as {} of the weight of what moves, which is implausible; \
                 --position-unit says what the position is in",
                rounded(of_weight)
            )
        })
    });
    let inertia = scale.effort.map(|_| {
        Implausible::of(fitted.inertia(), INERTIAS[place], || {
            format!(
                "the inertia comes out as {} {}, which is implausible; --effort-gain and \
                 --position-unit say what the columns are in",
                rounded(fitted.inertia()),
                scale.unit_of("inertia")
            )
        })
    });
    [travel, friction.flatten(), inertia.flatten()].into_iter().flatten().collect()
}

/// Refuses an inertia that is not positive.
pub fn signs(parameters: &[(&str, Parameter)], scale: &Scale) -> Result<(), String> {
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
            "inertia ({found} {unit}) and friction come out negative: effort and position count \
             in opposite directions; turn one round, as with a negative --effort-gain"
        )
    } else {
        format!(
            "the inertia comes out as {found} {unit}, which cannot be: the log hardly accelerates, \
             or the position is too coarse for it; log quicker motions, or set --cut-off"
        )
    })
}
