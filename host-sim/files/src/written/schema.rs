//! Schema of a table: type, range, default and description of each value.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use stiction::Allowed;
use stiction::units::value::{About, Absent, Kind};

use super::{DeclaredTable, Extras, FileScalar, OFF, ParameterTable, single};
use crate::error::shown;

impl<T: DeclaredTable, E: Extras> JsonSchema for ParameterTable<T, E> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Table".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let about = T::about();
        let required: Vec<&str> =
            about.iter().filter(|about| T::needs(about)).map(|about| about.name).collect();
        let declared = about.iter().map(|about| {
            let mut schema = schema_of(about, T::allowed(about), T::otherwise(about));
            let laws = T::laws(about);
            if !laws.is_empty() {
                schema.insert("x-laws".into(), laws.join(", ").into());
            }
            (about.name, schema)
        });
        let mut properties: serde_json::Map<String, serde_json::Value> =
            declared.map(|(name, schema)| (name.to_owned(), schema.into())).collect();
        for (name, (mut schema, text)) in E::NAMES.iter().zip(E::schema(generator)) {
            schema.insert("description".into(), text.into());
            properties.insert((*name).to_owned(), schema.into());
        }
        json_schema!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }
}

/// Returns type, range, default and description of a value. `x-number` is its number in records,
/// and `x-bounds` a range that depends on other values.
fn schema_of(about: &About, allowed: Option<Allowed>, otherwise: Option<FileScalar>) -> Schema {
    let mut schema = match about.kind {
        Kind::Number => json_schema!({ "type": "number" }),
        Kind::Whole => json_schema!({ "type": "integer" }),
        Kind::Flag => json_schema!({ "type": "boolean" }),
        Kind::Choice(words) => {
            let words: Vec<serde_json::Value> = words.iter().map(|word| choice(word)).collect();
            json_schema!({ "enum": words })
        }
    };
    match bounds(about, allowed) {
        Bounds::None => {}
        Bounds::Between(low, high) => {
            schema.insert("minimum".into(), single(low).into());
            schema.insert("maximum".into(), single(high).into());
        }
        Bounds::Above(low, high) => {
            schema.insert("exclusiveMinimum".into(), single(low).into());
            schema.insert("maximum".into(), single(high).into());
        }
        Bounds::Words(words) => {
            schema.insert("x-bounds".into(), words.into());
        }
    }
    if about.may_be_off() {
        schema = json_schema!({ "anyOf": [schema, { "const": OFF }] });
    }
    let default = otherwise.map(|value| match (value, about.kind) {
        (FileScalar::Number(0.0), _) if about.may_be_off() => OFF.into(),
        (FileScalar::Choice(place), Kind::Choice(words)) => choice(words.get(place).unwrap_or(&"")),
        (FileScalar::Flag(flag), _) => flag.into(),
        (FileScalar::Whole(whole), _) => whole.into(),
        (FileScalar::Number(number), _) => number.into(),
        (FileScalar::Choice(_), _) => serde_json::Value::Null,
    });
    if let Some(default) = default {
        schema.insert("default".into(), default);
    }
    schema.insert("description".into(), about.text.trim().into());
    schema.insert("x-number".into(), format!("{:#06x}", about.key.0).into());
    if about.absent == Absent::Derived {
        schema.insert("x-derived".into(), true.into());
    }
    schema
}

/// Returns the JSON value of a word; a word that is a number becomes a number.
fn choice(word: &str) -> serde_json::Value {
    word.parse::<i64>().map_or_else(|_| word.into(), Into::into)
}

/// Range of a value.
enum Bounds {
    None,
    Between(f32, f32),
    Above(f32, f32),
    /// Depends on other values.
    Words(String),
}

/// Returns the range of a declaration. An end that depends on another value is the expression of
/// the source, in the names of the file.
fn bounds(about: &About, allowed: Option<Allowed>) -> Bounds {
    let (low, high, is_above) = match allowed {
        Some(Allowed::Between(low, high) | Allowed::OrOff(low, high)) => (low, high, false),
        Some(Allowed::Above(low, high)) => (low, high, true),
        Some(
            Allowed::Any
            | Allowed::LaterBy(_)
            | Allowed::AnotherLaw
            | Allowed::UpTo(..)
            | Allowed::DueTo(..)
            | Allowed::SetBy(..),
        )
        | None => {
            return Bounds::None;
        }
    };
    let [low_name, high_name] =
        ends(about.bounds).map(|end| end.and_then(|end| in_names(end, about.table)));
    if low_name.is_none() && high_name.is_none() {
        return if is_above { Bounds::Above(low, high) } else { Bounds::Between(low, high) };
    }
    let low = low_name.unwrap_or_else(|| shown(single(low)));
    let high = high_name.unwrap_or_else(|| shown(single(high)));
    Bounds::Words(if is_above {
        format!("above {low}, up to {high}")
    } else {
        format!("from {low} to {high}")
    })
}

/// Returns the expressions of both ends, as in `Above(drive.full_scale / 32_768.0,
/// drive.full_scale)`.
fn ends(bounds: &str) -> [Option<&str>; 2] {
    let inside = bounds.split_once('(').map(|(_, inside)| inside.trim_end_matches(')'));
    let ends = inside.and_then(|inside| inside.split_once(", "));
    [ends.map(|(low, _)| low), ends.map(|(_, high)| high)]
}

/// Returns `drive.full_scale / 32_768.0` in the names of a file, `full_scale_v / 32768`; `None` if
/// the expression names no value. Of values with the same field, that of the own `table` is meant.
fn in_names(expression: &str, table: &str) -> Option<String> {
    let name = |word: &str| {
        let (_, field) = word.split_once('.')?;
        let named = || stiction::parameters::declarations().filter(|about| about.field == field);
        let own = named().find(|about| about.table == table);
        own.or_else(|| named().next()).map(|about| about.name.to_owned())
    };
    expression.split(' ').find_map(name)?;
    let words = expression.split(' ').map(|word| {
        let number = || word.replace('_', "").parse().ok().map(shown);
        name(word).or_else(number).unwrap_or_else(|| word.to_owned())
    });
    Some(words.collect::<Vec<_>>().join(" "))
}
