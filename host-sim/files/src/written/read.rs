//! Reads a table by its declarations. Errors have serde's form.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use stiction::Allowed;
use stiction::units::value::{About, Kind};

use super::{DeclaredTable, Extras, FileScalar, OFF, ParameterTable};

/// Reads the key of a table, and refuses an unknown one.
struct Name<'a>(&'a [&'static str]);

impl<'de> DeserializeSeed<'de> for Name<'_> {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'static str, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for Name<'_> {
    type Value = &'static str;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: de::Error>(self, typed: &str) -> Result<&'static str, E> {
        self.0.iter().find(|name| **name == typed).copied().ok_or_else(|| {
            let known: Vec<String> = self.0.iter().map(|name| format!("`{name}`")).collect();
            // In serde's form, which the document parses.
            E::custom(format!("unknown field `{typed}`, expected one of {}", known.join(", ")))
        })
    }
}

/// Reads a value by its declaration and its allowed values.
struct Value<'a>(&'a About, Option<Allowed>);

impl<'de> DeserializeSeed<'de> for Value<'_> {
    type Value = FileScalar;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<FileScalar, D::Error> {
        match self.0.kind {
            Kind::Number if self.0.may_be_off() => deserializer.deserialize_any(NumberOrOff),
            Kind::Number => f64::deserialize(deserializer).map(FileScalar::Number),
            Kind::Whole => deserializer.deserialize_i64(WholeNumber(self.1)).map(FileScalar::Whole),
            Kind::Flag => bool::deserialize(deserializer).map(FileScalar::Flag),
            Kind::Choice(words) => deserializer.deserialize_any(Choice(words)),
        }
    }
}

/// Reads a number, or the word that turns a limit off.
struct NumberOrOff;

impl Visitor<'_> for NumberOrOff {
    type Value = FileScalar;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number or \"{OFF}\"")
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<FileScalar, E> {
        Ok(FileScalar::Number(number))
    }

    fn visit_i64<E: de::Error>(self, whole: i64) -> Result<FileScalar, E> {
        Ok(FileScalar::Number(whole as f64))
    }

    fn visit_str<E: de::Error>(self, typed: &str) -> Result<FileScalar, E> {
        if typed == OFF {
            return Ok(FileScalar::Number(0.0));
        }
        Err(E::invalid_type(de::Unexpected::Str(typed), &self))
    }
}

/// Reads a whole number. A float is refused, even without a fraction.
struct WholeNumber(Option<Allowed>);

impl Visitor<'_> for WholeNumber {
    type Value = i64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(Allowed::Between(low, high)) => write!(f, "a whole number from {low} to {high}"),
            _ => f.write_str("a whole number"),
        }
    }

    fn visit_i64<E: de::Error>(self, whole: i64) -> Result<i64, E> {
        // The core's whole numbers have 32 bits and no sign.
        match u32::try_from(whole) {
            Ok(_) => Ok(whole),
            Err(_) => Err(E::invalid_value(de::Unexpected::Signed(whole), &self)),
        }
    }
}

/// Reads one of a few words. A word that is a number is written as a number.
struct Choice(&'static [&'static str]);

impl Choice {
    fn find<E: de::Error>(&self, typed: &str) -> Result<FileScalar, E> {
        let place = self.0.iter().position(|word| *word == typed);
        place.map(FileScalar::Choice).ok_or_else(|| E::unknown_variant(typed, self.0))
    }
}

impl Visitor<'_> for Choice {
    type Value = FileScalar;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let are_numbers = self.0.iter().all(|word| word.parse::<i64>().is_ok());
        let what = if are_numbers { "the whole number" } else { "one of the words" };
        write!(f, "{what} {}", self.0.join(" or "))
    }

    fn visit_str<E: de::Error>(self, typed: &str) -> Result<FileScalar, E> {
        self.find(typed)
    }

    fn visit_i64<E: de::Error>(self, typed: i64) -> Result<FileScalar, E> {
        self.find(&typed.to_string())
    }
}

impl<'de, T: DeclaredTable, E: Extras> Deserialize<'de> for ParameterTable<T, E> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor(PhantomData))
    }
}

struct TableVisitor<T, E>(PhantomData<(T, E)>);

impl<'de, T: DeclaredTable, E: Extras> Visitor<'de> for TableVisitor<T, E> {
    type Value = ParameterTable<T, E>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ParameterTable<T, E>, A::Error> {
        let declared = T::about();
        let names: Vec<&'static str> =
            declared.iter().map(|about| about.name).chain(E::NAMES.iter().copied()).collect();
        let mut table = ParameterTable::<T, E>::default();
        while let Some(name) = map.next_key_seed(Name(&names))? {
            match declared.iter().find(|about| about.name == name) {
                Some(about) => {
                    let value = map.next_value_seed(Value(about, T::allowed(about)))?;
                    table.values.insert(name, value);
                }
                None => table.extras.take(name, &mut map)?,
            }
        }
        let gone =
            declared.iter().find(|about| T::needs(about) && !table.values.contains_key(about.name));
        match gone.map(|about| about.name).or_else(|| table.extras.missing()) {
            Some(name) => Err(de::Error::missing_field(name)),
            None => Ok(table),
        }
    }
}
