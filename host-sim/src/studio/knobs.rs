//! Sliders of the what-if view: the gains of every controller, and the joint.
//!
//! A gain of zero is off, and has no slider. The bounds are those of the slider only: the core may
//! still refuse a value within them.

use serde_json::{Value, json};
use toml::Table;

use super::form::about;
use super::machine_in_use::MachineInUse;
use files::keys;

/// Key of the joint's gain in a file: the inverse of its inertia.
pub const GAIN: &str = "joint.gain_deg_per_s2_per_v";

/// Path of the inertia's slider, in multiples of the file's inertia; it sets [`GAIN`].
pub const INERTIA: &str = "inertia";

/// Key of the computation delay, whole samples.
pub const DELAY: &str = "run.delay_samples";

/// Factor from a slider's value up to its upper end and down to its lower end.
const FACTOR: f64 = 8.0;

/// Returns the sliders of a machine, those of the law in use first.
pub fn knobs(machine: &MachineInUse) -> Vec<Value> {
    let declared = keys::rows();
    let number = |path: &str| machine.document.number(path);
    let knob = |path: &str, of: &str, name: &str, value: f64, text: &str| {
        json!({
            "path": path, "of": of, "name": name, "value": value, "text": text,
            "low": value / FACTOR, "high": value * FACTOR, "scale": "ratio",
        })
    };
    let mut all = Vec::new();
    for law in &machine.laws {
        let table = format!("controller.{law}");
        let gains = machine.document.get(&table).and_then(toml::Value::as_table);
        for (name, value) in gains.into_iter().flat_map(Table::iter) {
            let Some(value) = value.as_float().filter(|value| *value > 0.0) else { continue };
            let text = about(&declared, &table, name).map_or("", |row| &row.text);
            all.push(knob(&format!("{table}.{name}"), law, name, value, text));
        }
    }
    let mut of_joint = |path: &str, name: &str, value: f64, text: &str| {
        all.push(knob(path, "joint", name, value, text));
    };
    of_joint(INERTIA, "inertia, × the file's", 1.0, "Twice the inertia is half the `joint.gain`.");
    for (path, name, text) in [
        ("joint.friction.stick_v", "stick_v", "The effort that starts the joint, V."),
        ("joint.friction.slip_v", "slip_v", "The effort that keeps it moving slowly, V."),
        ("joint.viscous_v_per_deg_per_s", "viscous_v_per_deg_per_s", "Viscous friction, V s/deg."),
    ] {
        if let Some(value) = number(path).filter(|value| *value > 0.0) {
            of_joint(path, name, value, text);
        }
    }
    let delay = number(DELAY).unwrap_or(0.0);
    all.push(json!({
        "path": DELAY, "of": "joint", "name": "delay, samples", "value": delay,
        "text": "Samples from a reading to its output.", "low": 0.0, "high": 1.0,
        "scale": "whole",
    }));
    all
}
