//! Status and faults of a device as JSON, for programs. Keys are a promise: they are added, and
//! never renamed (docs/reference/command-line.md).

use serde_json::{Value, json};
use stiction::Fault;
use stiction::link::Status;

use super::words;
use files::written::single;

/// Returns a fault: number, name, time since power-on (`tick` times `sample_time`, s), the value
/// that tripped it, and what to do.
pub fn fault(code: u8, [tick, sample_time]: [f64; 2], value: f32) -> Value {
    let fault = Fault::from_code(code);
    let tripped_by = fault.filter(|fault| !fault.unit().is_empty()).map(
        |fault| json!({ "what": fault.value(), "value": single(value), "unit": fault.unit() }),
    );
    json!({
        "code": code,
        "name": fault.map(Fault::describe),
        "time_s": tick * sample_time,
        "tripped_by": tripped_by,
        "section": fault.map(Fault::section),
        "what_to_do": words::advice(code),
    })
}

/// Returns the fault that keeps the motor off; null if there is none.
pub fn latched(status: &Status) -> Value {
    match status.fault.code {
        0 => Value::Null,
        code => {
            let times = [f64::from(status.fault.tick), single(status.sample_time)];
            fault(code, times, status.fault.value)
        }
    }
}

/// Returns a status. Positions count from the reference, or from power-on if there is none.
pub fn status(status: &Status, warning: Option<&str>) -> Value {
    json!({
        "schema": 1,
        "warning": warning,
        "state": words::state(status.state),
        "fault": latched(status),
        "position_counts": status.position,
        "position_deg": f64::from(status.position) * single(status.resolution),
        "at_rest": status.at_rest,
        "thermal_effort_v": single(status.thermal_effort),
        "motor_c": status.motor_temperature.map(single),
        "wound_up": status.wound_up,
        "gave_up": status.gave_up,
        "encoder_in_doubt": status.is_encoder_in_doubt,
        "oscillates": status.oscillates,
        "referenced": status.is_referenced,
        "testing": status.is_testing,
        "failed_test": status.has_failed_test,
        "index_passes": status.index_passes,
        "index_deviation_counts": status.index_deviation,
        "unsaved": status.unsaved,
        "is_damaged": status.is_damaged,
        "saves": status.saves,
        "has_brown_out": status.has_brown_out,
        "crystal_not_measured": status.crystal_not_measured,
        "on_for_s": f64::from(status.clock) * single(status.sample_time),
        "ticks": status.clock,
        "faults": status.faults,
        "bad_frames": status.bad_frames,
        "dropped": status.dropped,
        "wire_noise": status.wire.noise,
        "wire_lost": status.wire.lost,
    })
}

/// Returns the faults that a device has stored (code, tick and value), the oldest first, and the
/// latched one.
pub fn faults(
    remembered: impl Iterator<Item = (u8, u32, f32)>,
    status: &Status,
    warning: Option<&str>,
) -> Value {
    let sample_time = single(status.sample_time);
    let each =
        remembered.map(|(code, tick, value)| fault(code, [f64::from(tick), sample_time], value));
    json!({
        "schema": 1,
        "warning": warning,
        "since_power_on": status.faults,
        "faults": each.collect::<Vec<_>>(),
        "latched": latched(status),
    })
}
