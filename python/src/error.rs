//! Errors as exceptions.

use std::io::ErrorKind;

use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::{PyErr, PyResult};
use serde::de::DeserializeOwned;

use files::error::Error;

pyo3::create_exception!(
    stiction,
    Refused,
    PyValueError,
    "A value, a file or a request that cannot be used; the message says why and what can be."
);

/// Returns the exception of an error.
pub fn exception(error: &Error) -> PyErr {
    let sentence = in_python(&error.to_string());
    match error {
        Error::Input(_) | Error::Refused(_) => Refused::new_err(sentence),
        Error::File { source, .. } if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(sentence)
        }
        Error::File { .. } | Error::Output(_) => PyOSError::new_err(sentence),
        _ => PyRuntimeError::new_err(sentence),
    }
}

/// Returns the exception of a sentence about an invalid value.
pub fn refused(sentence: &str) -> PyErr {
    Refused::new_err(in_python(sentence))
}

/// Reads a word that an argument can have.
///
/// # Errors
/// Returns an exception with the allowed words.
pub fn word<T: DeserializeOwned>(argument: &str, word: &str) -> PyResult<T> {
    serde_json::from_value(word.into()).map_err(|error| {
        let error = error.to_string();
        let allowed = error.split_once(", expected ").map_or(&*error, |(_, allowed)| allowed);
        refused(&format!("--{argument} {word}: must be {}", allowed.replace('`', "")))
    })
}

/// Replaces options of the command line by the arguments of the same name: `cut_off` for
/// `--cut-off`.
pub fn in_python(sentence: &str) -> String {
    let mut parts = sentence.split("--");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_part = |c: char| c.is_ascii_lowercase() || c == '-';
        let end = part.find(|c| !is_part(c)).unwrap_or(part.len());
        if !part.starts_with(|c: char| c.is_ascii_lowercase()) {
            text += "--";
        }
        text += &part[..end].replace('-', "_");
        text += &part[end..];
    }
    text
}
