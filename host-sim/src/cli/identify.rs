//! `stiction identify`.

use std::path::{Path, PathBuf};

use super::outputs::{check_standard_output, drew, print_beside, wrote};
use super::{print, warn};
use figure::{figure_directory, write_figures};
use files::document::Document;
use files::error::Error;
use files::typed_number;
use simulator::experiment::Experiment;
use simulator::output::OverwriteGuard;
use studies::log_identification::into_machine::MachineOfLog;
use studies::log_identification::reading::{LogColumns, read};
use studies::log_identification::units::{LogUnits, PositionUnit, seconds, unit_of_name};
use studies::log_identification::{FitSettings, figures, identify, machine_file, output};

#[derive(Debug, clap::Args)]
pub struct IdentifyLogArguments {
    /// The log: a text of columns with a header, separated by commas, semicolons or tabs
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Column of the time. In a file without a header, here and below: its number from 1
    #[arg(long, value_name = "COLUMN")]
    time: String,
    /// Column of the position
    #[arg(long, value_name = "COLUMN")]
    position: String,
    /// Column of the effort: current, torque, force or voltage
    #[arg(long, value_name = "COLUMN")]
    effort: String,
    /// Column of the motor's position, if `--position` is that of the load behind a gear: finds
    /// ratio, slack and stiffness of the gear
    #[arg(long, value_name = "COLUMN")]
    motor_position: Option<String>,
    /// Column of the motor's current, A, if `--effort` is its voltage, V: finds resistance and
    /// back-EMF constant of the motor
    #[arg(long, value_name = "COLUMN", conflicts_with = "motor_position")]
    motor_current: Option<String>,
    /// Unit of the motor's position: rad, deg or count [default: the end of the column's name, as
    /// in `motor_counts`; else rad]
    #[arg(long, value_name = "UNIT", requires = "motor_position")]
    motor_position_unit: Option<PositionUnit>,
    /// Unit of the time: s, ms, us or ns, or the seconds of a tick [default: the end of the
    /// column's name, as in `t [ms]`; else s]
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<String>,
    /// Unit of the position [default: the end of the column's name, as in `q_deg` or `q [°]`; else
    /// rad]
    #[arg(long, value_name = "UNIT")]
    position_unit: Option<PositionUnit>,
    /// Counts in a turn of the joint, for a position in counts
    #[arg(long, value_name = "N", value_parser = typed_number::parse)]
    counts_per_turn: Option<f64>,
    /// N m at the joint (or N) per unit of effort; negative if it counts the other way [default
    /// with --machine: by that file, for the unit that the column's name ends with]
    #[arg(long, value_name = "G", allow_hyphen_values = true, value_parser = typed_number::parse)]
    effort_gain: Option<f64>,
    /// Time after which the logged effort acts, s [default: estimated]
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = typed_number::parse)]
    effort_delay: Option<f64>,
    /// Cut-off of the low-pass, Hz [default: from the noise of the position]
    #[arg(long, value_name = "HZ", value_parser = typed_number::parse)]
    cut_off: Option<f64>,
    /// Friction of the two directions [default: selected by the fit]
    #[arg(long)]
    model: Option<Friction>,
    /// Fit a friction that falls with the speed (Stribeck), too
    #[arg(long)]
    stribeck: bool,
    /// Fit gravity on a load that turns, too
    #[arg(long)]
    gravity: bool,
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
    /// A machine's file with a data sheet, with which the result is compared; --into then writes
    /// this file with the joint of the log
    #[arg(long, value_name = "FILE.toml")]
    machine: Option<String>,
    /// Write the joint as a machine's file (a machine that turns, with --effort-gain or --machine);
    /// - for the standard output
    #[arg(long, value_name = "FILE.toml")]
    into: Option<PathBuf>,
    /// Write over a file that exists
    #[arg(long)]
    force: bool,
    /// Draw fit, residual and friction into this directory, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// A title for the figures
    #[arg(long, value_name = "TEXT", requires = "plot")]
    title: Option<String>,
}

/// Dependence of the friction on the direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Friction {
    /// The same both ways, and a constant load: four parameters
    Symmetric,
    /// A different one each way: five parameters
    Asymmetric,
}

