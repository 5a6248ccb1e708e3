//! Error for a value that no joint can have.

/// Value that no joint can have: one sentence with the value found and the allowed values.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidModel(pub String);

/// Formats a number as a person would type it: `5`, `0.02`, `1e300`, `NaN`.
pub fn shown(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").unwrap_or(&text).into()
}
