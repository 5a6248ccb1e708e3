//! A law that takes the place of PD has no use for PD's gains, so a file may leave them out there.

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;
use stiction::units::value::Table as _;
use toml::{Table, Value};

use crate::machine::LawName;

/// Gives zero to the gains of PD that the table of such a controller leaves out; the core has a
/// place for them, and ignores them there.
pub fn fill(file: &mut Table) {
    let Some(controllers) = file.get_mut("controller").and_then(Value::as_table_mut) else {
        return;
    };
    for (name, table) in controllers {
        let Some(table) = table.as_table_mut().filter(|table| stands_alone(name, table)) else {
            continue;
        };
        for gain in PdGains::ABOUT {
            table.entry(gain.name).or_insert(Value::Float(0.0));
        }
    }
}

/// Whether the only law of a controller takes the place of PD: the one that it lists, or else the
/// one of its name.
fn stands_alone(name: &str, table: &Table) -> bool {
    let listed = table.get("laws").map(Value::as_array);
    let law = match listed {
        None => Some(name),
        Some(Some(laws)) if laws.len() == 1 => laws.first().and_then(Value::as_str),
        Some(_) => None,
    };
    law.and_then(LawName::find).and_then(|law| law.0).is_some_and(|law: Gains| law.replaces_pd())
}
