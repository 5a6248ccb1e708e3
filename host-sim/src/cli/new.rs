//! `stiction new`.

use std::io::{IsTerminal, stdin};
use std::path::PathBuf;

use dialoguer::{Input, Select};
use toml::Value;

use super::outputs::print_beside;
use super::warn;
use crate::data_sheet::tables::{DrivenBy, Side};
use crate::draft::questions::{Kind, typed};
use crate::draft::{Answers, QUESTIONS, Question, TYPICAL, Typical, text};
use crate::error::Error;
use crate::experiment::{Document, Experiment, parameters};
use crate::output::{OutputFile, OverwriteGuard};
use crate::setup::name_of;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The file to write; - for the standard output
    file: PathBuf,
    /// Begin with a typical joint (harmonic, gimbal or thesis) and ask nothing
    #[arg(long, value_name = "NAME")]
    typical: Option<String>,
    /// Write over a file that exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    answers: Flags,
}

/// The answers, as options.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Answers")]
struct Flags {
    /// What the drive sets: the motor's voltage or its current
    #[arg(long)]
    driven_by: Option<DrivenBy>,
    /// Voltage of the supply, V
    #[arg(long, value_name = "V")]
    voltage_v: Option<f64>,
    /// Resistance of the winding, ohm
    #[arg(long, value_name = "OHM")]
    resistance_ohm: Option<f64>,
    /// Current for each volt of the amplifier's input, A/V
    #[arg(long, value_name = "A/V")]
    amplifier_a_per_v: Option<f64>,
    /// Torque constant at the motor's shaft, N m/A
    #[arg(long, value_name = "NM/A")]
    kt_nm_per_a: Option<f64>,
    /// Largest current, A
    #[arg(long, value_name = "A")]
    current_limit_a: Option<f64>,
    /// Inertia of the rotor at its shaft, kg m^2
    #[arg(long, value_name = "KGM2")]
    rotor_inertia_kg_m2: Option<f64>,
    /// Turns of the motor for a turn of the joint
    #[arg(long, value_name = "N")]
    ratio: Option<f64>,
    /// Efficiency of the gear
    #[arg(long, value_name = "PART")]
    efficiency: Option<f64>,
    /// Inertia of the load at the joint, kg m^2
    #[arg(long, value_name = "KGM2")]
    inertia_kg_m2: Option<f64>,
    /// Static friction at the joint, N m
    #[arg(long, value_name = "NM")]
    stick_nm: Option<f64>,
    /// Dynamic friction at the joint, N m
    #[arg(long, value_name = "NM")]
    slip_nm: Option<f64>,
    /// Viscous friction at the joint, N m s/rad
    #[arg(long, value_name = "NMS/RAD")]
    viscous_nm_s_per_rad: Option<f64>,
    /// Lines of the encoder
    #[arg(long, value_name = "N")]
    lines: Option<u32>,
    /// Where the encoder sits
    #[arg(long)]
    at: Option<Side>,
    /// Time between samples, s
    #[arg(long, value_name = "S")]
    sample_time_s: Option<f64>,
}

impl Flags {
    /// Answers what was given.
    fn answer(&self, answers: &mut Answers) {
        let numbers = [
            ("supply.voltage_v", self.voltage_v),
            ("motor.resistance_ohm", self.resistance_ohm),
            ("motor.amplifier_a_per_v", self.amplifier_a_per_v),
            ("motor.kt_nm_per_a", self.kt_nm_per_a),
            ("motor.current_limit_a", self.current_limit_a),
            ("motor.rotor_inertia_kg_m2", self.rotor_inertia_kg_m2),
            ("gear.ratio", self.ratio),
            ("gear.efficiency", self.efficiency),
            ("load.inertia_kg_m2", self.inertia_kg_m2),
            ("friction.stick_nm", self.stick_nm),
            ("friction.slip_nm", self.slip_nm),
            ("friction.viscous_nm_s_per_rad", self.viscous_nm_s_per_rad),
            ("loop.sample_time_s", self.sample_time_s),
        ];
        for (key, number) in numbers {
            if let Some(number) = number {
                answers.put(key, Value::Float(number), "");
            }
        }
        if let Some(lines) = self.lines {
            answers.put("encoder.lines", Value::Integer(lines.into()), "");
        }
        let words = [
            ("motor.driven_by", self.driven_by.map(|word| name_of(&word))),
            ("encoder.at", self.at.map(|word| name_of(&word))),
        ];
        for (key, word) in words {
            if let Some(word) = word {
                answers.put(key, Value::String(word), "");
            }
        }
    }
}

