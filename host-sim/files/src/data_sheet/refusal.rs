//! Error of a data sheet: the key and one sentence.

use std::fmt;

use crate::error::shown;

/// Error of a data sheet that cannot be simulated. The document adds the name of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetRefusal {
    /// Key or table of the error.
    pub key: String,
    /// Sentence with the value found and the allowed values.
    pub sentence: String,
    /// Cause of the key's range, if the range follows from other keys.
    pub cause: Option<RefusalCause>,
}

/// Keys from which an allowed range follows. If one of them was set by hand, the message names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusalCause {
    /// The keys.
    pub keys: &'static [&'static str],
    /// Sentence about the consequence of the keys.
    pub sentence: String,
}

impl SheetRefusal {
    /// Creates the error of a key with a sentence of its own.
    pub fn of(key: &str, sentence: String) -> Self {
        Self { key: key.into(), sentence, cause: None }
    }

    /// Creates the error of an invalid number.
    pub fn number(key: &str, found: f64, allowed: &str) -> Self {
        Self::of(key, format!("`{key}` is {}; must be {allowed}", shown(found)))
    }

    /// Creates the error of a missing key.
    pub fn missing(key: &str, why: &str) -> Self {
        Self::of(key, format!("`{key}` is missing; {why}"))
    }
}

impl fmt::Display for SheetRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}
