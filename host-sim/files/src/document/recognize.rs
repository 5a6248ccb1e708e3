//! Recognizes files of machines and experiments, to protect them from being overwritten.

use std::path::Path;

use toml::Table;

use super::read;

/// Names of tables. The file of a machine or of an experiment has at least one of them.
const TABLES: [&str; 25] = [
    "brake_resistor",
    "controller",
    "current_sensor",
    "device",
    "drive",
    "encoder",
    "friction",
    "gear",
    "goal",
    "identification",
    "identified",
    "jog",
    "joint",
    "limits",
    "load",
    "loop",
    "mechanism",
    "motor",
    "motor_ntc",
    "profile",
    "reference",
    "run",
    "spread",
    "supply",
    "variant",
];

/// Returns whether an existing file is that of a machine or an experiment: a TOML file with one of
/// their tables, or any file named `.toml` that is not empty. A file with an error in it is
/// protected as well.
pub fn is_machine_file(path: &Path) -> bool {
    if !path.is_file() {
        return false;
    }
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let Ok(text) = read(path) else { return is_toml };
    let has_tables = |table: Table| TABLES.iter().any(|name| table.contains_key(*name));
    !text.trim().is_empty() && (is_toml || text.parse::<Table>().is_ok_and(has_tables))
}