pub fn new(arguments: &Arguments) -> Result<(), Error> {
    // Before the questions.
    let output = OverwriteGuard::new(arguments.force).new_file("new", &arguments.file)?;
    let file = output.path();
    let mut like = arguments.typical.as_deref().map(Typical::find).transpose()?;
    let is_asked = like.is_none() && stdin().is_terminal();
    if is_asked {
        like = begin_with()?;
    }
    let mut answers = like.map_or_else(|| Ok(Answers::default()), |typical| typical.answers())?;
    arguments.answers.answer(&mut answers);
    if is_asked {
        ask_all(&mut answers, &arguments.answers)?;
    }
    let open: Vec<String> = answers.open().iter().map(Question::option).collect();
    if !open.is_empty() {
        let name = file.display();
        let names = TYPICAL.map(|typical| typical.name).join(", ");
        return Err(Error::Input(format!(
            "new {name}: not answered are {}; allowed is also --typical NAME ({names}), whose \
             answers stand in for them",
            open.join(", ")
        )));
    }
    write(&output, &answers, like.as_ref())
}

/// Writes the file, once it is known that it runs.
fn write(output: &OutputFile, answers: &Answers, like: Option<&Typical>) -> Result<(), Error> {
    let is_file = !output.is_standard_output();
    let name = if is_file { output.path().to_string_lossy() } else { "FILE.toml".into() };
    let text = text(&name, answers, like)?;
    let document = Document::parse(&name, &text)?;
    let experiment = Experiment::plan(&document, &[], &[])?;
    warn(&document.doubts()?);
    // A loop that no board has may be simulated all the same.
    if let Some(Err(why)) = experiment.runs.first().map(parameters) {
        warn(&[format!("no device can run it: {why}")]);
    }
    output.write(text.as_bytes())?;
    let text = format!(
        "{name}: {} runs; `stiction run {name}` makes them, `stiction show --units {name}` tells \
         its units\n",
        experiment.runs.len()
    );
    print_beside(Some(output), &text)
}

fn asked<T>(answer: dialoguer::Result<T>) -> Result<T, Error> {
    answer.map_err(|dialoguer::Error::IO(error)| match error.kind() {
        std::io::ErrorKind::Interrupted => Error::Interrupted,
        _ => Error::Output(error),
    })
}

/// The typical joint to begin with, if any.
fn begin_with() -> Result<Option<Typical>, Error> {
    let mut choices =
        TYPICAL.map(|typical| format!("{}: {}", typical.name, typical.title)).to_vec();
    choices.push("none of them".into());
    let choice = Select::new()
        .with_prompt("Which joint is most like yours? Its numbers are proposed")
        .items(&choices)
        .default(0)
        .interact();
    Ok(TYPICAL.get(asked(choice)?).copied())
}

/// Asks every question that is asked of this drive and was not answered by an option.
fn ask_all(answers: &mut Answers, flags: &Flags) -> Result<(), Error> {
    let mut by_option = Answers::default();
    flags.answer(&mut by_option);
    for question in &QUESTIONS {
        if by_option.get(question.key).is_some() || !answers.asks(question) {
            continue;
        }
        let proposed = answers.get(question.key).cloned();
        let value = ask(question, proposed.as_ref().map(|answer| typed(&answer.value)))?;
        // What was taken as proposed keeps its source.
        if proposed.is_none_or(|proposed| proposed.value != value) {
            answers.put(question.key, value, "");
        }
    }
    Ok(())
}

fn ask(question: &Question, proposed: Option<String>) -> Result<Value, Error> {
    let prompt = format!("{} ({})", question.what, question.key);
    if let Kind::Words(words) = question.kind {
        let at = proposed.and_then(|word| words.iter().position(|one| *one == word)).unwrap_or(0);
        let choice = Select::new().with_prompt(prompt).items(words).default(at).interact();
        let word = words.get(asked(choice)?).copied().unwrap_or_default();
        return question.read(word);
    }
    let mut input = Input::<String>::new().with_prompt(prompt);
    if let Some(proposed) = proposed {
        input = input.default(proposed);
    }
    let read = |typed: &String| question.read(typed).map(|_| ()).map_err(|why| why.to_string());
    question.read(&asked(input.validate_with(read).interact_text())?)
}
