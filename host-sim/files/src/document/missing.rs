//! Lists all missing keys of a file.
//!
//! serde stops at the first missing field. So the file is read again with a placeholder for it,
//! until no field is missing. Errors about the values of placeholders are ignored.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// Largest number of missing keys; a file that lacks more is not a machine's.
const MOST: usize = 64;

/// Returns the missing keys after the first one, each with the path of its table; `.` is the file
/// itself.
pub fn others<T: DeserializeOwned>(mut table: Table, first: (String, String)) -> Vec<String> {
    let mut missing: Vec<(String, String)> = vec![first];
    let mut kind = 0;
    // Each key costs one pass for each type that its value does not have.
    for _ in 0..MOST * stand_ins().len() {
        let Some((path, key)) = missing.last() else { break };
        let Some(inside) = table_at(&mut table, path) else { break };
        let Some(value) = stand_ins().into_iter().nth(kind) else { break };
        inside.insert(key.clone(), value);
        let Err(error) = serde_path_to_error::deserialize::<_, T>(Value::Table(table.clone()))
        else {
            break;
        };
        match field(&error.path().to_string(), error.inner().message()) {
            Some(next) if !missing.contains(&next) => {
                missing.push(next);
                kind = 0;
            }
            // The placeholder has another type than the key, or lacks keys itself.
            _ => kind += 1,
        }
    }
    missing.iter().skip(1).map(|(path, key)| inside(path, key)).collect()
}

/// Returns the table and the key of a missing field, if serde's message is about one.
pub fn field(path: &str, message: &str) -> Option<(String, String)> {
    let key = message.strip_prefix("missing field `")?.split('`').next()?;
    Some((path.into(), key.into()))
}

/// Returns a key with the path of its table.
fn inside(path: &str, key: &str) -> String {
    if path == "." { key.into() } else { format!("{path}.{key}") }
}

/// Returns a value of each type that a key can have.
fn stand_ins() -> [Value; 5] {
    let pair = vec![Value::Float(1.0), Value::Float(2.0)];
    [
        Value::Float(1.0),
        Value::Integer(1),
        Value::String(String::new()),
        Value::Array(pair),
        Value::Array(Vec::new()),
    ]
}

/// Returns the table at a path with indices, such as `reference.trajectories[0]`.
fn table_at<'a>(table: &'a mut Table, path: &str) -> Option<&'a mut Table> {
    if path == "." {
        return Some(table);
    }
    let mut steps = path.split(['.', '[']).map(|step| step.trim_end_matches(']'));
    let first = table.get_mut(steps.next()?)?;
    let found = steps.try_fold(first, |value, step| match value {
        Value::Array(list) => list.get_mut(step.parse::<usize>().ok()?),
        value => value.get_mut(step),
    })?;
    found.as_table_mut()
}
