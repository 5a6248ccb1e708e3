//! `stiction new`.

mod dialogue;
mod terminal;
#[cfg(test)]
mod tests;

use std::io::{IsTerminal, stderr, stdin};
use std::path::PathBuf;
use std::rc::Rc;

use toml::Value;

use self::dialogue::Dialogue;
use self::terminal::Terminal;
use super::outputs::print_beside;
use super::warn;
use files::data_sheet::tables::{DrivenBy, EncoderPlace};
use files::error::Error;
use files::setup::name_of;
use simulator::draft::{Answers, QUESTIONS, Question, Typical, Written, complete, written};
use simulator::experiment::parameters;
use simulator::output::{OutputFile, OverwriteGuard};

#[derive(Debug, clap::Args)]
pub struct NewArguments {
    /// The file to write; - for the standard output
    file: PathBuf,
    /// Start with a typical joint (harmonic, gimbal or thesis), without questions
    #[arg(long, value_name = "NAME")]
    typical: Option<String>,
    /// Write over a file that exists
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    answers: Flags,
}

/// The answers, as options. A range is LOW..HIGH.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Answers (a range is written LOW..HIGH)")]
struct Flags {
    /// Title of the joint [default: the file's name]
    #[arg(long)]
    title: Option<String>,
    /// Output of the drive: the motor's voltage or its current
    #[arg(long)]
    driven_by: Option<DrivenBy>,
    /// Voltage of the supply, V
    #[arg(long, value_name = "V")]
    voltage_v: Option<String>,
    /// Resistance of the winding, ohm
    #[arg(long, value_name = "OHM")]
    resistance_ohm: Option<String>,
    /// Current per volt of the amplifier's input, A/V
    #[arg(long, value_name = "A/V")]
    amplifier_a_per_v: Option<String>,
    /// Torque constant at the motor's shaft, N m/A
    #[arg(long, value_name = "NM/A")]
    kt_nm_per_a: Option<String>,
    /// Largest current, A
    #[arg(long, value_name = "A")]
    current_limit_a: Option<String>,
    /// Inertia of the rotor at its shaft, kg m^2
    #[arg(long, value_name = "KGM2")]
    rotor_inertia_kg_m2: Option<String>,
    /// Turns of the motor per turn of the joint
    #[arg(long, value_name = "N")]
    ratio: Option<String>,
    /// Efficiency of the gear
    #[arg(long, value_name = "SHARE")]
    efficiency: Option<String>,
    /// Inertia of the load at the joint, kg m^2, or a range
    #[arg(long, visible_alias = "inertia", value_name = "KGM2")]
    inertia_kg_m2: Option<String>,
    /// Backlash at the joint, deg, or a range
    #[arg(long, visible_alias = "backlash", value_name = "DEG")]
    backlash_deg: Option<String>,
    /// Torsional stiffness at the joint, N m/rad, or a range, or rigid
    #[arg(long, visible_alias = "stiffness", value_name = "NM/RAD")]
    stiffness_nm_per_rad: Option<String>,
    /// Largest torque of gravity on the load, N m, or a range
    #[arg(long, visible_alias = "unbalance", value_name = "NM")]
    unbalance_nm: Option<String>,
    /// Position at which an unbalanced load hangs down, deg
    #[arg(long, visible_alias = "hangs-at", value_name = "DEG", allow_hyphen_values = true)]
    hangs_at_deg: Option<String>,
    /// Static friction at the joint, N m, or a range
    #[arg(long, visible_alias = "stick", value_name = "NM")]
    stick_nm: Option<String>,
    /// Dynamic friction at the joint, N m, or a range
    #[arg(long, visible_alias = "slip", value_name = "NM")]
    slip_nm: Option<String>,
    /// Viscous friction at the joint, N m s/rad, or a range
    #[arg(long, visible_alias = "viscous", value_name = "NMS/RAD")]
    viscous_nm_s_per_rad: Option<String>,
    /// Lines of the encoder
    #[arg(long, value_name = "N")]
    lines: Option<String>,
    /// Position of the encoder
    #[arg(long)]
    at: Option<EncoderPlace>,
    /// Counts a turn of a second encoder, on the load, or none
    #[arg(long, value_name = "N")]
    counts_per_turn: Option<String>,
    /// Travel from the position at power-on, deg, such as -30..90
    #[arg(long, visible_alias = "travel", value_name = "LOW..HIGH", allow_hyphen_values = true)]
    travel_deg: Option<String>,
    /// Time between samples, s
    #[arg(long, value_name = "S")]
    sample_time_s: Option<String>,
}

