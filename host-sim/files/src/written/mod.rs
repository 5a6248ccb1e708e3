//! A table of a machine's file: values in double precision, declared by the core.
//!
//! The core declares each value once (`stiction::units::value`). Tables of a TOML file are read and
//! written by these declarations: names, types, required values and defaults. The core checks the
//! ranges when it is configured.

mod declared;
mod read;
mod schema;
mod write;

use std::collections::BTreeMap;
use std::marker::PhantomData;

use schemars::{Schema, SchemaGenerator};
use serde::de::MapAccess;
use serde::ser::SerializeMap;
use stiction::ControllerConfig;
use stiction::control::drive::DriveConfig;
use stiction::control::encoder::Encoder;
use stiction::units::value::{About, Kind, Table, Values};

pub(crate) use self::declared::shown as shown_law;
pub use self::declared::{AllGains, DeclaredTable, laws};

/// Word in a file for a limit that is off. Its value is 0.
pub const OFF: &str = "off";

/// Keys of a table that the core does not declare.
pub trait Extras: Default {
    /// Names of the keys.
    const NAMES: &'static [&'static str] = &[];

    /// Returns schema and description of each key, in the order of the names.
    fn schema(_: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        vec![]
    }

    /// Reads the value of a key.
    ///
    /// # Errors
    /// Returns an error if the value has another type.
    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<(), A::Error>;

    /// Returns the name of a required key that is missing.
    fn missing(&self) -> Option<&'static str> {
        None
    }

    /// Writes the keys.
    ///
    /// # Errors
    /// Returns an error if a value cannot be written.
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

/// A value in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileScalar {
    /// A number with a fraction.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// Word from the list in the declaration, by its index.
    Choice(usize),
}

/// A table of a machine's file.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterTable<T, E = ()> {
    values: BTreeMap<&'static str, FileScalar>,
    /// Keys that the core does not declare.
    pub extras: E,
    of: PhantomData<T>,
}

impl<T, E: Default> Default for ParameterTable<T, E> {
    /// Creates an empty table.
    fn default() -> Self {
        Self::with(E::default())
    }
}

impl<T, E> ParameterTable<T, E> {
    /// Creates a table without values declared by the core.
    pub const fn with(extras: E) -> Self {
        Self { values: BTreeMap::new(), extras, of: PhantomData }
    }

    /// Returns a number, if the table has it.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.values.get(name)? {
            FileScalar::Number(number) => Some(*number),
            FileScalar::Whole(whole) => Some(*whole as f64),
            FileScalar::Flag(_) | FileScalar::Choice(_) => None,
        }
    }

    /// Returns a required number. Reading has checked that it is present.
    fn needed(&self, name: &str) -> f64 {
        self.number(name).unwrap_or(f64::NAN)
    }

    /// Returns the values of the table.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, FileScalar)> {
        self.values.iter().map(|(name, value)| (*name, *value))
    }

    /// Copies the values of the table that are declared in `about` to `values`.
    pub fn apply<'a>(&self, about: impl IntoIterator<Item = &'a About>, values: &mut impl Values) {
        for about in about {
            let Some(written) = self.values.get(about.name) else { continue };
            let bits = match *written {
                FileScalar::Number(number) => (number as f32).to_bits(),
                FileScalar::Whole(whole) => whole.clamp(0, u32::MAX.into()) as u32,
                FileScalar::Flag(flag) => flag.into(),
                FileScalar::Choice(place) => place as u32,
            };
            // Cannot fail: the declaration belongs to the values, and the bits have its type.
            let _ = values.set(about.key, bits);
        }
    }

    /// Stores the values that are declared in `about` in the table.
    pub fn put<'a>(&mut self, about: impl IntoIterator<Item = &'a About>, values: &impl Values) {
        for about in about {
            let Some(bits) = values.get(about.key) else { continue };
            self.values.insert(about.name, scalar(about.kind, bits));
        }
    }
}

impl<T: Table, E: Default> ParameterTable<T, E> {
    /// Creates a table with all given values.
    pub fn out(values: &T) -> Self {
        let mut all = Self::default();
        all.put(T::ABOUT, values);
        all
    }

    /// Returns the core's values, in single precision. A value that is missing in the table is that
    /// of `otherwise`.
    pub fn core(&self, otherwise: T) -> T {
        let mut values = otherwise;
        self.apply(T::ABOUT, &mut values);
        values
    }
}

impl<E> ParameterTable<ControllerConfig, E> {
    /// Returns the time between samples, s.
    pub fn sample_time_s(&self) -> f64 {
        self.needed("sample_time_s")
    }

    /// Returns the number of positions in the velocity regression.
    pub fn velocity_window(&self) -> i64 {
        match self.values.get("velocity_window") {
            Some(FileScalar::Whole(whole)) => *whole,
            _ => ControllerConfig::EXAMPLE.velocity_window.into(),
        }
    }
}

impl<E> ParameterTable<Encoder, E> {
    /// Returns the joint angle of one count, deg.
    pub fn resolution_deg(&self) -> f64 {
        self.needed("resolution_deg")
    }
}

impl<E> ParameterTable<DriveConfig, E> {
    /// Returns the largest output, V.
    pub fn full_scale_v(&self) -> f64 {
        self.needed("full_scale_v")
    }

    /// Returns the voltage of one code, V.
    pub fn lsb_v(&self) -> f64 {
        self.needed("lsb_v")
    }
}

/// Converts the bits of a value to its form in a file.
pub fn scalar(kind: Kind, bits: u32) -> FileScalar {
    match kind {
        Kind::Number => FileScalar::Number(single(f32::from_bits(bits))),
        Kind::Whole => FileScalar::Whole(bits.into()),
        Kind::Flag => FileScalar::Flag(bits != 0),
        Kind::Choice(_) => FileScalar::Choice(bits as usize),
    }
}

/// Returns the shortest decimal that reads back as this number in single precision.
pub fn single(value: f32) -> f64 {
    // Shortest by the standard library; a decimal, so that 0.02 is not 0.019999999552965164.
    value.to_string().parse().unwrap_or_else(|_| value.into())
}
