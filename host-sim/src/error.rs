//! What can go wrong, said to a person.

use std::io;
use std::path::PathBuf;

/// Why something could not be done. The message is one sentence that names what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something that was asked for is not known, or a value is not allowed.
    #[error("{0}")]
    Input(String),
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// "read" or "write".
        action: &'static str,
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The standard output could not be written to.
    #[error("cannot write the output: {0}")]
    Output(#[from] io::Error),
    /// The flash image could not be run, or did not do what it should.
    #[error("{0}")]
    Emulator(String),
    /// A figure could not be drawn.
    #[error("cannot draw the figure: {0}")]
    Figure(String),
}

/// `: did you mean ...?` for the candidate that is nearest to what was typed, if any is near.
pub fn suggestion<'a>(typed: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    // 0.7 takes transposed, missing and doubled letters and a wrong unit at the end, not another word.
    candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(typed, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| format!("; did you mean `{candidate}`?"))
        .unwrap_or_default()
}
