//! A table of a machine's file as it was written: values in double precision under the declarations of the core.
//!
//! The core declares each value once (`stiction::value`). Here a table of a TOML file is read by these declarations,
//! and written by them: names, types, which values have to be there, and what the others are if they are left out.
//! Bounds are the core's own, and checked when it is configured.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use stiction::compensator::Gains;
use stiction::drive::DriveConfig;
use stiction::encoder::Encoder;
use stiction::parameters::DeviceConfig;
use stiction::pd::PdGains;
use stiction::value::{About, Absent, Kind, Table, Values};
use stiction::{ControllerConfig, Limits};

/// The declarations of a table of the file.
pub trait Declared {
    /// Every value that the table may have.
    fn about() -> Vec<&'static About>;

    /// Whether a value has to be there.
    fn needs(about: &About) -> bool {
        about.absent == Absent::Needed
    }

    /// What a value is that is left out, if that does not depend on others.
    fn otherwise(about: &About) -> Option<Scalar>;

    /// The names of the laws that need a value.
    fn laws(_: &About) -> Vec<&'static str> {
        vec![]
    }
}

macro_rules! declared {
    ($($table:ty),+) => {
        $(impl Declared for $table {
            fn about() -> Vec<&'static About> {
                <$table as Table>::ABOUT.iter().collect()
            }

            fn otherwise(about: &About) -> Option<Scalar> {
                let bits = <$table as Table>::EXAMPLE.get(about.key)?;
                (about.absent == Absent::Default).then(|| scalar(about.kind, bits))
            }
        })+
    };
}

declared!(ControllerConfig, Encoder, DriveConfig, DeviceConfig, Limits);

/// `[controller.NAME]`: the gains of PD and of every law. Those of PD have to be there; what else has to be depends on the
/// laws that are listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllGains;

impl Declared for AllGains {
    fn about() -> Vec<&'static About> {
        let mut all: Vec<&About> = PdGains::ABOUT.iter().collect();
        for about in Gains::ABOUT.iter().flat_map(|law| law.iter()) {
            // RI and RVI share a name, and so a key.
            if all.iter().all(|other| other.name != about.name) {
                all.push(about);
            }
        }
        all
    }

    fn needs(about: &About) -> bool {
        PdGains::ABOUT.contains(about)
    }

    fn otherwise(_: &About) -> Option<Scalar> {
        None
    }

    fn laws(about: &About) -> Vec<&'static str> {
        let all = Gains::NAMES.iter().zip(Gains::ABOUT);
        let takes = |law: &&[About]| law.iter().any(|gain| gain.name == about.name);
        all.filter(|(_, law)| takes(law)).map(|(name, _)| *name).collect()
    }
}

/// Keys of a table that the core knows nothing of.
pub trait Extras: Default {
    /// Their names.
    const NAMES: &'static [&'static str] = &[];

    /// Their schemas and sentences, in the order of their names.
    fn schema(_: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        vec![]
    }

    /// Reads the value of one of them.
    ///
    /// # Errors
    /// If it is not of its type.
    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<(), A::Error>;

    /// The name of one that has to be there and is not.
    fn missing(&self) -> Option<&'static str> {
        None
    }

    /// Writes them.
    ///
    /// # Errors
    /// If a value cannot be written.
    fn write<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error>;
}

impl Extras for () {
    fn take<'de, A: MapAccess<'de>>(&mut self, _: &str, _: &mut A) -> Result<(), A::Error> {
        Ok(())
    }

    fn write<M: SerializeMap>(&self, _: &mut M) -> Result<(), M::Error> {
        Ok(())
    }
}

/// A value as it was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scalar {
    /// With a fraction.
    Number(f64),
    /// Whole.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// One of the words of its declaration, by its place.
    Choice(usize),
}

/// A table of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Written<T, E = ()> {
    values: BTreeMap<&'static str, Scalar>,
    /// What the core knows nothing of.
    pub extras: E,
    of: PhantomData<T>,
}

impl<T, E: Default> Default for Written<T, E> {
    /// Nothing is written.
    fn default() -> Self {
        Self::with(E::default())
    }
}

impl<T, E> Written<T, E> {
    /// Nothing is written of what the core declares.
    pub const fn with(extras: E) -> Self {
        Self { values: BTreeMap::new(), extras, of: PhantomData }
    }

