//! Errors of the simulator, with messages for the user.

use std::io;
use std::path::PathBuf;

pub use dynamics::shown;

/// Error with a message of one sentence: the value found, and the allowed values.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Unknown name, or invalid value.
    #[error("{0}")]
    Input(String),
    /// A file could not be read or written.
    #[error("cannot {action} {}: {}", path.display(), reason(source))]
    File {
        /// "read" or "write".
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The standard output could not be written to.
    #[error("cannot write the output: {}", reason(.0))]
    Output(#[from] io::Error),
    /// The flash image could not be run, or behaved unexpectedly.
    #[error("{0}")]
    Emulator(String),
    /// The user has interrupted the runs.
    #[error("interrupted before the runs on the emulated microcontroller ended: no results")]
    Interrupted,
    /// Ctrl-C ended a command of a device. The message describes the state of the device.
    #[error("{0}")]
    CtrlC(String),
    /// A solver has failed.
    #[error("{0}")]
    Run(String),
    /// A device refuses a request. It is connected, and its state is unchanged.
    #[error("{0}")]
    Refused(String),
    /// A device is not connected, or sends an unexpected answer.
    #[error("{0}")]
    Device(String),
    /// A figure could not be drawn.
    #[error("cannot draw the figure: {0}")]
    Figure(String),
}

impl From<dynamics::InvalidModel> for Error {
    fn from(dynamics::InvalidModel(why): dynamics::InvalidModel) -> Self {
        Self::Input(why)
    }
}

/// Returns the candidate most similar to a typed word, if any is similar.
fn nearest<'a>(typed: &str, candidates: &[&'a str]) -> Option<&'a str> {
    // A similarity of 0.7 accepts transposed, missing and doubled letters and a wrong unit at the
    // end, but no other word. A word of one or two letters resembles too many candidates, so it
    // must be the start of the candidate.
    candidates
        .iter()
        .filter(|candidate| typed.len() > 2 || candidate.starts_with(typed))
        .map(|candidate| (strsim::jaro_winkler(typed, candidate), *candidate))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// Largest number of candidates that a message lists.
const MOST_LISTED: usize = 24;

/// Returns `; did you mean ...?` if a candidate is similar, and the list of all candidates unless
/// it is long.
pub fn suggestion<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let all = match candidates[..] {
        [] => return "; there is none".into(),
        [only] => format!("must be {only}"),
        _ => format!("must be one of {}", candidates.join(", ")),
    };
    match nearest(typed, &candidates) {
        Some(near) if candidates.len() > MOST_LISTED => format!("; did you mean `{near}`?"),
        Some(near) => format!("; did you mean `{near}`? It {all}"),
        None => format!("; {all}"),
    }
}

/// Formats a computed limit with four digits.
pub fn rounded(limit: f64) -> String {
    shown(format!("{limit:.3e}").parse().unwrap_or(limit))
}

/// Returns the message of the operating system, without its number and without the name of a
/// temporary file.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error ").next().unwrap_or(&text).into()
}
