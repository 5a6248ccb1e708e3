//! The questions of `stiction new`, one after the other.
//!
//! ```text
//! typical joint -> question -> question -> ..  -> all answers
//!       ^---- Esc ----' ^---- Esc ---'
//! ```
//!
//! An answer is checked at once, together with those before it; the last answer is checked with the
//! whole file. A refused answer stays in its field, and an accepted one is proposed again after
//! Esc.
//! [`Prompt`] hides the terminal, so that tests can answer.

use std::rc::Rc;

use toml::Value;

use files::error::Error;
use simulator::draft::questions::{AnswerKind, typed};
use simulator::draft::{Answers, QUESTIONS, Question, TYPICAL, Typical, trial};

/// Check of a typed answer. The error is the reason of the refusal.
pub type AnswerCheck = Rc<dyn Fn(&str) -> Result<(), String>>;

/// Check of a whole file, once all questions are answered.
pub type FileCheck = Rc<dyn Fn(&Answers, Option<&Typical>) -> Result<(), String>>;

/// Reply of the user to a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PromptReply<T> {
    /// An answer.
    Given(T),
    /// A step back to the previous question.
    Back,
}

/// Interface that shows questions to the user and returns the answers.
pub trait Prompt {
    /// Shows choices, with the cursor on one of them, and returns the place of the chosen one.
    ///
    /// # Errors
    /// Returns [`Error::Interrupted`] after Ctrl-C.
    fn choose(
        &mut self,
        question: &str,
        help: &str,
        choices: &[String],
        start: usize,
    ) -> Result<PromptReply<usize>, Error>;

    /// Shows a question with the proposed answer, and returns an answer that passes the check.
    ///
    /// # Errors
    /// Returns [`Error::Interrupted`] after Ctrl-C.
    fn enter(
        &mut self,
        question: &str,
        help: &str,
        proposed: Option<&str>,
        check: &AnswerCheck,
    ) -> Result<PromptReply<String>, Error>;

    /// Shows a sentence between two questions.
    fn note(&mut self, sentence: &str);
}

/// Sentence above the first question.
const HOW: &str = "Enter takes the answer in parentheses. Esc goes back a question. Ctrl-C ends \
                   without a file.";

/// Sentence after Esc at the first question.
const IS_FIRST: &str = "This is the first question. Ctrl-C ends without a file.";

/// The dialogue.
pub struct Dialogue<'a> {
    /// Answers that options have set: their questions are left out.
    pub options: &'a Answers,
    /// Proposed title.
    pub title: &'a str,
    /// Check of the whole file.
    pub complete: FileCheck,
}

/// Answers given so far.
#[derive(Default)]
struct SoFar {
    own: Answers,
    like: Option<Typical>,
    /// Answers of the typical joint `like`.
    proposed: Answers,
}

