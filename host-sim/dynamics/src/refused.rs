//! Why there is no such joint, said to a person.

/// A value that no joint can have: one sentence that names what was found and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidModel(pub String);

/// A number as a person would type it: `5`, `0.02`, `1e300`, `NaN`.
pub fn shown(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").unwrap_or(&text).into()
}
