//! The dialogue with answers from a script.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::VecDeque;
use std::rc::Rc;

use super::dialogue::{AnswerCheck, Dialogue, Prompt, PromptReply};

use files::error::Error;
use simulator::draft::{Answers, QUESTIONS, Question, Typical, Written, written};
use simulator::experiment::Document;

/// Action of the user at a question.
#[derive(Clone, Copy, Debug)]
enum Key {
    Type(&'static str),
    Escape,
    CtrlC,
}
use Key::{CtrlC, Escape, Type};

/// Scripted user. It acts at the questions of the script, in their order, and accepts the proposal
/// at every other question.
struct Script {
    steps: VecDeque<(&'static str, Key)>,
    /// Questions in the order in which they were shown, with their proposals.
    shown: Vec<String>,
    refused: Vec<String>,
    notes: Vec<String>,
}

impl Script {
    fn new(steps: &[(&'static str, Key)]) -> Self {
        let steps = steps.iter().copied().collect();
        Self { steps, shown: vec![], refused: vec![], notes: vec![] }
    }

    fn act(&mut self, question: &str) -> Option<Key> {
        let is_next = self.steps.front().is_some_and(|(part, _)| question.contains(part));
        if is_next { self.steps.pop_front().map(|(_, key)| key) } else { None }
    }
}

impl Prompt for Script {
    fn choose(
        &mut self,
        question: &str,
        _help: &str,
        choices: &[String],
        start: usize,
    ) -> Result<PromptReply<usize>, Error> {
        self.shown.push(format!("{question} [{}]", choices[start]));
        match self.act(question) {
            None => Ok(PromptReply::Given(start)),
            Some(Escape) => Ok(PromptReply::Back),
            Some(CtrlC) => Err(Error::Interrupted),
            Some(Type(choice)) => {
                let is = |one: &String| one.contains(choice);
                Ok(PromptReply::Given(choices.iter().position(is).unwrap()))
            }
        }
    }

    fn enter(
        &mut self,
        question: &str,
        _help: &str,
        proposed: Option<&str>,
        check: &AnswerCheck,
    ) -> Result<PromptReply<String>, Error> {
        self.shown.push(format!("{question} ({})", proposed.unwrap_or_default()));
        loop {
            let typed = match self.act(question) {
                Some(Escape) => return Ok(PromptReply::Back),
                Some(CtrlC) => return Err(Error::Interrupted),
                Some(Type(typed)) => typed.to_owned(),
                None => proposed.unwrap_or_else(|| panic!("{question}: no proposal")).to_owned(),
            };
            match check(&typed) {
                Ok(()) => return Ok(PromptReply::Given(typed)),
                Err(why) => self.refused.push(format!("{typed}: {why}")),
            }
            assert!(self.refused.len() < 50, "{:?}", self.refused);
        }
    }

    fn note(&mut self, sentence: &str) {
        self.notes.push(sentence.into());
    }
}

type Found = Result<(Answers, Option<Typical>), Error>;

fn asked(script: &mut Script, options: &Answers) -> Found {
    let complete = |answers: &Answers, like: Option<&Typical>| {
        written("joint.toml", answers, like).map(|_| ()).map_err(|why| why.to_string())
    };
    Dialogue { options, title: "joint", complete: Rc::new(complete) }.run(script)
}

fn file(found: Found) -> (String, Document) {
    let (answers, like) = found.unwrap();
    let Written { text, document, .. } = written("joint.toml", &answers, like.as_ref()).unwrap();
    (text, document)
}

#[test]
fn the_answers_of_a_dialogue_are_the_file() {
    let mut script = Script::new(&[
        ("most like yours", Type("gimbal")),
        ("Title", Type("Pan axis")),
        ("Backlash", Type("0.2..0.6")),
        ("gravity", Type("0,05")),
        ("Static friction", Type("0.15..0.4")),
        ("Travel", Type("-30..12.5")),
    ]);
    let found = asked(&mut script, &Answers::default());
    assert!(script.steps.is_empty() && script.refused.is_empty(), "{:?}", script.refused);
    let (text, document) = file(found);
    let machine = document.machine().unwrap();
    assert_eq!(machine.title, "Pan axis");
    let number = |key: &str| document.get(key).and_then(toml::Value::as_float).unwrap();
    for (key, expected) in [
        ("load.unbalance_nm", 0.05),
        ("load.hangs_at_deg", -90.0),
        // sqrt(0.2 x 0.6) = 0.34641 and sqrt(0.15 x 0.4) = 0.244949.
        ("gear.backlash_deg", 0.3464),
        ("friction.stick_nm", 0.2449),
        // In proportion: 0.06 / 0.08 of 0.15 and of 0.4, sqrt(0.112 x 0.3) = 0.18330.
        ("friction.slip_nm", 0.1833),
        // 0.748 N m at stall over 0.6 deg.
        ("gear.stiffness_nm_per_rad", 71.0),
        ("limits.position_min_deg", -30.0),
        ("limits.position_max_deg", 12.5),
    ] {
        assert!((number(key) / expected - 1.0).abs() < 1e-9, "{key}: {}", number(key));
    }
    let spread = &machine.spread;
    let ends = |key: &str| spread.get(key).copied().unwrap();
    let is = |key: &str, expected: [f64; 2]| {
        let off = [0, 1].map(|end| (ends(key)[end] / expected[end] - 1.0).abs());
        assert!(off.iter().all(|off| *off < 1e-9), "{key}: {:?}", ends(key));
    };
    is("friction.stick_nm", [0.15, 0.4]);
    is("friction.slip_nm", [0.112, 0.3]);
    is("gear.backlash_deg", [0.2, 0.6]);
    is("load.inertia_kg_m2", [0.004, 0.006]);
    // All motions stay within 0.8 of the travel.
    let farthest = machine.reference.steps_deg.iter().copied().fold(0.0, f64::max);
    assert!(farthest <= 10.0 && text.contains("corner_positions_deg = [0.0, 10.0, 10.0, 0.0]"));
    // The dialogue mentions no option.
    let all = [&script.shown[..], &script.notes[..]].concat().join("\n");
    assert!(!all.contains("--"), "{all}");
    assert!(QUESTIONS.iter().all(|question| !question.help.contains("--")));
}

#[test]
fn a_wrong_answer_is_refused_at_its_question_and_the_question_stays() {
    let mut script = Script::new(&[
        ("most like yours", Type("gimbal")),
        ("Title", Type("  ")),
        ("Voltage of the supply", Type("twelve")),
        ("Voltage of the supply", Type("-12")),
        ("Voltage of the supply", Type("12,0")),
        ("Largest current", Type("0")),
        ("Efficiency", Type("68")),
        ("Inertia of the load", Type("0.02..0.01")),
        ("Backlash", Type("-0.1")),
        ("Backlash", Type("0.5")),
        ("stiffness", Type("rigid")),
        ("gravity", Type("0.8")),
        ("Static friction", Type("0.3..0.8")),
        ("Dynamic friction", Type("0.2")),
        ("Lines", Type("16.5")),
        ("Travel", Type("90")),
        ("Travel", Type("0..90")),
        ("Time between samples", Type("0")),
    ]);
    let found = asked(&mut script, &Answers::default());
    let expected = [
        "  : nothing was typed; type a title",
        "twelve: `twelve` is not a number",
        "-12: `supply.voltage_v`",
        "0: `motor.current_limit_a`",
        "68: `gear.efficiency`",
        "0.02..0.01: `0.02..0.01`: the lower end comes first",
        "-0.1: -0.1 is below zero",
        "rigid: `gear.stiffness_nm_per_rad` is missing",
        "0.8: gravity (0.8 N m) must be below",
        "0.3..0.8: `friction.stick_nm`",
        "0.2: the dynamic friction (0.2 N m) must not be above the static friction (0.08 N m)",
        "16.5: `16.5` is not a whole number",
        "90: `90` is not a range; type one such as -30..90, or none",
        "0..90: `0..90` must extend to both sides of 0",
        "0: ",
    ];
    assert_eq!(script.refused.len(), expected.len(), "{:#?}", script.refused);
    for (refused, expected) in script.refused.iter().zip(expected) {
        assert!(refused.starts_with(expected), "{refused}, {expected}");
    }
    // A refusal does not show the question again, and keeps all other answers.
    let shown = |part: &str| script.shown.iter().filter(|one| one.contains(part)).count();
    assert_eq!((shown("Voltage of the supply"), shown("Travel")), (1, 1));
    let (_, document) = file(found);
    assert_eq!(document.get("supply.voltage_v").and_then(toml::Value::as_float), Some(12.0));
}

#[test]
fn escape_goes_back_a_question_and_keeps_every_answer() {
    let mut script = Script::new(&[
        ("most like yours", Escape),
        ("most like yours", Type("gimbal")),
        ("Backlash", Type("0.5")),
        ("gravity", Type("0.03")),
        // Back over the place where the load hangs, and over the load, to the stiffness.
        ("Static friction", Escape),
        ("Position at which", Escape),
        ("gravity", Escape),
        ("stiffness", Type("100")),
        ("Static friction", Type("0.1")),
        // Back to a list.
        ("Where the encoder sits", Escape),
        ("Lines", Type("32")),
    ]);
    let (answers, _) = asked(&mut script, &Answers::default()).unwrap();
    assert!(script.steps.is_empty(), "{:?}", script.steps);
    assert!(script.notes.iter().any(|note| note.contains("first question")));
    for (key, expected) in [
        ("gear.backlash_deg", 0.5),
        ("gear.stiffness_nm_per_rad", 100.0),
        ("load.unbalance_nm", 0.03),
        ("friction.stick_nm", 0.1),
        ("motor.kt_nm_per_a", 0.011),
    ] {
        assert!((answers.number(key).unwrap() / expected - 1.0).abs() < 1e-9, "{key}");
    }
    assert_eq!(answers.get("encoder.lines").unwrap().value.as_integer(), Some(32));
    // The second time, the given answer is the proposal.
    let again: Vec<&String> = script.shown.iter().filter(|one| one.contains("gravity")).collect();
    assert!(again.len() == 3 && again[1].ends_with("(0.03)"), "{again:?}");
}

#[test]
fn answers_survive_another_typical_joint() {
    let mut script = Script::new(&[
        ("most like yours", Type("gimbal")),
        ("Title", Type("mine")),
        ("What the drive sets", Escape),
        ("Title", Escape),
        ("most like yours", Type("harmonic")),
    ]);
    let (answers, like) = asked(&mut script, &Answers::default()).unwrap();
    assert_eq!(like.map(|like| like.name), Some("harmonic"));
    assert_eq!(answers.get("title").unwrap().value.as_str(), Some("mine"));
    assert_eq!(answers.number("supply.voltage_v"), Some(48.0));
    // A proposal that was accepted keeps its source.
    assert_eq!(answers.get("gear.ratio").unwrap().source, "name plate");
}

#[test]
fn ctrl_c_ends_the_dialogue_at_any_question() {
    for question in ["most like yours", "What the drive sets", "Static friction"] {
        let mut script = Script::new(&[(question, CtrlC)]);
        let ended = asked(&mut script, &Answers::default());
        assert!(matches!(ended, Err(Error::Interrupted)), "{question}");
    }
}

#[test]
fn a_question_that_an_option_answers_is_not_asked() {
    let mut options = Answers::default();
    for (key, typed) in [("friction.stick_nm", "0.1..0.2"), ("loop.sample_time_s", "0.002")] {
        let question = QUESTIONS[Question::place(key).unwrap()];
        options.put(key, question.read(typed).unwrap(), "");
    }
    let mut script = Script::new(&[("most like yours", Type("gimbal"))]);
    let (answers, _) = asked(&mut script, &options).unwrap();
    let is_shown = |part: &str| script.shown.iter().any(|one| one.contains(part));
    assert!(!is_shown("Static friction") && !is_shown("Time between samples"));
    assert!(is_shown("Travel") && is_shown("Dynamic friction"));
    assert_eq!(answers.range("friction.stick_nm"), Some([0.1, 0.2]));
}

#[test]
fn a_joint_that_is_like_none_is_described_from_the_start() {
    let mut script = Script::new(&[
        ("most like yours", Type("None")),
        ("What the drive sets", Type("current")),
        ("Current for each volt", Type("3")),
        ("Torque constant", Type("0.1")),
        ("Inertia of the rotor", Type("1e-5")),
        ("Largest current", Type("15")),
        ("Turns of the motor", Type("100")),
        ("Efficiency", Type("0.8")),
        ("Inertia of the load", Type("0.5")),
        ("Static friction", Type("10")),
        ("Dynamic friction", Type("8")),
        ("Viscous friction", Type("5")),
        ("Lines", Type("1000")),
        ("Where the encoder sits", Type("load")),
        ("Time between samples", Type("0.001")),
    ]);
    let (text, document) = file(asked(&mut script, &Answers::default()));
    assert!(script.steps.is_empty() && !script.shown.iter().any(|one| one.contains("supply")));
    assert!(document.machine().unwrap().spread.is_empty() && !text.contains("source ="), "{text}");
    assert!(text.contains("title = \"joint\"") && text.contains("steps_deg = [1.0, 5.0]"));
}