    /// A number, if it is written.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.values.get(name)? {
            Scalar::Number(number) => Some(*number),
            Scalar::Whole(whole) => Some(*whole as f64),
            Scalar::Flag(_) | Scalar::Choice(_) => None,
        }
    }

    /// A number that has to be there: reading has seen to it.
    fn needed(&self, name: &str) -> f64 {
        self.number(name).unwrap_or(f64::NAN)
    }

    /// The values that are written.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, Scalar)> {
        self.values.iter().map(|(name, value)| (*name, *value))
    }

    /// Sets those of `values` that are written and declared in `about`.
    pub fn apply<'a>(&self, about: impl IntoIterator<Item = &'a About>, values: &mut impl Values) {
        for about in about {
            let Some(written) = self.values.get(about.name) else { continue };
            let bits = match *written {
                Scalar::Number(number) => (number as f32).to_bits(),
                Scalar::Whole(whole) => whole.clamp(0, u32::MAX.into()) as u32,
                Scalar::Flag(flag) => flag.into(),
                Scalar::Choice(place) => place as u32,
            };
            // Cannot fail: the declaration is that of the values, and the bits are of its type.
            let _ = values.set(about.key, bits);
        }
    }

    /// Writes down the values of `values` that are declared in `about`.
    pub fn put<'a>(&mut self, about: impl IntoIterator<Item = &'a About>, values: &impl Values) {
        for about in about {
            let Some(bits) = values.get(about.key) else { continue };
            self.values.insert(about.name, scalar(about.kind, bits));
        }
    }
}

impl<T: Table, E: Default> Written<T, E> {
    /// All values of a table, written out.
    pub fn out(values: &T) -> Self {
        let mut all = Self::default();
        all.put(T::ABOUT, values);
        all
    }

    /// The table in single precision, as the core has it; what is left out is its default, or as in `otherwise`.
    pub fn core(&self, otherwise: T) -> T {
        let mut values = otherwise;
        self.apply(T::ABOUT, &mut values);
        values
    }
}

impl<E> Written<ControllerConfig, E> {
    /// Time between samples, s.
    pub fn sample_time_s(&self) -> f64 {
        self.needed("sample_time_s")
    }

    /// Positions in the velocity regression.
    pub fn velocity_window(&self) -> i64 {
        match self.values.get("velocity_window") {
            Some(Scalar::Whole(whole)) => *whole,
            _ => ControllerConfig::EXAMPLE.velocity_window.into(),
        }
    }
}

impl<E> Written<Encoder, E> {
    /// Joint angle of one count, deg.
    pub fn resolution_deg(&self) -> f64 {
        self.needed("resolution_deg")
    }
}

impl<E> Written<DriveConfig, E> {
    /// Largest output, V.
    pub fn full_scale_v(&self) -> f64 {
        self.needed("full_scale_v")
    }

    /// Volts of one code.
    pub fn lsb_v(&self) -> f64 {
        self.needed("lsb_v")
    }
}

/// The value of these bits, as a person would write it.
pub fn scalar(kind: Kind, bits: u32) -> Scalar {
    match kind {
        Kind::Number => Scalar::Number(single(f32::from_bits(bits))),
        Kind::Whole => Scalar::Whole(bits.into()),
        Kind::Flag => Scalar::Flag(bits != 0),
        Kind::Choice(_) => Scalar::Choice(bits as usize),
    }
}

/// The shortest decimal that is read as this number in single precision.
pub fn single(value: f32) -> f64 {
    // Shortest by the standard library; a decimal, so that 0.02 is not 0.019999999552965164.
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

/// Reads the key of a table, and refuses one that is not known.
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
            // In serde's own words, which the reader of a file understands.
            E::custom(format!("unknown field `{typed}`, expected one of {}", known.join(", ")))
        })
    }
}

/// Reads a value of a declared type.
struct Value(Kind);

impl<'de> DeserializeSeed<'de> for Value {
    type Value = Scalar;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Scalar, D::Error> {
        match self.0 {
            Kind::Number => f64::deserialize(deserializer).map(Scalar::Number),
            Kind::Whole => deserializer.deserialize_i64(WholeNumber).map(Scalar::Whole),
            Kind::Flag => bool::deserialize(deserializer).map(Scalar::Flag),
            Kind::Choice(words) => deserializer.deserialize_any(Choice(words)),
        }
    }
}

/// A float is not whole, even if it has no fraction: that is a slip of the hand.
struct WholeNumber;

impl Visitor<'_> for WholeNumber {
    type Value = i64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a whole number")
    }

    fn visit_i64<E: de::Error>(self, whole: i64) -> Result<i64, E> {
        // The core's whole numbers have 32 bits and no sign.
        match u32::try_from(whole) {
            Ok(_) => Ok(whole),
            Err(_) => Err(E::invalid_value(de::Unexpected::Signed(whole), &self)),
        }
    }
}

/// One of a few words; those that are numbers are written as such.
struct Choice(&'static [&'static str]);

impl Choice {
    fn find<E: de::Error>(&self, typed: &str) -> Result<Scalar, E> {
        let place = self.0.iter().position(|word| *word == typed);
        place.map(Scalar::Choice).ok_or_else(|| E::unknown_variant(typed, self.0))
    }
}

impl Visitor<'_> for Choice {
    type Value = Scalar;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("one of the words")
    }

    fn visit_str<E: de::Error>(self, typed: &str) -> Result<Scalar, E> {
        self.find(typed)
    }

    fn visit_i64<E: de::Error>(self, typed: i64) -> Result<Scalar, E> {
        self.find(&typed.to_string())
    }
}