impl Flags {
    /// Returns the answers of the options.
    ///
    /// # Errors
    /// Returns an error with the option, the typed text and what to type instead.
    fn answers(&self) -> Result<Answers, Error> {
        let words = [
            ("motor.driven_by", self.driven_by.map(|word| name_of(&word))),
            ("encoder.at", self.at.map(|word| name_of(&word))),
        ];
        let values = [
            ("title", &self.title),
            ("supply.voltage_v", &self.voltage_v),
            ("motor.resistance_ohm", &self.resistance_ohm),
            ("motor.amplifier_a_per_v", &self.amplifier_a_per_v),
            ("motor.kt_nm_per_a", &self.kt_nm_per_a),
            ("motor.current_limit_a", &self.current_limit_a),
            ("motor.rotor_inertia_kg_m2", &self.rotor_inertia_kg_m2),
            ("gear.ratio", &self.ratio),
            ("gear.efficiency", &self.efficiency),
            ("load.inertia_kg_m2", &self.inertia_kg_m2),
            ("gear.backlash_deg", &self.backlash_deg),
            ("gear.stiffness_nm_per_rad", &self.stiffness_nm_per_rad),
            ("load.unbalance_nm", &self.unbalance_nm),
            ("load.hangs_at_deg", &self.hangs_at_deg),
            ("friction.stick_nm", &self.stick_nm),
            ("friction.slip_nm", &self.slip_nm),
            ("friction.viscous_nm_s_per_rad", &self.viscous_nm_s_per_rad),
            ("encoder.lines", &self.lines),
            ("load_encoder.counts_per_turn", &self.counts_per_turn),
            ("limits.travel_deg", &self.travel_deg),
            ("loop.sample_time_s", &self.sample_time_s),
        ];
        let values = values.map(|(key, typed)| (key, typed.clone()));
        let mut answers = Answers::default();
        for (key, typed) in words.into_iter().chain(values) {
            let question = Question::place(key).and_then(|place| QUESTIONS.get(place));
            if let (Some(typed), Some(question)) = (typed, question) {
                let value = question.read(&typed);
                let refuse = |why| Error::Input(format!("{}: {why}", question.option()));
                answers.put(key, value.map_err(refuse)?, "");
            }
        }
        Ok(answers)
    }
}

pub fn new(arguments: &NewArguments) -> Result<(), Error> {
    // Checked before the questions.
    let output = OverwriteGuard::new(arguments.force).new_file("new", &arguments.file)?;
    let is_file = !output.is_standard_output();
    let name = if is_file { output.path().to_string_lossy() } else { "FILE.toml".into() };
    let stem = output.path().file_stem().unwrap_or_default().to_string_lossy();
    let title = if is_file { stem } else { "A joint of my own".into() };
    let like = arguments.typical.as_deref().map(Typical::find).transpose()?;
    let options = arguments.answers.answers()?;
    // The questions are shown on the standard error.
    let is_terminal = stdin().is_terminal() && stderr().is_terminal();
    let (mut answers, like) = if like.is_none() && is_terminal {
        let name = name.clone().into_owned();
        let complete = move |answers: &Answers, like: Option<&Typical>| {
            let why = written(&name, answers, like).map(|_| ()).map_err(|why| why.to_string());
            why.map_err(|why| why.strip_prefix(&format!("{name}: ")).unwrap_or(&why).to_owned())
        };
        Dialogue { options: &options, title: &title, complete: Rc::new(complete) }
            .run(&mut Terminal)?
    } else {
        let proposed = like.as_ref().map(Typical::answers).transpose()?.unwrap_or_default();
        (options.or(&proposed), like)
    };
    if answers.get("title").is_none() {
        answers.put("title", Value::String(title.into_owned()), "");
    }
    complete(&answers).map_err(|why| Error::Input(format!("new {name}: {why}")))?;
    write(&output, &name, &answers, like.as_ref())
}

fn write(
    output: &OutputFile,
    name: &str,
    answers: &Answers,
    like: Option<&Typical>,
) -> Result<(), Error> {
    let Written { text, document, experiment } = written(name, answers, like)?;
    warn(&document.doubts()?);
    // A loop that no board can run can still be simulated.
    if let Some(Err(why)) = experiment.runs.first().map(parameters) {
        warn(&[format!("no device can run it: {why}")]);
    }
    output.write(text.as_bytes())?;
    let text = format!(
        "{name}: {} runs; `stiction run {name}` makes them, `stiction show --units {name}` shows \
         its units\n",
        experiment.runs.len()
    );
    print_beside(Some(output), &text)
}
