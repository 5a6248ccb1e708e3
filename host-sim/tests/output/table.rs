//! The table that a run prints.

use std::fs;

use serde_json::Value;

use super::stiction;

#[test]
fn every_table_fits_into_80_columns() {
    let directory = tempfile::tempdir().unwrap();
    let long = directory.path().join("long.toml");
    let toml = stiction(&["show", "step-response"])
        .replace("[controller.pd]", "[controller.twenty-letters-at-mo]\nlaws = []")
        .replace("controller = [\"pd\",", "controller = [\"twenty-letters-at-mo\",");
    fs::write(&long, toml).unwrap();
    let listing: Value = serde_json::from_str(&stiction(&["list", "--json"])).unwrap();
    let names = listing["experiments"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| entry["name"].as_str().unwrap());
    for experiment in names.chain([long.to_str().unwrap()]) {
        for delay in ["0", "1"] {
            let toml =
                fs::read_to_string(experiment).unwrap_or_else(|_| stiction(&["show", experiment]));
            // A friction experiment has no samples to delay.
            let of_friction = toml.contains("[mechanism]");
            let arguments = ["run", experiment, "--delay", delay];
            let arguments = if of_friction { &arguments[..2] } else { &arguments };
            // The runs of another delay are left out of the one experiment that has both.
            let table = stiction(arguments);
            let widest = table.lines().map(|line| line.chars().count()).max().unwrap();
            assert!(
                (40..=80).contains(&widest),
                "{experiment}, delay {delay}: {widest} columns\n{table}"
            );
        }
    }
}
