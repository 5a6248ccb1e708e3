//! The gear of a device with an encoder on its motor and one on its load: ratio, slack and
//! stiffness, measured by moves.
//!
//! ```text
//! sequence    whether the moves follow the sequence of motions of an identification
//! moves       three trajectories within [profile], about the place where the loop closes
//! recording   samples of both encoders and of the effort, by the link
//! fit         log_identification/gear.rs, the same as of a log
//! ```
//!
//! The device's own law drives the moves. Its sequence of motions (`src/identification/`) does not
//! show the gear: behind a soft one it ends at its speed limit, and its slow legs do not wind up a
//! stiff one.
//!
//! Limits: those of the fit. The effort is the controller's voltage, so the motor's viscous
//! friction includes its back-EMF. **Nothing has run on a real joint.**

mod moves;
mod recording;
mod sequence;

use serde_json::{Map, Value, json};
use stiction::Parameters;
use stiction::link::FaultReport;

pub use moves::{GearBounds, GearMove, moves};
pub use recording::{GearRecorder, GearRecording, GearStep, SIGNALS, record};
pub use sequence::PrecedingSequence;

use crate::log_identification::FitSettings;
use crate::log_identification::gear::{self, IdentifiedGear, SideCounts};
use crate::log_identification::model::FittedParameter;
use crate::log_identification::reading::of_rows;
use crate::log_identification::time_grid::TimeGrid;
use crate::log_identification::units::LogUnits;
use dynamics::joint::CoreUnits;
use files::error::{Error, rounded};
use simulator::device::client::Client;
use simulator::device::measured_gear::MeasuredGear;
use simulator::device::wire::Wire;
use simulator::device::words;

/// Largest share of lost samples.
const MOST_LOST: f64 = 0.01;

/// Least travel of an encoder, counts.
const FEWEST_COUNTS: f64 = 8.0;

/// Least difference at which a ratio counts as wrong: as a share, and in standard deviations.
const RATIO: f64 = 1e-3;
const OFF: f64 = 4.0;

/// A gear that was measured by moves of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceGear {
    /// Values in V and rad, at the joint.
    pub gear: IdentifiedGear,
    /// Counts of the motor per turn of the joint, as the device is configured.
    pub configured_counts_per_turn: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of samples that did not arrive.
    pub lost: u64,
    /// Conversion from volts to N m; `None` without a data sheet.
    pub units: Option<CoreUnits>,
    /// Sentences that doubt a value.
    pub doubts: Vec<String>,
}

/// Arms a device with these parameters, measures its gear by these moves, and turns the output off.
/// Returns half a sentence with the reason if the gear was not identified.
///
/// # Errors
/// Returns an error if Ctrl-C ended the moves, or if the output may still be on.
pub fn measure<W: Wire>(
    client: &mut Client<W>,
    parameters: &Parameters,
    units: Option<CoreUnits>,
    moves: Vec<GearMove>,
) -> Result<Result<DeviceGear, String>, Error> {
    let recorded = client
        .wait_at_rest()
        .and_then(|_| client.arm_tested())
        .and_then(|()| record(client, moves));
    // Nothing is sent before the stop, whatever has failed.
    client.stop()?;
    let unsubscribed = client.subscribe(0, 0);
    let fault = client.status()?.fault;
    match recorded {
        Ok(recording) => unsubscribed.map(|()| identify(&recording, parameters, units)),
        Err(error @ Error::CtrlC(_)) => Err(error),
        Err(error) => Ok(Err(why_ended(&error, &fault, parameters))),
    }
}

/// Returns half a sentence: why the moves have ended early, with this error and this fault of the
/// device.
pub fn why_ended(error: &Error, fault: &FaultReport, parameters: &Parameters) -> String {
    if fault.code == 0 {
        return error.to_string();
    }
    format!(
        "its moves were ended by {} (docs/reference/faults.md); {}",
        words::fault(fault, parameters.controller.sample_time),
        words::remedy(fault.code, words::CLEAR)
    )
}

