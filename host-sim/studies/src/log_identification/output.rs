//! Output of an identification from a log: a table, and JSON.

use serde_json::{Map, Value, json};

use super::IdentifiedMachine;
use super::gear::IdentifiedGear;
use super::model::FittedParameter;
use super::motor_constants::MotorConstants;
use files::error::rounded;
use simulator::output::grid;

/// Version of the JSON object; raised when a key changes its meaning or is removed.
const SCHEMA: u32 = 1;

/// Returns the JSON object for scripts.
pub fn object(log: &str, identified: &IdentifiedMachine) -> Value {
    let mut parameters = Map::new();
    let mut units = Map::new();
    for (name, parameter) in &identified.parameters {
        parameters.insert((*name).into(), json!(parameter));
        units.insert((*name).into(), identified.scale.unit_of(name).into());
    }
    units.insert("position".into(), identified.scale.position_unit().into());
    let free = &identified.free_run;
    let compared: Map<String, Value> = identified
        .compared
        .iter()
        .map(|(name, percent)| ((*name).into(), json!({ "relative_residual_percent": percent })))
        .collect();
    let gear = identified.gear.as_ref();
    json!({
        "schema": SCHEMA,
        "log": log,
        "model": identified.fitted.model.name(),
        "parameters": parameters,
        "units": units,
        "effort_gain": identified.scale.effort,
        "effort_unit_is_assumed": identified.scale.is_assumed(),
        "stribeck_velocity": identified.fitted.model.stribeck,
        "relative_residual_percent": identified.fitted.relative_residual_percent(),
        "free_run": {
            "rms": free.rms,
            "r2": free.r2,
            "velocity_rms": free.velocity_rms,
            "velocity_r2": free.velocity_r2,
        },
        "models": compared,
        "verdict": identified.verdict,
        "misfits": identified.misfits,
        "proposals": identified.proposals,
        "gear": gear.and_then(|gear| gear.as_ref().ok()).map(|gear| gear_object(identified, gear)),
        "gear_refused": gear.and_then(|gear| gear.as_ref().err()),
        "motor": identified.motor.as_ref().and_then(|motor| motor.as_ref().ok()),
        "motor_refused": identified.motor.as_ref().and_then(|motor| motor.as_ref().err()),
        "warnings": identified.warnings,
        "cut_off_hz": identified.cut_off.hz,
        "effort_delay_s": identified.effort_delay_s,
        "log_read": identified.read,
    })
}

/// Returns the object of a gear, with the units of its values.
fn gear_object(identified: &IdentifiedMachine, gear: &IdentifiedGear) -> Value {
    let units: Map<String, Value> = gear_parameters(identified, gear)
        .into_iter()
        .map(|(name, _, unit)| (name.into(), unit.into()))
        .collect();
    let mut object = json!(gear);
    object["units"] = units.into();
    object["units"]["twist"] = identified.scale.position_unit().into();
    object
}

/// Returns the values of a gear, with their names and units.
fn gear_parameters<'a>(
    identified: &IdentifiedMachine,
    gear: &'a IdentifiedGear,
) -> [(&'static str, &'a FittedParameter, String); 7] {
    let scale = &identified.scale;
    let (effort, position) = (scale.effort_unit(), scale.position_unit());
    [
        ("ratio", &gear.ratio, scale.ratio_unit().into()),
        ("stiffness", &gear.stiffness, format!("{effort}/{position}")),
        ("damping", &gear.damping, format!("{effort} s/{position}")),
        ("slack", &gear.slack, position.into()),
        ("motor_inertia", &gear.motor_inertia, scale.unit_of("inertia")),
        ("motor_viscous", &gear.motor_viscous, scale.unit_of("viscous")),
        ("motor_coulomb", &gear.motor_coulomb, scale.unit_of("coulomb")),
    ]
}

/// Returns the table of a gear with its doubts, or the reason why there is none.
fn gear_text(identified: &IdentifiedMachine, gear: &Result<IdentifiedGear, String>) -> String {
    let gear = match gear {
        Ok(gear) => gear,
        Err(why) => return format!("gear: not identified: {why}\n"),
    };
    let mut rows = grid::new(&HEADER);
    for (name, parameter, unit) in gear_parameters(identified, gear) {
        rows.add_row(row(name, parameter, unit));
    }
    let residual = short(gear.relative_residual_percent);
    let doubts: String = gear.doubts.iter().map(|words| format!("  - {words}\n")).collect();
    format!(
        "gear, all at the joint\n{}\n{:<11} {residual} % of the effort\n{doubts}",
        rows.trim_fmt(),
        "residual"
    )
}

