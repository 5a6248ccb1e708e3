//! The pages that are generated from the declarations say what the code says.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use files::keys;
use simulator::experiment::{Document, builtins};
use stiction::control::laws::RobustDualGains;
use stiction::units::value::{About, Table as _};
use stiction::{Fault, parameters};

fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference").join(name);
    fs::read_to_string(path).unwrap()
}

#[test]
fn the_page_of_parameters_is_up_to_date() {
    let why = "docs/reference/parameters.md is not what `stiction keys --markdown` prints: write it \
               anew";
    assert!(page("parameters.md") == keys::markdown(), "{why}");
}

#[test]
fn the_table_of_faults_is_up_to_date_and_each_fault_has_its_section() {
    let page = page("faults.md");
    let (_, rest) = page.split_once("<!-- generated: stiction keys --faults -->\n").unwrap();
    let (table, _) = rest.split_once("<!-- end -->").unwrap();
    assert!(
        table == keys::faults(),
        "the table of docs/reference/faults.md is not what `stiction keys --faults` prints"
    );
    for fault in Fault::ALL {
        let heading = format!("\n## {}\n", fault.section());
        assert!(page.contains(&heading), "docs/reference/faults.md has no section{heading}");
    }
}

#[test]
fn every_declared_value_has_a_row_with_its_number_and_a_sentence() {
    let rows = keys::rows();
    let tables = ["loop", "encoder", "drive", "device", "limits", "profile", "controller"];
    // The laws of a sum and the motion are written otherwise in a file.
    let own = |about: &&About| tables.contains(&about.table) && !about.field.is_empty();
    for about in parameters::declarations().filter(own) {
        let table = if about.table == "controller" { "controller.NAME" } else { about.table };
        let row = rows.iter().find(|row| row.table == table && row.name == about.name);
        let row = row.unwrap_or_else(|| panic!("{}.{} has no row", about.table, about.name));
        assert!(row.text.ends_with('.') && row.text.len() > 10, "{}: {:?}", about.name, row.text);
        // A key that two laws share has the number of the first. `robust` is two laws: the one for
        // two encoders has numbers of its own.
        let shares = about.table == "controller" && row.number != format!("{:#06x}", about.key.0);
        let is_shared = about.name == "ki_v_per_deg_s" || RobustDualGains::ABOUT.contains(about);
        assert!(!shares || is_shared, "{}: {}", about.name, row.number);
    }
}

#[test]
fn a_table_whose_keys_are_the_user_s_own_is_described_in_words() {
    let listed = keys::list(Some("spread")).unwrap();
    assert!(
        listed.contains("How far the joint may be off") && listed.contains("stick_v"),
        "{listed}"
    );
    let unknown = keys::list(Some("spreads")).unwrap_err().to_string();
    assert!(unknown.contains("there is no such table"), "{unknown}");
}

/// A schema that refuses the thesis would be of no use to an editor.
#[test]
fn the_schema_knows_every_key_of_the_built_in_machines() {
    let known: BTreeSet<(String, String)> =
        keys::rows().into_iter().map(|row| (row.table, row.name)).collect();
    let mut seen = 0;
    for builtin in builtins() {
        if Document::parse(builtin.name, builtin.toml).unwrap().is_lab() {
            continue;
        }
        let machine: toml::Table = builtin.toml.parse().unwrap();
        for (table, value) in &machine {
            let Some(inner) = value.as_table() else { continue };
            for (key, value) in inner {
                let entries: Vec<(String, &String)> = match (table.as_str(), value.as_table()) {
                    ("controller", Some(gains)) => {
                        gains.keys().map(|gain| ("controller.NAME".to_owned(), gain)).collect()
                    }
                    (_, Some(deeper)) => {
                        deeper.keys().map(|one| (format!("{table}.{key}"), one)).collect()
                    }
                    _ if value
                        .as_array()
                        .is_some_and(|list| list.iter().all(toml::Value::is_table)) =>
                    {
                        vec![]
                    }
                    _ => vec![(table.clone(), key)],
                };
                for (table, key) in entries {
                    seen += 1;
                    assert!(
                        known.contains(&(table.clone(), key.clone())),
                        "{}: {table}.{key}",
                        builtin.name
                    );
                }
            }
        }
    }
    assert!(seen > 100, "{seen}");
}