/// Returns the gear as text, or why it was not identified.
pub fn words_of(gear: &Result<DeviceGear, String>) -> String {
    match gear {
        Ok(gear) => gear.words(),
        Err(why) => format!("gear: not identified: {why}\n"),
    }
}

/// Identifies the gear of a device with these parameters from its samples.
///
/// # Errors
/// Returns half a sentence with the reason if the samples do not show the gear.
pub fn identify(
    recording: &GearRecording,
    parameters: &Parameters,
    units: Option<CoreUnits>,
) -> Result<DeviceGear, String> {
    let GearRecording { rows, lost } = recording;
    let count_deg = parameters.controller.motor.count().ok_or("the device has one encoder")?;
    let due = rows.len() as f64 + *lost as f64;
    if *lost as f64 > MOST_LOST * due {
        return Err(format!(
            "{lost} of {due} samples did not arrive: the link is too slow or disturbed; look at \
             its cable, and identify again"
        ));
    }
    for (column, side) in [(1, "load"), (3, "motor")] {
        let positions = rows.iter().map(|row| row[column]);
        let [low, high] = positions.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at), high.max(at)]
        });
        if high - low < FEWEST_COUNTS {
            return Err(format!(
                "the {side}'s encoder has not followed the moves: check its wires (`jog`)"
            ));
        }
    }
    let resolution = f64::from(parameters.controller.encoder.resolution).to_radians();
    let scale =
        LogUnits { time_s: 1.0, position: resolution, is_linear: false, effort: None, motor: None };
    let mut log = of_rows(rows.iter().copied())?;
    scale.apply(&mut log);
    let folded = log.folded as f64;
    let counts = SideCounts { motor: 1.0 / folded, load: resolution / folded };
    let grid = TimeGrid::of(&log, log.time_digit)?;
    let request = FitSettings {
        scale,
        is_asymmetric: None,
        has_stribeck: false,
        has_gravity: false,
        cut_off_hz: None,
        effort_delay_s: None,
        has_motor_current: false,
    };
    let gear = gear::identify(&grid, counts, &request)?;
    let configured_counts_per_turn = 360.0 / f64::from(count_deg);
    let doubts = doubts(&gear, configured_counts_per_turn, *lost);
    Ok(DeviceGear {
        gear,
        configured_counts_per_turn,
        samples: rows.len(),
        lost: *lost,
        units,
        doubts,
    })
}

/// Returns whether the measured ratio differs from the configured one, counts of the motor per turn
/// of the joint.
fn is_ratio_wrong(gear: &IdentifiedGear, configured: f64) -> bool {
    let FittedParameter { value, sd } = gear.ratio;
    (value - configured).abs() > (OFF * sd).max(RATIO * configured)
}

/// Returns the doubts of the fit, and those about ratio and link.
fn doubts(gear: &IdentifiedGear, configured: f64, lost: u64) -> Vec<String> {
    let ratio = gear.ratio.value;
    let mut doubts = gear.doubts.clone();
    if is_ratio_wrong(gear, configured) {
        doubts.push(format!(
            "the ratio is wrong: the device has {} counts of the motor per turn of the joint, but \
             the moves show {}: check the lines of the encoder and gear.ratio",
            rounded(configured),
            rounded(ratio)
        ));
    }
    if lost > 0 {
        doubts.push(format!("{lost} samples did not arrive; the fit interpolates them"));
    }
    doubts
}

/// Line of the result: name, value, unit, factor from V and rad, unit in SI, and its factor from
/// V and rad.
type Line<'a> = (&'static str, &'a FittedParameter, &'static str, f64, &'static str, f64);

