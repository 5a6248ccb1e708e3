//! Checked file of a set of answers.

use super::answers::Answers;
use super::questions::{QUESTIONS, Question};
use super::text::text;
use super::trial;
use super::typical::{TYPICAL, Typical};
use crate::experiment::{Document, Experiment};
use files::error::Error;

/// File that has passed all checks, with its runs.
#[derive(Debug)]
pub struct Written {
    /// Text of the file.
    pub text: String,
    /// The parsed text.
    pub document: Document,
    /// Its runs.
    pub experiment: Experiment,
}

/// Checks that every question has an answer, and the answers against each other.
///
/// # Errors
/// Returns a sentence with the missing options, or with the contradiction.
pub fn complete(answers: &Answers) -> Result<(), String> {
    let missing: Vec<String> = answers.open().iter().map(Question::option).collect();
    if !missing.is_empty() {
        let names = TYPICAL.map(|typical| typical.name).join(", ");
        return Err(format!("missing: {} (or use --typical NAME: {names})", missing.join(", ")));
    }
    let second = "load_encoder.counts_per_turn";
    let is_stray = |question: &&Question| {
        let typed = answers.get(second).is_some_and(|answer| answer.value.is_integer());
        question.key == second && typed && !answers.asks(question)
    };
    if let Some(question) = QUESTIONS.iter().find(is_stray) {
        return Err(format!(
            "{} needs a first encoder on the motor, and a gear with backlash or a stiffness; \
             otherwise leave it out",
            question.option()
        ));
    }
    trial::check(&answers.with_assumptions(), QUESTIONS.len())
}

/// Writes the text of a file, and checks it: plans its runs, and draws the joints at both ends of
/// its ranges.
///
/// # Errors
/// Returns an error that names the key.
pub fn written(name: &str, answers: &Answers, like: Option<&Typical>) -> Result<Written, Error> {
    let text = text(name, answers, like)?;
    let document = Document::parse(name, &text)?;
    let experiment = Experiment::plan(&document, &[], &[])?;
    let spread = document.machine()?.spread;
    for end in [0, 1] {
        let drawn: Vec<String> =
            spread.iter().map(|(key, range)| format!("{key}={:?}", range[end])).collect();
        document.clone().draw(&drawn)?;
    }
    Ok(Written { text, document, experiment })
}
