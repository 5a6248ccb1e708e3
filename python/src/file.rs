//! A machine's file: a first one from answers, and what is doubtful in one.

use pyo3::prelude::*;
use toml::Value;

use super::error::{exception, in_python, refused};
use files::document::{Document, builtins};
use files::error::suggestion;
use simulator::draft::{Answers, QUESTIONS, TYPICAL, Typical, complete, written};

/// Returns the names and the sources of the built-in experiments.
#[pyfunction]
pub fn experiments() -> Vec<(&'static str, String)> {
    let source = |toml: &str| -> String {
        let table = toml.parse::<toml::Table>().unwrap_or_default();
        table.get("source").and_then(Value::as_str).unwrap_or_default().to_owned()
    };
    builtins().iter().map(|builtin| (builtin.name, source(builtin.toml))).collect()
}

/// Returns the names of the typical joints.
#[pyfunction]
pub fn typical() -> Vec<&'static str> {
    TYPICAL.iter().map(|typical| typical.name).collect()
}

/// Returns the text of a machine's file from answers, as texts by the names of their keys; the
/// answers of a typical joint stand for missing ones.
#[pyfunction]
pub fn draft(
    name: &str,
    like: Option<&str>,
    answers: Vec<(String, String)>,
) -> PyResult<(String, Vec<String>)> {
    let like = like.map(Typical::find).transpose().map_err(|error| exception(&error))?;
    let mut given = Answers::default();
    for (key, typed) in answers {
        let question = QUESTIONS.iter().find(|question| question.key == key);
        let question = question.ok_or_else(|| {
            let near = suggestion(&key, QUESTIONS.iter().map(|question| question.key));
            refused(&format!("there is no question `{key}`{near}"))
        })?;
        let value = question.read(&typed).map_err(|why| refused(&format!("{key}: {why}")))?;
        given.put(question.key, value, "");
    }
    let proposed = like.as_ref().map(Typical::answers).transpose();
    let proposed = proposed.map_err(|error| exception(&error))?.unwrap_or_default();
    let answers = given.or(&proposed);
    let missing: Vec<&str> = answers.open().iter().map(|question| question.key).collect();
    if !missing.is_empty() {
        let names = typical().join(", ");
        let missing = missing.join(", ");
        return Err(refused(&format!(
            "missing: {missing} (or start with a typical joint: {names})"
        )));
    }
    complete(&answers).map_err(|why| refused(&why))?;
    let written = written(name, &answers, like.as_ref()).map_err(|error| exception(&error))?;
    let doubts = written.document.doubts().map_err(|error| exception(&error))?;
    Ok((written.text, doubts.iter().map(|doubt| in_python(doubt)).collect()))
}

/// Returns what is doubtful in a machine's file, a sentence each.
#[pyfunction]
pub fn doubts(file: &str) -> PyResult<Vec<String>> {
    let document = Document::open(file).map_err(|error| exception(&error))?;
    let mut doubts = document.doubts().map_err(|error| exception(&error))?;
    if !document.is_lab() {
        let slack = document.unseen_slack().map_err(|error| exception(&error))?;
        doubts.extend(slack.map(|slack| format!("{file}: {slack}")));
    }
    Ok(doubts.iter().map(|doubt| in_python(doubt)).collect())
}