impl DeviceGear {
    /// Returns the values of which the gear is sure, for a machine's file. `None` without a data
    /// sheet, after a poor fit, and with a wrong ratio.
    pub fn measured(&self) -> Option<MeasuredGear> {
        let is_wrong = is_ratio_wrong(&self.gear, self.configured_counts_per_turn);
        if is_wrong || !self.gear.explains_effort() {
            return None;
        }
        self.units.map(|units| self.gear.measured(units.effort(1.0)))
    }

    fn lines(&self) -> [Line<'_>; 7] {
        let gear = &self.gear;
        let torque = self.units.map_or(1.0, |units| units.effort(1.0));
        let per_deg = 1f64.to_radians();
        let deg = 1f64.to_degrees();
        [
            ("ratio", &gear.ratio, "counts per turn", 1.0, "", 1.0),
            ("stiffness", &gear.stiffness, "V/deg", per_deg, "N m/rad", torque),
            ("damping", &gear.damping, "V s/deg", per_deg, "N m s/rad", torque),
            ("slack", &gear.slack, "deg", deg, "", 1.0),
            ("motor_inertia", &gear.motor_inertia, "V s^2/deg", per_deg, "kg m^2", torque),
            ("motor_viscous", &gear.motor_viscous, "V s/deg", per_deg, "N m s/rad", torque),
            ("motor_coulomb", &gear.motor_coulomb, "V", 1.0, "N m", torque),
        ]
    }

    /// Returns the values with their error bars as text, and the doubts.
    pub fn words(&self) -> String {
        let Self { samples, configured_counts_per_turn, .. } = self;
        let configured = rounded(*configured_counts_per_turn);
        let mut text = format!(
            "gear       by moves with both encoders, {samples} samples; the device has \
             {configured} counts per turn\n"
        );
        for (name, FittedParameter { value, sd }, unit, factor, in_si, torque) in self.lines() {
            let name = name.replace('_', " ");
            let both = match name.as_str() {
                "ratio" => format!("{value:>10.1} +- {sd:.1} {unit}"),
                "slack" => format!("{:>10.4} +- {:.1e} {unit}", value * factor, sd * factor),
                _ => format!("{:>10.3e} +- {:.1e} {unit}", value * factor, sd * factor),
            };
            let is_shown = self.units.is_some() && !in_si.is_empty();
            let si = if is_shown {
                format!("   {:>11.5} +- {:.1e} {in_si}", value * torque, sd * torque)
            } else {
                String::new()
            };
            text += format!("{name:<13} {both:<30}{si}").trim_end();
            text.push('\n');
        }
        text +=
            &format!("residual    {:>10.2} % of the effort\n", self.gear.relative_residual_percent);
        self.doubts.iter().for_each(|doubt| text += &format!("           {doubt}\n"));
        text
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self) -> Value {
        let valued = |value: &FittedParameter, factor: f64| {
            let [value, sd] = [value.value, value.sd].map(|one| one * factor);
            json!({ "value": value, "sd": sd })
        };
        let mut object: Map<String, Value> = self
            .lines()
            .into_iter()
            .map(|(name, value, _, factor, ..)| {
                let name = if name == "slack" { "slack_deg" } else { name };
                (name.to_owned(), valued(value, factor))
            })
            .collect();
        let in_si = self.units.map(|_| {
            let lines = self.lines().into_iter().filter(|line| !line.4.is_empty());
            lines
                .map(|(name, value, _, _, unit, torque)| {
                    let mut one = valued(value, torque);
                    one["unit"] = unit.into();
                    (name.to_owned(), one)
                })
                .collect::<Map<String, Value>>()
        });
        object.insert("si".into(), json!(in_si));
        for (key, value) in [
            ("configured_counts_per_turn", json!(self.configured_counts_per_turn)),
            ("effort_delay_s", json!(self.gear.effort_delay_s)),
            ("relative_residual_percent", json!(self.gear.relative_residual_percent)),
            ("samples", json!(self.samples)),
            ("lost_samples", json!(self.lost)),
            ("doubts", json!(self.doubts)),
        ] {
            object.insert(key.into(), value);
        }
        object.into()
    }
}