impl<'de, T: Declared, E: Extras> Deserialize<'de> for Written<T, E> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor(PhantomData))
    }
}

struct TableVisitor<T, E>(PhantomData<(T, E)>);

impl<'de, T: Declared, E: Extras> Visitor<'de> for TableVisitor<T, E> {
    type Value = Written<T, E>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Written<T, E>, A::Error> {
        let declared = T::about();
        let names: Vec<&'static str> =
            declared.iter().map(|about| about.name).chain(E::NAMES.iter().copied()).collect();
        let mut table = Written::<T, E>::default();
        while let Some(name) = map.next_key_seed(Name(&names))? {
            match declared.iter().find(|about| about.name == name) {
                Some(about) => {
                    table.values.insert(name, map.next_value_seed(Value(about.kind))?);
                }
                None => table.extras.take(name, &mut map)?,
            }
        }
        let gone = declared.iter().find(|about| T::needs(about) && !table.values.contains_key(about.name));
        match gone.map(|about| about.name).or_else(|| table.extras.missing()) {
            Some(name) => Err(de::Error::missing_field(name)),
            None => Ok(table),
        }
    }
}

impl<T: Declared, E: Extras> Serialize for Written<T, E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for about in T::about() {
            let value = self.values.get(about.name).copied().or_else(|| T::otherwise(about));
            match (value, about.kind) {
                (Some(Scalar::Number(number)), _) => map.serialize_entry(about.name, &number)?,
                (Some(Scalar::Whole(whole)), _) => map.serialize_entry(about.name, &whole)?,
                (Some(Scalar::Flag(flag)), _) => map.serialize_entry(about.name, &flag)?,
                (Some(Scalar::Choice(place)), Kind::Choice(words)) => {
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

impl<T: Declared, E: Extras> JsonSchema for Written<T, E> {
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
            let mut schema = schema_of(about, T::otherwise(about));
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

/// A value's type, bounds, default and sentence. Its number in records stands beside them under `x-number`, and bounds
/// that depend on other values under `x-bounds`.
fn schema_of(about: &About, otherwise: Option<Scalar>) -> Schema {
    let mut schema = match about.kind {
        Kind::Number => json_schema!({ "type": "number" }),
        Kind::Whole => json_schema!({ "type": "integer" }),
        Kind::Flag => json_schema!({ "type": "boolean" }),
        Kind::Choice(words) => {
            let words: Vec<serde_json::Value> = words.iter().map(|word| choice(word)).collect();
            json_schema!({ "enum": words })
        }
    };
    match bounds(about) {
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
    let default = otherwise.map(|value| match (value, about.kind) {
        (Scalar::Choice(place), Kind::Choice(words)) => choice(words.get(place).unwrap_or(&"")),
        (Scalar::Flag(flag), _) => flag.into(),
        (Scalar::Whole(whole), _) => whole.into(),
        (Scalar::Number(number), _) => number.into(),
        (Scalar::Choice(_), _) => serde_json::Value::Null,
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

/// A word that is a number is written as one.
fn choice(word: &str) -> serde_json::Value {
    word.parse::<i64>().map_or_else(|_| word.into(), Into::into)
}

/// What a value may be.
enum Bounds {
    None,
    Between(f32, f32),
    Above(f32, f32),
    /// Depends on other values.
    Words(String),
}

/// The bounds of a declaration: figures if they are constants, else the expression of the source in the names of the
/// file.
fn bounds(about: &About) -> Bounds {
    let inside = about.bounds.split_once('(').map(|(_, inside)| inside.trim_end_matches(')'));
    let Some((low, high)) = inside.and_then(|inside| inside.split_once(", ")) else { return Bounds::None };
    let is_above = about.bounds.starts_with("Above");
    if let (Some(low), Some(high)) = (constant(low), constant(high)) {
        return if is_above { Bounds::Above(low, high) } else { Bounds::Between(low, high) };
    }
    let (low, high) = (in_names(low), in_names(high));
    Bounds::Words(if is_above {
        format!("above {low}, up to {high}")
    } else {
        format!("from {low} to {high}")
    })
}

/// A literal, or one of the two names that the declarations use.
fn constant(text: &str) -> Option<f32> {
    match text {
        "HUGE" => Some(1e6),
        "-HUGE" => Some(-1e6),
        "LONGEST" => Some(600.0),
        _ => text.replace('_', "").parse().ok(),
    }
}

/// `drive.full_scale / 32_768.0` as `full_scale_v / 32768`.
fn in_names(expression: &str) -> String {
    let name = |field: &str| stiction::parameters::about().find(|about| about.field == field);
    let words = expression.split(' ').map(|word| match word.split_once('.') {
        Some((_, field)) if name(field).is_some() => name(field).map_or("", |about| about.name).to_owned(),
        _ => constant(word).map_or_else(|| word.to_owned(), |number| crate::error::shown(number.into())),
    });
    words.collect::<Vec<_>>().join(" ")
}
