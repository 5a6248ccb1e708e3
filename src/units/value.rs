//! The declaration of configured values: each value is declared once, with all its properties.
//!
//! ```text
//! number | name with unit | type | bounds | needed, default or derived | example | one sentence
//! ```
//!
//! `table!` generates a struct from such declarations, and all code that depends on them: the
//! bounds that [`Values::validate`] checks, the entries of the flash record and of the link (by
//! [`Key`]), and [`Table::ABOUT`]. With [`Table::ABOUT`], a host reads and writes a machine's TOML,
//! lists the keys and generates the schema.
//!
//! A device identifies a value by its number alone. The texts are in [`Table::ABOUT`], which only a
//! host refers to, so the linker leaves them out of an image.

pub use crate::units::key::Key;

use crate::units::error::{Allowed, InvalidValue};

/// Rule for a value that is not set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// The value must be set.
    Needed,
    /// The value is that of the example.
    Default,
    /// The value follows from other values; its sentence has the rule.
    Derived,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number with a fraction.
    Number,
    /// A whole number.
    Whole,
    /// True or false.
    Flag,
    /// One word of this list.
    Choice(&'static [&'static str]),
}

/// The declaration of a value, for hosts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct About {
    /// The value's number.
    pub key: Key,
    /// The table of a machine's TOML file in which the value is.
    pub table: &'static str,
    /// The value's key in that table, with its unit.
    pub name: &'static str,
    /// The field of the struct that holds the value.
    pub field: &'static str,
    /// The sentence that describes the value, as it is in the source.
    pub text: &'static str,
    /// The value's bounds, as they are in the source.
    pub bounds: &'static str,
    /// The value's type.
    pub kind: Kind,
    /// Rule for the value if it is not set.
    pub absent: Absent,
}

impl About {
    /// Returns whether a machine's file may write the value as the word `"off"`, which is zero.
    pub fn may_be_off(&self) -> bool {
        self.bounds.starts_with("OrOff(")
    }
}

/// Error of bits that are no value of the declared type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidBits;

/// Type that a value can have. In a record, a value of any type has 32 bits.
pub trait Scalar: Copy {
    /// The kind of value that the type makes.
    const KIND: Kind;

    /// Returns the value's 32 bits.
    fn bits(self) -> u32;

    /// Returns the value with these 32 bits.
    ///
    /// # Errors
    /// Refuses bits that no value of the type has.
    fn from_bits(bits: u32) -> Result<Self, InvalidBits>;

    /// Returns the value as a number, to be compared with bounds.
    fn number(self) -> f32;
}

impl Scalar for f32 {
    const KIND: Kind = Kind::Number;

    fn bits(self) -> u32 {
        self.to_bits()
    }

    fn from_bits(bits: u32) -> Result<Self, InvalidBits> {
        Ok(Self::from_bits(bits))
    }

    fn number(self) -> f32 {
        self
    }
}

impl Scalar for u32 {
    const KIND: Kind = Kind::Whole;

    fn bits(self) -> u32 {
        self
    }

    fn from_bits(bits: u32) -> Result<Self, InvalidBits> {
        Ok(bits)
    }

    fn number(self) -> f32 {
        self as f32
    }
}

impl Scalar for bool {
    const KIND: Kind = Kind::Flag;

    fn bits(self) -> u32 {
        self.into()
    }

    fn from_bits(bits: u32) -> Result<Self, InvalidBits> {
        match bits {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(InvalidBits),
        }
    }

    fn number(self) -> f32 {
        self.bits() as f32
    }
}

/// Set of values that are accessed by their keys: the values of one table, or of a table and the
/// tables in it.
pub trait Values {
    /// Returns the key of the value at a place (0 is the first) among the present values, and the
    /// rule for the value if it is not set. If there are too few values, lowers `place` by their
    /// number and returns none, so that the caller can go on with the next table.
    fn nth(&self, place: &mut usize) -> Option<(Key, Absent)>;

    /// Returns the bits of a value, if the value belongs to this set.
    fn get(&self, key: Key) -> Option<u32>;

    /// Returns a value as a number, and its allowed values, which can depend on the other present
    /// values.
    fn with_bounds(&self, key: Key) -> Option<(f32, Allowed)>;

    /// Sets a value from its bits, and returns whether the value belongs to this set. Bounds are
    /// checked by [`validate`](Self::validate).
    ///
    /// # Errors
    /// Refuses bits that are no value of its type.
    fn set(&mut self, key: Key, bits: u32) -> Result<bool, InvalidBits>;

    /// Calls `f` for each present value, until `f` returns an error.
    ///
    /// # Errors
    /// Returns the first error of `f`.
    fn each<E>(&self, f: &mut impl FnMut(Key, Absent) -> Result<(), E>) -> Result<(), E> {
        for place in 0..MAX_VALUES {
            let Some((key, absent)) = self.nth(&mut { place }) else { break };
            f(key, absent)?;
        }
        Ok(())
    }

    /// Returns the allowed values of a value, which can depend on the other present values.
    fn allowed(&self, key: Key) -> Option<Allowed> {
        self.with_bounds(key).map(|(_, allowed)| allowed)
    }

    /// Refuses a value that is not within its bounds.
    ///
    /// # Errors
    /// Returns an error that names the first such value.
    fn validate(&self) -> Result<(), InvalidValue> {
        self.each(&mut |key, _| match self.with_bounds(key) {
            Some((found, allowed)) if !allowed.includes(found) => {
                Err(InvalidValue { key, found, allowed })
            }
            _ => Ok(()),
        })
    }
}

/// Limit of the loop over all values, well above the capacity of a record (338).
const MAX_VALUES: usize = 1024;

