//! The dialogue on a terminal, by `inquire`. It writes to the standard error, since the file can go
//! to the standard output.

use std::io::{self, Write, stderr};
use std::rc::Rc;

use inquire::ui::{RenderConfig, Styled};
use inquire::validator::Validation;
use inquire::{InquireError, Select, Text};

use super::dialogue::{AnswerCheck, Prompt, PromptReply};
use files::error::Error;

/// Largest width of a message, columns.
const WIDTH: usize = 78;

/// Prompt on the terminal of the standard input.
#[derive(Clone, Copy, Debug)]
pub struct Terminal;

/// Returns the default colors, with an indicator of a step back.
fn style() -> RenderConfig<'static> {
    RenderConfig::default().with_canceled_prompt_indicator(Styled::new("(back)"))
}

fn reply<T>(answer: Result<T, InquireError>) -> Result<PromptReply<T>, Error> {
    match answer {
        Ok(answer) => Ok(PromptReply::Given(answer)),
        Err(InquireError::OperationCanceled) => Ok(PromptReply::Back),
        Err(InquireError::OperationInterrupted) => Err(Error::Interrupted),
        Err(InquireError::IO(error)) => Err(Error::Output(error)),
        Err(other) => Err(Error::Output(io::Error::other(other.to_string()))),
    }
}

impl Prompt for Terminal {
    fn choose(
        &mut self,
        question: &str,
        help: &str,
        choices: &[String],
        start: usize,
    ) -> Result<PromptReply<usize>, Error> {
        let help = format!("{help} (arrows, Enter)");
        let select = Select::new(question, choices.to_vec())
            .with_starting_cursor(start)
            .with_help_message(&help)
            .with_render_config(style())
            .without_filtering();
        Ok(match reply(select.raw_prompt())? {
            PromptReply::Given(chosen) => PromptReply::Given(chosen.index),
            PromptReply::Back => PromptReply::Back,
        })
    }

    fn enter(
        &mut self,
        question: &str,
        help: &str,
        proposed: Option<&str>,
        check: &AnswerCheck,
    ) -> Result<PromptReply<String>, Error> {
        let check = Rc::clone(check);
        let text =
            Text::new(question).with_render_config(style()).with_validator(move |typed: &str| {
                Ok(match check(typed) {
                    Ok(()) => Validation::Valid,
                    Err(why) => Validation::Invalid(wrapped(&why).into()),
                })
            });
        let text = if help.is_empty() { text } else { text.with_help_message(help) };
        reply(match proposed {
            Some(proposed) => text.with_default(proposed).prompt(),
            None => text.prompt(),
        })
    }

    fn note(&mut self, sentence: &str) {
        // If this cannot be written, the next question returns the error.
        let _ = writeln!(stderr(), "{}", wrapped(sentence));
    }
}

/// Breaks a sentence into lines of a terminal.
fn wrapped(sentence: &str) -> String {
    let mut lines = vec![String::new()];
    for word in sentence.split_whitespace() {
        let line = lines.last_mut().filter(|line| line.len() + 1 + word.len() <= WIDTH);
        match line {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) => {
                line.push(' ');
                line.push_str(word);
            }
            None => lines.push(word.into()),
        }
    }
    lines.join("\n")
}