/// Returns the table of a motor's constants, or the reason why there is none.
fn motor_text(identified: &IdentifiedMachine, motor: &Result<MotorConstants, String>) -> String {
    let motor = match motor {
        Ok(motor) => motor,
        Err(why) => return format!("motor: not identified: {why}\n"),
    };
    let position = identified.scale.position_unit();
    let torque = if identified.scale.is_linear { "N/A" } else { "N m/A" };
    let mut rows = grid::new(&HEADER);
    rows.add_row(row("resistance", &motor.resistance_ohm, "ohm".into()));
    rows.add_row(row("back_emf", &motor.back_emf, format!("V s/{position}, {torque}")));
    rows.add_row(row("lost", &motor.lost_v, "V".into()));
    let residual = short(motor.relative_residual_percent);
    format!(
        "motor, at the joint\n{}\n{:<11} {residual} % of the voltage\n",
        rows.trim_fmt(),
        "residual"
    )
}

/// Head of a table of parameters.
const HEADER: [&str; 5] = ["parameter", "value", "+-", "%", "unit"];

/// Returns the row of a parameter.
fn row(name: &str, parameter: &FittedParameter, unit: String) -> [String; 5] {
    let percent = 100.0 * parameter.sd / parameter.value.abs();
    [
        name.into(),
        significant(parameter.value, parameter.sd),
        rounded_to(parameter.sd, 2),
        if percent.is_finite() { rounded_to(percent, 2) } else { "-".into() },
        unit,
    ]
}

/// Returns the table of the parameters, with the verdict.
pub fn text(identified: &IdentifiedMachine) -> String {
    let mut rows = grid::new(&HEADER);
    for (name, parameter) in &identified.parameters {
        rows.add_row(row(name, parameter, identified.scale.unit_of(name)));
    }
    let (free, read, unit) =
        (&identified.free_run, &identified.read, identified.scale.position_unit());
    let mut text = format!("{} friction\n{}\n", identified.fitted.model.name(), rows.trim_fmt());
    let mut line = |name: &str, what: String| text += &format!("{name:<11} {what}\n");
    if let Some(stribeck) = identified.fitted.model.stribeck {
        line("Stribeck", format!("velocity {} {unit}/s", rounded(stribeck)));
    }
    if identified.scale.is_assumed() {
        line("units", "assumed: the unit of the effort is 1 N (no --effort-gain)".into());
    }
    line(
        "residual",
        format!("{} % of the effort", short(identified.fitted.relative_residual_percent())),
    );
    line(
        "free run",
        format!(
            "position {} {unit} rms, R^2 {}; velocity R^2 {}",
            short(free.rms),
            short(free.r2),
            short(free.velocity_r2)
        ),
    );
    line(
        "log",
        format!(
            "{} s, {} rows, {} s apart; {} % fitted, {} % at rest or creeping",
            short(read.duration_s),
            read.rows,
            rounded(read.sample_time_s),
            short(100.0 * read.used),
            short(100.0 * read.standstill)
        ),
    );
    let how = if identified.cut_off.is_given { "given" } else { "chosen" };
    let delay = identified.effort_delay_s;
    let delay = if delay == 0.0 {
        String::new()
    } else {
        format!("; effort acts {} s later", short(delay))
    };
    line("low-pass", format!("{} Hz, {how}{delay}", short(identified.cut_off.hz)));
    text += &format!("verdict: {}\n", identified.verdict.quality.word());
    for words in &identified.verdict.words {
        text += &format!("  - {words}\n");
    }
    text += &identified.gear.as_ref().map_or(String::new(), |gear| gear_text(identified, gear));
    let motor = identified.motor.as_ref();
    text += &motor.map_or(String::new(), |motor| motor_text(identified, motor));
    text
}

/// Formats a number with three digits.
pub fn short(number: f64) -> String {
    rounded_to(number, 3)
}

fn rounded_to(number: f64, digits: usize) -> String {
    if !number.is_finite() {
        return "-".into();
    }
    let text = format!("{number:.*e}", digits.saturating_sub(1));
    files::error::shown(text.parse().unwrap_or(number))
}

/// Formats a value with the digits that its standard deviation leaves, at least three.
fn significant(value: f64, sd: f64) -> String {
    let digits = if sd > 0.0 && value != 0.0 {
        ((value.abs() / sd).log10().floor() + 2.0).clamp(3.0, 8.0) as usize
    } else {
        6
    };
    rounded_to(value, digits)
}