/// A table of a machine's file.
pub trait Table: Values + Sized + 'static {
    /// Every value as a typical machine has it; a value with a default has the default.
    const EXAMPLE: Self;
    /// The declarations, in the order of the numbers.
    const ABOUT: &'static [About];
}

/// Returns the key of the value in the field `field` of a table. It is for constants: a field that
/// does not exist does not compile.
pub const fn key(table: &[About], field: &str) -> Key {
    let mut i = 0;
    while i < table.len() {
        if equal(table[i].field.as_bytes(), field.as_bytes()) {
            return table[i].key;
        }
        i += 1;
    }
    assert!(i < table.len(), "no value of this table has that name");
    Key(0)
}

pub(crate) const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// Declares a table: a struct of configured values, and of other values that belong to it (`with`).
///
/// ```text
/// table! {
///     /// Documentation of the struct.
///     pub struct Name (this) "table of the TOML file" {
///         /// The sentence of the value.
///         field: type = 0x0401 "name_with_unit", bounds, Needed(example);
///     }
///     with {
///         /// Values of other tables.
///         other: OtherTable,
///     }
/// }
/// ```
///
/// `bounds` is an [`Allowed`], in which `this` is the struct. `Needed` may also be
/// `Default` or `Derived`: see [`Absent`]. After the table's name can stand `if (present)`. If that
/// condition is false, the table has no values. [`Values::set`] still accepts them.
macro_rules! table {
    (
        $(#[$meta:meta])*
        $vis:vis struct $Table:ident ($this:ident) $table:literal $(if ($present:expr))? {
            $(
                $(#[doc = $text:literal])+
                $field:ident: $type:ty =
                    $key:literal $name:literal, $bounds:expr, $absent:ident($example:expr);
            )*
        }
        $(with {
            $(
                $(#[$other_meta:meta])*
                $other:ident: $other_type:ty = $other_example:expr,
            )+
        })?
    ) => {
        $(#[$meta])*
        $vis struct $Table {
            $(
                $(#[doc = $text])+
                pub $field: $type,
            )*
            $($(
                $(#[$other_meta])*
                pub $other: $other_type,
            )+)?
        }

        impl $crate::units::value::Values for $Table {
            fn nth(
                &self,
                place: &mut usize,
            ) -> Option<($crate::units::value::Key, $crate::units::value::Absent)> {
                const OWN: &[($crate::units::value::Key, $crate::units::value::Absent)] =
                    &[$(($crate::units::value::Key($key), $crate::units::value::Absent::$absent)),*];
                $(
                    let $this = self;
                    if !$present {
                        return None;
                    }
                )?
                if let Some(own) = OWN.get(*place) {
                    return Some(*own);
                }
                *place -= OWN.len();
                None $($(.or_else(|| $crate::units::value::Values::nth(&self.$other, place)))+)?
            }

            fn get(&self, key: $crate::units::value::Key) -> Option<u32> {
                $(
                    let $this = self;
                    if !$present {
                        return None;
                    }
                )?
                match key.0 {
                    $($key => Some($crate::units::value::Scalar::bits(self.$field)),)*
                    _ => None $($(.or_else(|| $crate::units::value::Values::get(&self.$other, key)))+)?,
                }
            }

            fn with_bounds(&self, key: $crate::units::value::Key) -> Option<(f32, $crate::units::error::Allowed)> {
                #[allow(unused_imports)]
                use $crate::units::error::Allowed::*;
                let $this = self;
                // Most bounds are constants.
                let _ = $this;
                match key.0 {
                    $($key => Some(($crate::units::value::Scalar::number(self.$field), $bounds)),)*
                    _ => None $($(
                        .or_else(|| $crate::units::value::Values::with_bounds(&$this.$other, key))
                    )+)?,
                }
            }

            fn set(
                &mut self,
                key: $crate::units::value::Key,
                bits: u32,
            ) -> Result<bool, $crate::units::value::InvalidBits> {
                match key.0 {
                    $($key => self.$field = $crate::units::value::Scalar::from_bits(bits)?,)*
                    _ => return Ok(
                        false $($(|| $crate::units::value::Values::set(&mut self.$other, key, bits)?)+)?
                    ),
                }
                #[allow(unreachable_code)]
                Ok(true)
            }
        }

        impl $crate::units::value::Table for $Table {
            const EXAMPLE: Self = Self {
                $($field: $example,)*
                $($($other: $other_example,)+)?
            };
            const ABOUT: &'static [$crate::units::value::About] = &[$($crate::units::value::About {
                key: $crate::units::value::Key($key),
                table: $table,
                name: $name,
                field: stringify!($field),
                text: concat!($($text),+),
                bounds: stringify!($bounds),
                kind: <$type as $crate::units::value::Scalar>::KIND,
                absent: $crate::units::value::Absent::$absent,
            }),*];
        }
    };
}

/// Declares the type of a value that is one of a few words.
macro_rules! choice {
    (
        $(#[$meta:meta])*
        $vis:vis enum $Choice:ident {
            $($(#[$variant_meta:meta])* $variant:ident = $bits:literal $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $Choice {
            $($(#[$variant_meta])* $variant = $bits,)+
        }

        impl $crate::units::value::Scalar for $Choice {
            const KIND: $crate::units::value::Kind = $crate::units::value::Kind::Choice(&[$($word),+]);

            fn bits(self) -> u32 {
                self as u32
            }

            fn from_bits(bits: u32) -> Result<Self, $crate::units::value::InvalidBits> {
                match bits {
                    $($bits => Ok(Self::$variant),)+
                    _ => Err($crate::units::value::InvalidBits),
                }
            }

            fn number(self) -> f32 {
                self as u32 as f32
            }
        }
    };
}

pub(crate) use {choice, table};
