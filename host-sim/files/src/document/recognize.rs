//! Recognizes a file of a machine or of an experiment, to protect it from being written over.

use std::path::Path;

use toml::Table;

use super::read;

/// Tables of which a machine's file or an experiment's has at least one.
const TABLES: [&str; 22] = [
    "controller",
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
    "profile",
    "reference",
    "run",
    "spread",
    "supply",
    "variant",
];

/// Returns whether an existing file holds a machine or an experiment. That is every TOML with one of
/// their tables, and every file that is called `.toml`: one with a mistake in it is as dear to its
/// owner. An empty file holds nothing.
pub fn is_machine_file(path: &Path) -> bool {
    if !path.is_file() {
        return false;
    }
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let Ok(text) = read(path) else { return is_toml };
    let has_tables = |table: Table| TABLES.iter().any(|name| table.contains_key(*name));
    !text.trim().is_empty() && (is_toml || text.parse::<Table>().is_ok_and(has_tables))
}
