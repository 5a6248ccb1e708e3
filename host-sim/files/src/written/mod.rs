//! A table of a machine's file as it was written: values in double precision under the declarations
//! of the core.
//!
//! The core declares each value once (`stiction::value`). Here a table of a TOML file is read by
//! these declarations, and written by them: names, types, which values have to be there, and what
//! the others are if they are left out. Bounds are the core's own, and checked when it is
//! configured.

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
use stiction::drive::DriveConfig;
use stiction::encoder::Encoder;
use stiction::value::{About, Kind, Table, Values};

pub(crate) use self::declared::shown as shown_law;
pub use self::declared::{AllGains, Declared};

/// The word for a limit that is off; it is zero.
pub const OFF: &str = "off";

/// Keys of a table that the core knows nothing of.
pub trait Extras: Default {
    /// The names of the keys.
    const NAMES: &'static [&'static str] = &[];

    /// Makes the schema and the sentence of each key, in the order of the names.
    fn schema(_: &mut SchemaGenerator) -> Vec<(Schema, &'static str)> {
        vec![]
    }

    /// Reads the value of one of them.
    ///
    /// # Errors
    /// If it is not of its type.
    fn take<'de, A: MapAccess<'de>>(&mut self, name: &str, map: &mut A) -> Result<(), A::Error>;

    /// Names a key that has to be there and is not.
    fn missing(&self) -> Option<&'static str> {
        None
    }

    /// Writes the keys.
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
pub enum FileScalar {
    /// A number with a fraction.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// One of the words of its declaration, by its place.
    Choice(usize),
}

/// A table of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterTable<T, E = ()> {
    values: BTreeMap<&'static str, FileScalar>,
    /// The keys that the core knows nothing of.
    pub extras: E,
    of: PhantomData<T>,
}

impl<T, E: Default> Default for ParameterTable<T, E> {
    /// Nothing is written.
    fn default() -> Self {
        Self::with(E::default())
    }
}

impl<T, E> ParameterTable<T, E> {
    /// Nothing is written of what the core declares.
    pub const fn with(extras: E) -> Self {
        Self { values: BTreeMap::new(), extras, of: PhantomData }
    }

    /// Finds a number, if it is written.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.values.get(name)? {
            FileScalar::Number(number) => Some(*number),
            FileScalar::Whole(whole) => Some(*whole as f64),
            FileScalar::Flag(_) | FileScalar::Choice(_) => None,
        }
    }

    /// A number that has to be there: reading has seen to it.
    fn needed(&self, name: &str) -> f64 {
        self.number(name).unwrap_or(f64::NAN)
    }

    /// Lists the values that are written.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, FileScalar)> {
        self.values.iter().map(|(name, value)| (*name, *value))
    }

    /// Sets those of `values` that are written and declared in `about`.
    pub fn apply<'a>(&self, about: impl IntoIterator<Item = &'a About>, values: &mut impl Values) {
        for about in about {
            let Some(written) = self.values.get(about.name) else { continue };
            let bits = match *written {
                FileScalar::Number(number) => (number as f32).to_bits(),
                FileScalar::Whole(whole) => whole.clamp(0, u32::MAX.into()) as u32,
                FileScalar::Flag(flag) => flag.into(),
                FileScalar::Choice(place) => place as u32,
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

impl<T: Table, E: Default> ParameterTable<T, E> {
    /// Writes out all values of a table.
    pub fn out(values: &T) -> Self {
        let mut all = Self::default();
        all.put(T::ABOUT, values);
        all
    }

    /// Makes the table in single precision, as the core has it; what is left out is its default, or
    /// as in `otherwise`.
    pub fn core(&self, otherwise: T) -> T {
        let mut values = otherwise;
        self.apply(T::ABOUT, &mut values);
        values
    }
}

impl<E> ParameterTable<ControllerConfig, E> {
    /// Tells the time between samples, s.
    pub fn sample_time_s(&self) -> f64 {
        self.needed("sample_time_s")
    }

    /// Tells how many positions the velocity regression takes.
    pub fn velocity_window(&self) -> i64 {
        match self.values.get("velocity_window") {
            Some(FileScalar::Whole(whole)) => *whole,
            _ => ControllerConfig::EXAMPLE.velocity_window.into(),
        }
    }
}

impl<E> ParameterTable<Encoder, E> {
    /// Tells the joint angle of one count, deg.
    pub fn resolution_deg(&self) -> f64 {
        self.needed("resolution_deg")
    }
}

impl<E> ParameterTable<DriveConfig, E> {
    /// Tells the largest output, V.
    pub fn full_scale_v(&self) -> f64 {
        self.needed("full_scale_v")
    }

    /// Tells the volts of one code.
    pub fn lsb_v(&self) -> f64 {
        self.needed("lsb_v")
    }
}

/// Reads the value of these bits, as a person would write it.
pub fn scalar(kind: Kind, bits: u32) -> FileScalar {
    match kind {
        Kind::Number => FileScalar::Number(single(f32::from_bits(bits))),
        Kind::Whole => FileScalar::Whole(bits.into()),
        Kind::Flag => FileScalar::Flag(bits != 0),
        Kind::Choice(_) => FileScalar::Choice(bits as usize),
    }
}

/// Finds the shortest decimal that is read as this number in single precision.
pub fn single(value: f32) -> f64 {
    // Shortest by the standard library; a decimal, so that 0.02 is not 0.019999999552965164.
    value.to_string().parse().unwrap_or_else(|_| value.into())
}
