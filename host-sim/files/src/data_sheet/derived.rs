//! Derives keys of a file's tables from its data sheet.

use stiction::Hardware;
use stiction::control::drive::pwm_top;
use toml::{Table, Value};

use super::refusal::SheetRefusal;
use super::sheet::DataSheet;
use super::tables::DrivenBy;
use super::units::{Mapping, WrittenDrive};
use crate::error::shown;
use crate::typed_number;

/// Keys that are derived from a data sheet, and needed in a file without one.
pub const OF_A_SHEET: [&str; 7] = [
    "joint.gain_deg_per_s2_per_v",
    "joint.viscous_v_per_deg_per_s",
    "joint.friction.stick_v",
    "joint.friction.slip_v",
    "encoder.resolution_deg",
    "drive.full_scale_v",
    "drive.lsb_v",
];

/// Largest code of the core: 15 bits and a sign.
const MOST_CODES: f64 = 32_767.0;

fn get<'a>(table: &'a Table, key: &str) -> Option<&'a Value> {
    let mut path = key.split('.');
    let first = table.get(path.next()?)?;
    path.try_fold(first, |value, part| value.get(part))
}

fn number(table: &Table, key: &str) -> Option<f64> {
    get(table, key).and_then(typed_number::of_value)
}

/// Maps a data sheet to the core's units, with the other keys of its file.
///
/// # Errors
/// Returns an error that names a missing key of the drive.
pub fn mapping(sheet: &DataSheet, table: &Table) -> Result<Mapping, SheetRefusal> {
    let written = WrittenDrive {
        full_scale_v: number(table, "drive.full_scale_v"),
        duty_max: number(table, "drive.duty_max"),
    };
    Mapping::of(sheet, written).ok_or_else(|| {
        let why = "set it, or set `motor.current_limit_a`, from which it is derived";
        SheetRefusal::missing("drive.full_scale_v", why)
    })
}

/// Writes the derived keys of a data sheet into the tables of its file.
///
/// # Errors
/// Returns an error that names a derived key that the file sets as well, or an effect that cannot
/// be simulated.
pub fn derive(
    table: &mut Table,
    sheet: &DataSheet,
    hardware: &Hardware,
) -> Result<(), SheetRefusal> {
    alone(table, sheet)?;
    sheet.can_be_simulated()?;
    let mapping = mapping(sheet, table)?;
    sheet.can_move(&mapping)?;
    let mut give = |key: &str, value: f64| put(table, key, value);
    give("joint.gain_deg_per_s2_per_v", mapping.gain());
    give("joint.viscous_v_per_deg_per_s", mapping.viscous_v());
    give("joint.friction.stick_v", mapping.volts(sheet.stick()[0]));
    give("joint.friction.slip_v", mapping.volts(sheet.slip()[0]));
    give("drive.full_scale_v", mapping.full_scale_v);
    if mapping.duty_max < 1.0 {
        give("drive.duty_max", mapping.duty_max);
    }
    if let Some(count) = mapping.count {
        give("encoder.resolution_deg", count.to_degrees());
    }
    if sheet.motor.dead_time_s > 0.0 {
        give("device.dead_time_s", sheet.motor.dead_time_s);
    }
    if let Some(lsb_v) = step_of_the_timer(table, mapping.full_scale_v, hardware)? {
        put(table, "drive.lsb_v", lsb_v);
    }
    Ok(())
}

/// Returns one step of the board's timer, V; `None` without a PWM frequency, or if the file sets
/// the step itself.
///
/// # Errors
/// Refuses a frequency that the board cannot make. Ignoring it would report a missing `lsb_v`.
fn step_of_the_timer(
    table: &Table,
    full_scale_v: f64,
    hardware: &Hardware,
) -> Result<Option<f64>, SheetRefusal> {
    if get(table, "drive.lsb_v").is_some() {
        return Ok(None);
    }
    const PWM_HZ: &str = "drive.pwm_hz";
    let Some(pwm_hz) = number(table, PWM_HZ) else { return Ok(None) };
    let Some(mode) = get(table, "drive.mode").and_then(Value::as_str) else { return Ok(None) };
    let top = pwm_top(hardware, pwm_hz as f32);
    let top = top.map_err(|why| SheetRefusal::number(PWM_HZ, pwm_hz, &why.allowed.to_string()))?;
    // Half duty is zero volts, unless a second pin sets the direction.
    let codes = match mode {
        "sign-magnitude" => f64::from(top),
        _ => (f64::from(top) / 2.0).floor(),
    };
    let lsb_v = full_scale_v / codes.min(MOST_CODES);
    // Five digits, rounded down, so that the quotient reaches the last code.
    let scale = 10_f64.powf(4.0 - lsb_v.log10().floor());
    Ok(Some((lsb_v * scale).floor() / scale))
}

/// Refuses keys in the core's units that are derived from the data sheet.
fn alone(table: &Table, sheet: &DataSheet) -> Result<(), SheetRefusal> {
    let both = |key: &str, other: &str| {
        let found = get(table, key).map(ToString::to_string).unwrap_or_default();
        let sentence =
            format!("`{key}` is {found}; must be left out: it is derived from `{other}`");
        Err(SheetRefusal::of(key, sentence))
    };
    for (key, other) in [
        ("joint.gain_deg_per_s2_per_v", "load.inertia_kg_m2"),
        ("joint.viscous_v_per_deg_per_s", "friction.viscous_nm_s_per_rad"),
        ("joint.friction.stick_v", "friction.stick_nm"),
        ("joint.friction.slip_v", "friction.slip_nm"),
    ] {
        if get(table, key).is_some() {
            return both(key, other);
        }
    }
    if sheet.encoder.lines.is_some() && get(table, "encoder.resolution_deg").is_some() {
        return both("encoder.resolution_deg", "encoder.lines");
    }
    if sheet.encoder.lines.is_none() && get(table, "encoder.resolution_deg").is_none() {
        let why = "set it, or `resolution_deg`, the joint angle of one count";
        return Err(SheetRefusal::missing("encoder.lines", why));
    }
    if sheet.motor.dead_time_s > 0.0 {
        if get(table, "device.dead_time_s").is_some() {
            return both("device.dead_time_s", "motor.dead_time_s");
        }
        let mode = get(table, "drive.mode").and_then(Value::as_str).unwrap_or_default();
        if mode != "locked-antiphase" {
            let allowed = format!("0, since `drive.mode` is {mode:?}, which has no dead time");
            return Err(SheetRefusal::number(
                "motor.dead_time_s",
                sheet.motor.dead_time_s,
                &allowed,
            ));
        }
    }
    if let (DrivenBy::Voltage, Some(supply), Some(written)) =
        (sheet.motor.driven_by, &sheet.supply, number(table, "drive.full_scale_v"))
        && written != supply.voltage_v
    {
        let key = "drive.full_scale_v";
        let allowed = format!(
            "left out, or equal to `supply.voltage_v` ({}), the motor's voltage at full duty",
            shown(supply.voltage_v)
        );
        return Err(SheetRefusal::number(key, written, &allowed));
    }
    Ok(())
}

/// Sets a number, unless the file sets it.
fn put(table: &mut Table, key: &str, number: f64) {
    let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = table;
    for part in tables.split('.') {
        let inner = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
        // Reading the file refuses a value of another type.
        let Value::Table(inner) = inner else { return };
        table = inner;
    }
    table.entry(last).or_insert(Value::Float(number));
}