pub fn identify_log(arguments: &IdentifyLogArguments) -> Result<(), Error> {
    let name = arguments.log.display().to_string();
    let mut warnings = Vec::new();
    let machine = arguments.machine.as_ref();
    let machine = machine.map(|file| {
        MachineOfLog::open(
            file,
            &arguments.effort,
            arguments.effort_gain.filter(|gain| *gain != 0.0),
        )
    });
    let machine = machine.transpose()?;
    let gain = arguments.effort_gain.or(machine.as_ref().map(|machine| machine.effort_gain));
    let request = arguments.request(gain, &mut warnings)?;
    // Checked before a long log is read.
    let guard = OverwriteGuard::new(arguments.force).reads(&arguments.log);
    let guard = arguments.machine.iter().fold(guard, |guard, file| guard.reads(Path::new(file)));
    let into = arguments.into.as_ref().map(|path| guard.new_file("--into", path)).transpose()?;
    check_standard_output(arguments.json, into.as_ref())?;
    let plot = arguments.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
    let plot = plot.transpose()?;
    let columns = LogColumns {
        time: arguments.time.clone(),
        position: arguments.position.clone(),
        effort: arguments.effort.clone(),
        motor: arguments.motor_position.clone().or(arguments.motor_current.clone()),
        has_motor_current: arguments.motor_current.is_some(),
    };
    let log = read(&arguments.log, &columns)?;
    let mut found =
        identify(log, &request).map_err(|why| Error::Input(format!("{name}: {why}")))?;
    // In the result, so that --json reports these warnings as well.
    if let Some(machine) = &machine {
        warnings.extend(machine.against(&found, arguments.counts_per_turn));
    }
    found.warnings.splice(..0, warnings);
    let merged = machine.map(|machine| machine.merge(&name, &found)).transpose();
    // If the log cannot be merged with the file, the result is still printed.
    let (merged, unmerged) = match merged {
        Ok(merged) => (merged, None),
        Err(why) if into.is_some() => (None, Some(why)),
        Err(why) => {
            found.warnings.push(why.to_string());
            (None, None)
        }
    };
    warn(&found.warnings);
    if let (Some(file), None) = (&into, &unmerged) {
        let file_name = file.path().to_string_lossy();
        let text = match &merged {
            Some(merged) => merged.text.clone(),
            None => machine_file::machine_file(&file_name, &name, &found)?,
        };
        let document = Document::parse(&file_name, &text)?;
        Experiment::plan(&document, &[], &[])?;
        file.write(text.as_bytes())?;
        wrote(file)?;
    }
    if let Some(directory) = &plot {
        let stem = arguments.log.file_stem().unwrap_or_default().to_string_lossy();
        let mut figures = figures::figures(&stem, &found);
        if let Some(title) = &arguments.title {
            figures.iter_mut().for_each(|one| one.figure.title.clone_from(title));
        }
        write_figures(directory, &figures)?;
        drew(figures.len(), directory)?;
    }
    if arguments.json {
        let mut object = output::object(&name, &found);
        if let Some(merged) = merged {
            object["kept"] = merged.kept.into();
            object["contradicted"] = serde_json::json!(merged.contradicted);
        }
        print(&format!("{object:#}\n"))?;
    } else {
        let words = merged.into_iter().flat_map(|merged| merged.words);
        let words: String = words.map(|words| words + "\n").collect();
        print_beside(into.as_ref(), &(output::text(&found) + &words))?;
    }
    unmerged.map_or(Ok(()), Err)
}

impl IdentifyLogArguments {
    fn request(&self, gain: Option<f64>, warnings: &mut Vec<String>) -> Result<FitSettings, Error> {
        let time_s = self.seconds(warnings)?;
        let named = PositionUnit::of_name(&self.position);
        let unit = self.position_unit.or(named);
        // The name `q_m` is also used for a measured angle or a motor's angle, not only for metres.
        if let (Some(given), Some(named)) = (self.position_unit, named)
            && given != named
            && named != PositionUnit::M
        {
            let [given, named] = [given, named].map(PositionUnit::word);
            warnings.push(format!(
                "`{}` is in {named} by its name, but --position-unit is {given}; read as {given}",
                self.position
            ));
        }
        if unit.is_none() {
            warnings.push(format!(
                "`{}` names no unit: read as rad; if that is wrong, set --position-unit",
                self.position
            ));
        }
        let unit = unit.unwrap_or(PositionUnit::Rad);
        let scale = LogUnits::checked(time_s, unit, self.counts_per_turn, gain);
        let scale = scale.map_err(Error::Input)?;
        let scale = match &self.motor_position {
            Some(column) => scale.with_motor(self.motor_unit(column, warnings)),
            None => Ok(scale),
        };
        let scale = scale.map_err(Error::Input)?;
        if scale.is_linear && self.machine.is_some() {
            return Err(Error::Input(
                "--machine needs a joint that turns, but the position of the log is along a line; \
                 leave --machine out, or set --position-unit to a unit of an angle"
                    .into(),
            ));
        }
        let settings = FitSettings {
            scale,
            is_asymmetric: self.model.map(|model| model == Friction::Asymmetric),
            has_stribeck: self.stribeck,
            has_gravity: self.gravity,
            cut_off_hz: self.cut_off,
            effort_delay_s: self.effort_delay,
            has_motor_current: self.motor_current.is_some(),
        };
        settings.checked().map_err(Error::Input)
    }

    /// Returns the unit of the motor's position: that of the option, that of the column's name, or
    /// rad.
    fn motor_unit(&self, column: &str, warnings: &mut Vec<String>) -> PositionUnit {
        let named = PositionUnit::of_motor(column);
        match (self.motor_position_unit, named) {
            (Some(given), Some(named)) if given != named => {
                let [given, named] = [given, named].map(PositionUnit::word);
                warnings.push(format!(
                    "`{column}` is in {named} by its name, but --motor-position-unit is {given}; \
                     read as {given}"
                ));
            }
            (None, None) => warnings.push(format!(
                "`{column}` names no unit: read as rad; if that is wrong, set --motor-position-unit"
            )),
            _ => {}
        }
        self.motor_position_unit.or(named).unwrap_or(PositionUnit::Rad)
    }

    /// Returns the unit of the time column, s.
    fn seconds(&self, warnings: &mut Vec<String>) -> Result<f64, Error> {
        let named = unit_of_name(&self.time).and_then(|unit| Some((seconds(&unit)?, unit)));
        let Some(given) = &self.time_unit else {
            return Ok(named.map_or(1.0, |(seconds, _)| seconds));
        };
        let time_s = match (seconds(given), typed_number::parse(given)) {
            (Some(seconds), _) => seconds,
            (None, Ok(tick)) if tick > 0.0 => tick,
            _ => {
                return Err(Error::Input(format!(
                    "--time-unit {given}: must be s, ms, us, ns, or the seconds of a tick \
                     as a number above 0"
                )));
            }
        };
        if let Some((_, unit)) = named.filter(|(named, _)| *named != time_s) {
            warnings.push(format!(
                "`{}` is in {unit} by its name, but --time-unit is {given}; read as {given}",
                self.time
            ));
        }
        Ok(time_s)
    }
}
