//! What can go wrong, said to a person.

use std::io;
use std::path::PathBuf;

pub use dynamics::shown;

/// Why something could not be done. The message is one sentence that names what was found and what
/// is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something that was asked for is not known, or a value is not allowed.
    #[error("{0}")]
    Input(String),
    /// A file could not be read or written.
    #[error("cannot {action} {}: {}", path.display(), reason(source))]
    File {
        /// "read" or "write".
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The standard output could not be written to.
    #[error("cannot write the output: {}", reason(.0))]
    Output(#[from] io::Error),
    /// The flash image could not be run, or did not do what it should.
    #[error("{0}")]
    Emulator(String),
    /// The user wants no more of it.
    #[error("interrupted before the runs on the emulated part were over: there are no results")]
    Interrupted,
    /// Ctrl-C ended a command of a device. The sentence says how the device is left.
    #[error("{0}")]
    CtrlC(String),
    /// A solver gave a run up.
    #[error("{0}")]
    Run(String),
    /// A device says why it does not do what it was told. It is there, and all is as it was.
    #[error("{0}")]
    Refused(String),
    /// A device does not answer as it should, or is not there.
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

/// The candidate that is nearest to what was typed, if any is near.
fn nearest<'a>(typed: &str, candidates: &[&'a str]) -> Option<&'a str> {
    // 0.7 takes transposed, missing and doubled letters and a wrong unit at the end, not another
    // word. A word of one or two letters is like any that holds them: it has to begin like the
    // candidate.
    candidates
        .iter()
        .filter(|candidate| typed.len() > 2 || candidate.starts_with(typed))
        .map(|candidate| (strsim::jaro_winkler(typed, candidate), *candidate))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// Nobody reads longer lists in a message.
const MOST_LISTED: usize = 24;

/// `; did you mean ...?` if a candidate is near, and all there are.
pub fn suggestion<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let all = match candidates[..] {
        [] => return "; there is none".into(),
        [only] => format!("allowed is {only}"),
        _ => format!("allowed are {}", candidates.join(", ")),
    };
    match nearest(typed, &candidates) {
        Some(near) if candidates.len() > MOST_LISTED => format!("; did you mean `{near}`?"),
        Some(near) => format!("; did you mean `{near}`? {all}"),
        None => format!("; {all}"),
    }
}

/// A computed limit, to four digits.
pub fn rounded(limit: f64) -> String {
    shown(format!("{limit:.3e}").parse().unwrap_or(limit))
}

/// What the system said, without its number and without the name of a temporary file that nobody
/// asked for.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error ").next().unwrap_or(&text).into()
}
