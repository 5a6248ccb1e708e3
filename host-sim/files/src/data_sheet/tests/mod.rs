//! Tests that a data sheet is the same in the core's units and in SI, and that its joint moves so.

mod motion;
mod numbers;
mod slack;

use toml::Table;

use super::tables::DrivenBy;
use super::{DataSheet, Mapping, SheetTables, WrittenDrive};

/// Data sheet of a rigid joint with a bridge, in round numbers.
const BRIDGE: &str = "
    motor = { resistance_ohm = 2.0, kt_nm_per_a = 0.05, rotor_inertia_kg_m2 = 1e-4 }
    gear = { ratio = 100, efficiency = 0.8 }
    load = { inertia_kg_m2 = 0.2 }
    friction = { stick_nm = 5.0, slip_nm = 4.0, viscous_nm_s_per_rad = 3.0 }
    supply = { voltage_v = 24 }
    encoder = { lines = 500, at = 'motor' }
";

/// Returns [`BRIDGE`] with some keys set, and its mapping.
fn sheet(set: &[(&str, &str)]) -> (DataSheet, Mapping) {
    let mut table: Table = BRIDGE.parse().unwrap();
    for (key, value) in set {
        let (of, key) = key.split_once('.').unwrap();
        let value = format!("v = {value}").parse::<Table>().unwrap().remove("v").unwrap();
        let of = table.entry(of).or_insert_with(|| Table::new().into());
        of.as_table_mut().unwrap().insert(key.to_owned(), value);
    }
    let tables: SheetTables = table.try_into().unwrap();
    let sheet = tables.sheet().unwrap().unwrap();
    let mapping = Mapping::of(&sheet, WrittenDrive::default()).unwrap();
    (sheet, mapping)
}

/// Returns the deviation of `found` from `expected`, as a part of `expected`.
fn off(found: f64, expected: f64) -> f64 {
    ((found - expected) / expected).abs()
}

/// A chip on a bus has no lines of a timer.
#[test]
fn an_output_of_lines_is_refused_for_an_encoder_that_has_none() {
    let refusal = |lines: &str| {
        let table = format!("{BRIDGE}\nload_encoder = {{ counts_per_turn = 16384, {lines} }}");
        let tables: SheetTables = table.parse::<Table>().unwrap().try_into().unwrap();
        tables.sheet().err().map(|refusal| refusal.to_string())
    };
    let chip = "kind = 'as5047p', zero_counts = 0";
    assert_eq!(refusal(chip), None);
    assert_eq!(refusal("output = 'push-pull'"), None);
    for output in ["push-pull", "open-collector", "receiver"] {
        let found = refusal(&format!("{chip}, output = '{output}'")).unwrap();
        assert!(found.contains("`load_encoder.output` belongs to an incremental"), "{found}");
        assert!(found.contains("remove the line"), "{found}");
    }
}

#[test]
fn the_joint_of_these_tests_is_driven_by_a_voltage() {
    assert_eq!(sheet(&[]).0.motor.driven_by, DrivenBy::Voltage);
}