impl Dialogue<'_> {
    /// Asks all questions, and returns the answers with the typical joint that they started from.
    ///
    /// # Errors
    /// Returns [`Error::Interrupted`] after Ctrl-C.
    pub fn run(&self, prompt: &mut impl Prompt) -> Result<(Answers, Option<Typical>), Error> {
        let mut so_far = SoFar::default();
        // The place of a question, plus one; zero is the typical joint.
        let mut at = 0;
        prompt.note(HOW);
        while at <= QUESTIONS.len() {
            let is_given = match at {
                0 => begin_with(prompt, &mut so_far)?,
                _ => self.put(prompt, &mut so_far, at - 1)?,
            };
            let all = self.all(&so_far);
            if is_given {
                at = self.next(&all, at).unwrap_or(QUESTIONS.len() + 1);
            } else if at == 0 {
                prompt.note(IS_FIRST);
            } else {
                let is_put = |place: &usize| *place == 0 || self.is_put(&all, *place - 1);
                at = (0..at).rev().find(is_put).unwrap_or(0);
            }
        }
        Ok((self.all(&so_far), so_far.like))
    }

    /// Returns whether a question must be asked: the joint has the quantity, and no option has set
    /// it.
    fn is_put(&self, all: &Answers, place: usize) -> bool {
        let is_open =
            |question: &Question| self.options.get(question.key).is_none() && all.asks(question);
        QUESTIONS.get(place).is_some_and(is_open)
    }

    fn next(&self, all: &Answers, at: usize) -> Option<usize> {
        (at + 1..=QUESTIONS.len()).find(|next| self.is_put(all, next - 1))
    }

    /// Returns all answers. The user's replace those of the options, which replace those of the
    /// typical joint.
    fn all(&self, so_far: &SoFar) -> Answers {
        so_far.own.or(self.options).or(&so_far.proposed)
    }

    /// Asks one question. Returns false for a step back.
    fn put(
        &self,
        prompt: &mut impl Prompt,
        so_far: &mut SoFar,
        place: usize,
    ) -> Result<bool, Error> {
        let question = QUESTIONS[place];
        let all = self.all(so_far);
        let proposed = self.proposed(so_far, &all, &question);
        let check = self.check(so_far, place);
        let text = sentence(question.what);
        let reply = loop {
            let AnswerKind::Words(words) = question.kind else {
                break prompt.enter(&text, question.help, proposed.as_deref(), &check)?;
            };
            let start = words.iter().position(|word| proposed.as_deref() == Some(word));
            let choices: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
            match prompt.choose(&text, question.help, &choices, start.unwrap_or(0))? {
                PromptReply::Back => break PromptReply::Back,
                PromptReply::Given(chosen) => {
                    let word = choices.get(chosen).cloned().unwrap_or_default();
                    match check(&word) {
                        Ok(()) => break PromptReply::Given(word),
                        Err(why) => prompt.note(&why),
                    }
                }
            }
        };
        let PromptReply::Given(answer) = reply else { return Ok(false) };
        let value = question.read(&answer).map_err(Error::Input)?;
        so_far.own.remove(question.key);
        let without = self.all(so_far).with_assumptions();
        // An accepted proposal keeps its source.
        if without.get(question.key).is_none_or(|other| other.value != value) {
            so_far.own.put(question.key, value, "");
        }
        Ok(true)
    }

    /// Returns the proposed answer: the user's previous answer, or else that of the typical joint
    /// or a default.
    fn proposed(&self, so_far: &SoFar, all: &Answers, question: &Question) -> Option<String> {
        let key = question.key;
        if let Some(own) = so_far.own.get(key) {
            return Some(typed(&own.value));
        }
        if key == "title" {
            return Some(self.title.into());
        }
        let scaled = (key == "friction.slip_nm").then(|| scaled_slip(so_far, all)).flatten();
        let found = all.with_assumptions().get(key).map(|answer| typed(&answer.value));
        scaled.or(found).or(question.otherwise.map(str::to_owned))
    }

    /// Returns the check of the answer to one question.
    fn check(&self, so_far: &SoFar, place: usize) -> AnswerCheck {
        let all = self.all(so_far).with_assumptions();
        let (like, complete) = (so_far.like, Rc::clone(&self.complete));
        let is_last = self.next(&all, place + 1).is_none();
        let question = QUESTIONS[place];
        Rc::new(move |typed| {
            let mut all = all.clone();
            all.put(question.key, question.read(typed)?, "");
            trial::check(&all, place)?;
            if is_last { complete(&all, like.as_ref()) } else { Ok(()) }
        })
    }
}

/// Asks for the typical joint to start with, if any. Returns false for a step back.
fn begin_with(prompt: &mut impl Prompt, so_far: &mut SoFar) -> Result<bool, Error> {
    let mut choices = TYPICAL.map(|typical| typical.title.to_owned()).to_vec();
    choices.push("None of them".into());
    let is_same = |typical: &Typical| so_far.like.is_some_and(|like| like.name == typical.name);
    let start = TYPICAL.iter().position(is_same).unwrap_or(0);
    let (text, help) = ("Which joint is most like yours?", "its numbers are proposed");
    let PromptReply::Given(chosen) = prompt.choose(text, help, &choices, start)? else {
        return Ok(false);
    };
    so_far.like = TYPICAL.get(chosen).copied();
    let answers = so_far.like.as_ref().map(Typical::answers).transpose()?;
    so_far.proposed = answers.unwrap_or_default();
    Ok(true)
}

/// Returns the dynamic friction of the typical joint, scaled with the answered static friction.
fn scaled_slip(so_far: &SoFar, all: &Answers) -> Option<String> {
    let [slip, stick] = ["friction.slip_nm", "friction.stick_nm"];
    let share = so_far.proposed.number(slip)? / so_far.proposed.number(stick)?;
    let own = all.get(stick).filter(|own| so_far.proposed.get(stick) != Some(own))?;
    let scaled = |number: f64| {
        let scaled = format!("{:.2e}", share * number).parse().unwrap_or(share * number);
        Value::Float(scaled)
    };
    let value = match &own.value {
        Value::Array(ends) => {
            Value::Array(ends.iter().filter_map(Value::as_float).map(scaled).collect())
        }
        value => scaled(value.as_float()?),
    };
    Some(typed(&value))
}

/// Capitalizes the first letter of a quantity.
fn sentence(what: &str) -> String {
    let mut letters = what.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
