//! What cannot be so: standstill, wrong units, wrong signs. Told, or refused where no machine is
//! left.

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

/// What was handled while a log was read.
pub fn reading(log: &Log) -> Vec<String> {
    let mut told = Vec::new();
    if let Some(row) = log.first_missing {
        told.push(format!(
            "{} rows lack a number and were left out; the first is row {row}",
            log.missing
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

/// What the times look like.
pub fn times(grid: &Grid) -> Vec<String> {
    let mut told = Vec::new();
    let [short, long] = SAMPLE_TIMES;
    if !(short..=long).contains(&grid.step_s) {
        told.push(format!(
            "samples come out {} s apart, which is implausible; --time-unit says what the time \
             column counts in",
            rounded(grid.step_s)
        ));
    }
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
pub fn scale(read: &Read, scale: &Scale) -> Vec<String> {
    let place = usize::from(!scale.is_linear);
    let unit = scale.position_unit();
    if read.top_speed > FASTEST[place] {
        return vec![format!(
            "the top speed comes out as {} {unit}/s, which is implausible; --position-unit and \
             --time-unit say what the columns are in",
            rounded(read.top_speed)
        )];
    }
    if read.top_speed < SLOWEST[place] {
        return vec![format!(
            "the top speed comes out as {} {unit}/s, which is implausible; --position-unit and \
             --time-unit say what the columns are in",
            rounded(read.top_speed)
        )];
    }
    Vec::new()
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
pub fn machine(fitted: &Fitted, read: &Read, scale: &Scale) -> Vec<String> {
    let place = usize::from(!scale.is_linear);
    let unit = scale.position_unit();
    let mut told = Vec::new();
    let [shortest, longest] = TRAVELS[place];
    if !(shortest..=longest).contains(&read.travel) {
        told.push(format!(
            "the travel comes out as {} {unit}, which is implausible; --position-unit says what \
             the position is in",
            rounded(read.travel)
        ));
    }
    let friction = fitted.coulomb();
    let of_weight = friction.value / (GRAVITY * fitted.inertia());
    let [least, most] = OF_WEIGHT;
    // On air there is no friction, and that is no wrong unit.
    let is_known = friction.value > 2.0 * friction.sd;
    if scale.is_linear && is_known && !(least..=most).contains(&of_weight) {
        told.push(format!(
            "friction comes out as {} of the weight of what moves, which is implausible; \
             --position-unit says what the position is in",
            rounded(of_weight)
        ));
    }
    let [least, most] = INERTIAS[place];
    if scale.effort.is_some() && !(least..=most).contains(&fitted.inertia()) {
        told.push(format!(
            "the inertia comes out as {} {}, which is implausible; --effort-gain and \
             --position-unit say what the columns are in",
            rounded(fitted.inertia()),
            scale.unit_of("inertia")
        ));
    }
    told
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
