//! Writes a table by its declarations; missing values are written as their defaults.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use stiction::units::value::Kind;

use super::{DeclaredTable, Extras, FileScalar, OFF, ParameterTable};

impl<T: DeclaredTable, E: Extras> Serialize for ParameterTable<T, E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for about in T::about() {
            let has = |name: &str| self.values.contains_key(name);
            let value = match self.values.get(about.name) {
                Some(value) => Some(*value),
                None if T::belongs(about, &has) => T::otherwise(about),
                None => None,
            };
            match (value, about.kind) {
                (Some(FileScalar::Number(0.0)), _) if about.may_be_off() => {
                    map.serialize_entry(about.name, OFF)?;
                }
                (Some(FileScalar::Number(number)), _) => {
                    map.serialize_entry(about.name, &number)?
                }
                (Some(FileScalar::Whole(whole)), _) => map.serialize_entry(about.name, &whole)?,
                (Some(FileScalar::Flag(flag)), _) => map.serialize_entry(about.name, &flag)?,
                (Some(FileScalar::Choice(place)), Kind::Choice(words)) => {
                    let word = words.get(place).copied().unwrap_or_default();
                    match word.parse::<i64>() {
                        Ok(whole) => map.serialize_entry(about.name, &whole)?,
                        Err(_) => map.serialize_entry(about.name, word)?,
                    }
                }
                _ => {}
            }
        }
        self.extras.write(&mut map)?;
        map.end()
    }
}
