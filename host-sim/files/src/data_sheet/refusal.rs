//! Why a data sheet is refused: the key and one sentence.

use std::fmt;

use crate::error::shown;

/// A data sheet that cannot be simulated. Whoever read the file says where it came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetRefusal {
    /// The key or table that it is about.
    pub key: String,
    /// What was found and what is allowed.
    pub sentence: String,
}

impl SheetRefusal {
    /// Of a key, in words of its own.
    pub fn of(key: &str, sentence: String) -> Self {
        Self { key: key.into(), sentence }
    }

    /// A number that is not allowed.
    pub fn number(key: &str, found: f64, allowed: &str) -> Self {
        Self::of(key, format!("`{key}` is {}; allowed is {allowed}", shown(found)))
    }

    /// A key that has to be there.
    pub fn missing(key: &str, why: &str) -> Self {
        Self::of(key, format!("`{key}` is missing; {why}"))
    }
}

impl fmt::Display for SheetRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}
