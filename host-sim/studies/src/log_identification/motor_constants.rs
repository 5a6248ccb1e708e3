//! Resistance and back-EMF constant of a motor, from a log of its voltage and its current.
//!
//! ```text
//! u = R i + k v + V_d sgn(i)         in motion; u, i, v and sgn(i) pass the low-pass of the log
//! ```
//!
//! `k` is the back-EMF of a unit of the joint's speed, V s/rad. In SI units it is also the torque
//! at the joint of one ampere, N m/A, before the losses of the gear (for a machine along a line: V
//! s/m and N/A). `V_d` is lost to dead time and brushes. The inductance is left out: below the
//! cut-off, a few 10 Hz, its voltage is small for time constants of a few ms.
//!
//! Guarantees: error bars as those of the [least squares](super::least_squares). A log in which
//! friction alone makes the current is refused: it does not separate R from k. Does badly: noise of
//! the current makes R too small, and a winding that warms up has the mean of its resistances. A
//! log in which the current is that of a sample before its voltage has acted (as a device's) puts
//! `R T di/dt` into k: a few per mille for motions of 1 Hz at 1 ms.

use serde::Serialize;

use super::least_squares::{Fit, MOST};
use super::model::FittedParameter;
use super::moments::FilteredLog;
use super::time_grid::TimeGrid;
use super::units::LogUnits;
use files::error::rounded;

/// Largest ratio of the uncertainty of R to that without the other columns. Only the rest of the
/// current that is no sum of them shows R, and noise in it makes R too small: by a hundredth if
/// the noise is a tenth of that rest, which is then 1 % of the current.
const SEPARATED: f64 = 10.0;

/// Names of the columns, for messages.
const COLUMNS: [&str; 3] = ["current", "speed", "sign of the current"];

/// Resistance and back-EMF constant of a motor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotorConstants {
    /// Resistance of the winding with bridge and cable, ohm.
    pub resistance_ohm: FittedParameter,
    /// Back-EMF constant at the joint, V s/rad or V s/m.
    pub back_emf: FittedParameter,
    /// Voltage that dead time and brushes lose, V.
    pub lost_v: FittedParameter,
    /// Root mean square of the residual, as a part of that of the voltage, %.
    pub relative_residual_percent: f64,
}

/// Identifies the constants of a log whose stretches have the current in `beside`, A, and whose
/// effort is a voltage, V, times the gain of the units.
///
/// # Errors
/// Returns a sentence if the log does not separate the constants.
pub fn identify(
    grid: &TimeGrid,
    filtered: &FilteredLog,
    scale: &LogUnits,
) -> Result<MotorConstants, String> {
    let gain = scale.effort_per_unit();
    let currents: Vec<Vec<f64>> =
        grid.stretches.iter().map(|one| filtered.low_pass(&one.beside)).collect();
    let sign = |current: &f64| if *current == 0.0 { 0.0 } else { current.signum() };
    let signs: Vec<Vec<f64>> = grid
        .stretches
        .iter()
        .map(|one| filtered.low_pass(&one.beside.iter().map(sign).collect::<Vec<_>>()))
        .collect();
    let places = filtered.places();
    let rows = || {
        places.iter().map(|[stretch, sample]| {
            let smooth = &filtered.stretches[*stretch];
            let mut row = [0.0; MOST];
            row[0] = currents[*stretch][*sample];
            row[1] = smooth.velocity[*sample];
            row[2] = signs[*stretch][*sample];
            (row, smooth.effort[*sample] / gain)
        })
    };
    let fit = Fit::of(COLUMNS.len(), rows).map_err(|column| {
        format!(
            "the {} is zero in all of the log, or a sum of the other columns; move both ways at \
             several speeds, with accelerations",
            COLUMNS[column]
        )
    })?;
    let inflation = fit.inflation[0];
    if inflation > SEPARATED {
        return Err(format!(
            "only {} % of the current is no sum of its sign and the speed, at least {} % are \
             needed; move with more acceleration",
            rounded(100.0 / inflation),
            rounded(100.0 / SEPARATED)
        ));
    }
    let of =
        |column: usize| FittedParameter { value: fit.values[column], sd: fit.deviation(column) };
    Ok(MotorConstants {
        resistance_ohm: of(0),
        back_emf: of(1),
        lost_v: of(2),
        relative_residual_percent: 100.0 * (fit.residual / fit.total).sqrt(),
    })
}
