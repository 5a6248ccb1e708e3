//! Cell of a CSV file whose columns are known at run time only.

use stiction::control::signal::Form;

/// Content of one cell.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Empty.
    None,
    /// A number.
    Double(f64),
    /// A number in single precision, with its shortest decimals.
    Single(f32),
    /// A whole number.
    Whole(i64),
    /// `true` or `false`.
    Flag(bool),
    /// A name.
    Text(String),
}

impl Cell {
    /// Creates the cell of a signal from its 32 bits; a number has its shortest decimals.
    pub fn of(form: Form, bits: u32) -> Self {
        match form {
            Form::Number => Self::Single(f32::from_bits(bits)),
            Form::Whole => Self::Whole((bits as i32).into()),
            Form::Bits => Self::Whole(bits.into()),
        }
    }
}

macro_rules! cells {
    ($($Kind:ident $type:ty;)+) => {
        $(impl From<$type> for Cell {
            fn from(value: $type) -> Self {
                Self::$Kind(value)
            }
        })+
    };
}

cells! {
    Double f64;
    Single f32;
    Whole i64;
    Flag bool;
}

impl From<Option<i32>> for Cell {
    fn from(value: Option<i32>) -> Self {
        value.map_or(Self::None, |value| Self::Whole(value.into()))
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}
