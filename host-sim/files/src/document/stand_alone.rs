//! Fills in the PD gains of a controller whose law replaces PD: a file can leave them out.

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;
use stiction::units::value::Table as _;
use toml::{Table, Value};

use crate::machine::LawName;

/// Sets the missing PD gains of controllers whose law replaces PD to zero. The core stores these
/// gains and ignores them.
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

/// Returns whether the only law of a controller replaces PD: the law that it lists, or else that of
/// its name.
fn stands_alone(name: &str, table: &Table) -> bool {
    let listed = table.get("laws").map(Value::as_array);
    let law = match listed {
        None => Some(name),
        Some(Some(laws)) if laws.len() == 1 => laws.first().and_then(Value::as_str),
        Some(_) => None,
    };
    law.and_then(LawName::find).and_then(|law| law.0).is_some_and(|law: Gains| law.replaces_pd())
}
