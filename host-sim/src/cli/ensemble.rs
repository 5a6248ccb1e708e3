//! `stiction ensemble`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use clap::builder::TypedValueParser;
use stiction::identification::IdentificationRequest;

use super::bar::Bar;
use super::ensemble_follow::EnsembleFollowArguments;
use super::ensemble_options::cases;
use super::outputs::{check_standard_output, print_beside};
use super::own_laws::OwnLawArguments;
use super::{print, warn};
use figure::{figure_directory, write_charts, write_figures};
use files::document::Document;
use files::error::Error;
use files::typed_number;
use simulator::output::{OutputDirectory, OutputFile, OverwriteGuard, grid};
use simulator::rules::{TUNING_SEEDS, rules};
use studies::ensemble::{
    Approach, Bridge, Case, CaseResult, Condition, ConstantTrial, DrawOptions, Ensemble,
    EnsembleHeader, Family, MachineEnsemble, MachineOptions, RATE_HZ, Rates, ResumeFile, Shard,
    allowed_rate, charts, families, families_under, identified_names, markdown, merge, object,
    rates_markdown, rates_table, rates_within, read_rows, render, render_rows, run, sort_rows,
    summaries, traces, tune, written_spreads,
};

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct EnsembleArguments {
    #[command(subcommand)]
    action: Option<Action>,
    /// Families of joints: rigid, loaded, gravity, overhauling, lugre, flexible-motor,
    /// flexible-backlash, flexible-load, thesis-axis, arm (all: these ten); others, by their names
    /// only: gear-backlash, arm-uncoupled, overhauling-gravity, overhauling-lugre,
    /// overhauling-flexible, end-stop, end-stop-lugre, end-stop-flexible, end-stop-thesis, dwell,
    /// drifting, noisy, noisy-declared, and with an encoder on motor and load: two-encoders,
    /// two-encoders-backlash, two-encoders-gear-backlash, two-encoders-wide-backlash,
    /// two-encoders-soft, two-encoders-overhauling, two-encoders-noisy, two-encoders-end-stop; or a
    /// machine's own FILE.toml
    #[arg(long, value_name = "FAMILY|FILE", value_delimiter = ',', default_value = "all")]
    plant: Vec<String>,
    /// For a machine's own file, whose controllers are run: the range of a key of its joint, as in
    /// joint.friction.stick_v=0.3..0.6, instead of the file's [spread]
    #[arg(long, value_name = "KEY=LOW..HIGH")]
    spread: Vec<String>,
    /// Number of joints of each family
    #[arg(long, default_value_t = 100, value_parser = cases())]
    cases: u64,
    /// Seed of the joints; laws were tuned on the seeds from 1000000 to 1999999
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only these laws
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    controller: Vec<String>,
    #[command(flatten)]
    own: OwnLawArguments,
    /// Stick friction of 2 to 4 times the slip friction, instead of 1.05 to 2 times
    #[arg(long)]
    hard: bool,
    /// Samples per second, Hz; thesis-axis and a machine's own file have their own [default: 1000]
    #[arg(long, value_name = "HZ", value_parser = typed_number::parse)]
    rate: Option<f64>,
    /// Condition that no law knows: drifting, uneven or growing friction, a slow, hot or cold
    /// winding, a supply that is low, high or sags, ticks that jitter, an eccentric disc
    #[arg(long, value_name = "CONDITION", default_value = "nominal", hide_default_value = true)]
    condition: Condition,
    /// What the bridge makes of an effort: ideal, a torque at once; or of a motor with winding,
    /// back-EMF and supply, its voltage, or by sensor and current loop its current
    #[arg(long, value_name = "BRIDGE", default_value = "ideal", hide_default_value = true)]
    bridge: Bridge,
    /// How the set point goes to the target: profiled, as `device move` does it, within the limits
    /// that `new` writes; or in one step. Of a machine's own file it steps [default: profiled]
    #[arg(long, value_name = "MOTION")]
    motion: Option<Approach>,
    /// Number of random moves in a row after the first; their first tenth is compared with the last
    #[arg(long, value_name = "M", default_value_t = 0)]
    moves: u32,
    /// Only this joint of each family, by its number; with --plot, the traces of every law on it
    #[arg(long, value_name = "K", conflicts_with_all = ["shard", "resume"])]
    case: Option<u64>,
    /// One JSON object instead of tables
    #[arg(long)]
    json: bool,
    /// Tables in Markdown, a row for each family, as in docs/
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Write a line for each joint and law to this file; - for the standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw success, clouds of settling and rest, and the worst joint's traces into this directory,
    /// as SVG and PNG
    #[arg(long, value_name = "DIR")]
    plot: Option<PathBuf>,
    /// Append each line to this file as soon as it is computed; continue from it if it exists
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
    /// Only part K of N of the joints; `stiction ensemble merge` combines the parts
    #[arg(long, value_name = "K/N", requires = "resume")]
    shard: Option<String>,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Combine the files of shards, and report them as one run
    Merge(MergeArguments),
    /// Run the candidate constants of the laws' rules, on joints that do not score
    Tune(EnsembleTuneArguments),
    /// Run the identification of `device identify` on joints with known parameters, and report how
    /// often it finds them
    Identify(EnsembleIdentifyArguments),
    /// Follow ramps of 1 to 1000 counts a second, and report the slowest speed without steps; or
    /// sines
    Follow(EnsembleFollowArguments),
}

#[derive(Debug, clap::Args)]
pub struct EnsembleIdentifyArguments {
    /// Families of joints, or rigid-uneven, whose friction varies with the angle; all: the ten of
    /// `ensemble` except arm, and rigid-uneven. The special families are identified only by name;
    /// arms are not, since they have two joints
    #[arg(long, value_name = "FAMILY", value_delimiter = ',', default_value = "all")]
    plant: Vec<String>,
    /// Number of joints of each family
    #[arg(long, default_value_t = 40, value_parser = cases())]
    cases: u64,
    /// Seed of the joints
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Largest speed, deg/s, as in `device identify` [default: that of the profile, by the gains of
    /// PD]
    #[arg(long, value_name = "DEG/S", value_parser = typed_number::parse_single)]
    speed: Option<f32>,
    /// The table in Markdown, as in docs/
    #[arg(long)]
    markdown: bool,
}

#[derive(Debug, clap::Args)]
pub struct EnsembleTuneArguments {
    /// Families of joints, or all of them
    #[arg(long, value_name = "FAMILY", value_delimiter = ',', default_value = "all")]
    plant: Vec<String>,
    /// Number of joints of each family
    #[arg(long, default_value_t = 40, value_parser = cases())]
    cases: u64,
    /// Seed of the joints
    #[arg(long, default_value_t = *TUNING_SEEDS.start(), value_parser = tuning_seeds())]
    seed: u64,
    /// Only these laws
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    controller: Vec<String>,
    /// How the set point goes to the target: profiled or step [default: profiled]
    #[arg(long, value_name = "MOTION")]
    motion: Option<Approach>,
}

#[derive(Debug, clap::Args)]
pub struct MergeArguments {
    /// Files that --resume or --csv has written
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// One JSON object instead of tables
    #[arg(long)]
    json: bool,
    /// Write all lines to this file; - for the standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
}

/// Returns the parser of the tuning seeds, whose joints do not score.
fn tuning_seeds() -> impl TypedValueParser<Value = u64> {
    clap::value_parser!(u64).range(TUNING_SEEDS)
}

pub fn ensemble(arguments: &EnsembleArguments) -> Result<(), Error> {
    match &arguments.action {
        Some(Action::Merge(action)) => action.merge(),
        Some(Action::Tune(action)) => action.tune(),
        Some(Action::Identify(action)) => action.identify(),
        Some(Action::Follow(action)) => action.follow(),
        None => arguments.run(),
    }
}

impl EnsembleArguments {
    fn run(&self) -> Result<(), Error> {
        if let Some(file) = self.plant.iter().find(|name| name.ends_with(".toml")) {
            return self.run_machine(file);
        }
        if let Some(spread) = self.spread.first() {
            return Err(Error::Input(format!(
                "--spread {spread} needs a machine's own file: --plant FILE.toml"
            )));
        }
        let ensemble = self.ensemble()?;
        let outputs = self.outputs(OverwriteGuard::new(self.force))?;
        let header = EnsembleHeader::of(&ensemble);
        let rows = self.collect(&header, &outputs, |part| {
            let wanted =
                |family: Family, case: u64, law: &str| part.wants(family.name(), case, law);
            run(&ensemble, &Bar::new(), wanted, |row| part.take(row))
        })?;
        report(&header, &rows, self.form(), outputs.csv.as_ref())?;
        match &outputs.plot {
            Some(directory) => self.draw(directory, &ensemble, &rows),
            None => Ok(()),
        }
    }

    const fn form(&self) -> Form {
        match (self.json, self.markdown) {
            (true, _) => Form::Json,
            (_, true) => Form::Markdown,
            _ => Form::Table,
        }
    }

    /// Checks the output paths before anything is run.
    fn outputs(&self, guard: OverwriteGuard) -> Result<Outputs, Error> {
        let resume = match self.resume.as_deref().map(|path| guard.results("--resume", path)) {
            Some(Ok(file)) if file.is_standard_output() => {
                let why = "the command reads the lines back, so it must be a file";
                return Err(Error::Input(format!("--resume -: {why}")));
            }
            file => file.transpose()?,
        };
        // The command reads the lines of an earlier run.
        let guard = self.resume.iter().fold(guard, OverwriteGuard::reads);
        let csv = self.csv.as_ref().map(|path| guard.results("--csv", path)).transpose()?;
        check_standard_output(self.json, csv.as_ref())?;
        let plot = self.plot.as_ref().map(|path| figure_directory(&guard, "--plot", path));
        Ok(Outputs { csv, resume, plot: plot.transpose()? })
    }

    /// Runs the selected part of an ensemble, and returns its rows with those of an earlier run, in
    /// report order.
    fn collect(
        &self,
        header: &EnsembleHeader,
        outputs: &Outputs,
        run: impl FnOnce(&Part) -> Result<(), Error>,
    ) -> Result<Vec<CaseResult>, Error> {
        let shard = self.shard.as_deref().map(Shard::read).transpose()?;
        let (kept, rows) = match &outputs.resume {
            Some(file) => {
                let (kept, rows) = ResumeFile::open(file, header)?;
                (Some(Mutex::new(kept)), rows)
            }
            None => (None, Vec::new()),
        };
        let there =
            rows.iter().map(|row| (row.family.clone(), row.case, row.law.clone())).collect();
        let part = Part { shard, only: self.case, there, kept, rows: Mutex::new(rows) };
        run(&part)?;
        let mut rows = part.rows.into_inner().unwrap_or_else(PoisonError::into_inner);
        sort_rows(header, &mut rows);
        Ok(rows)
    }

    /// Runs the ensemble of joints around the joint of a machine's own file.
    fn run_machine(&self, file: &str) -> Result<(), Error> {
        let foreign = [
            ("--hard", self.hard),
            ("--moves", self.moves > 0),
            ("--motion profiled", self.motion == Some(Approach::Profiled)),
            ("--case", self.case.is_some()),
            ("--condition", self.condition != Condition::Nominal),
            ("--bridge", self.bridge != Bridge::Ideal),
            ("another family", self.plant.len() > 1),
        ];
        if let Some((option, _)) = foreign.iter().find(|(_, given)| *given) {
            return Err(Error::Input(format!("{option} does not go with --plant {file}")));
        }
        let outputs = self.outputs(OverwriteGuard::new(self.force).opens(file))?;
        let rate_hz = self.rate.map(allowed_rate).transpose()?;
        let document = Document::open(file)?;
        warn(&document.doubts()?);
        let slack = document.unseen_slack()?.map(|slack| format!("{file}: {slack}"));
        warn(slack.as_slice());
        let written = written_spreads(&document)?;
        let spreads = if self.spread.is_empty() { &*written } else { &*self.spread };
        if spreads.is_empty() && self.cases > 1 {
            warn(&[format!(
                "{file}: nothing varies, so all {} joints are the file's own; give it a \
                 [spread] (`stiction keys spread`), or --spread KEY=LOW..HIGH",
                self.cases
            )]);
        }
        let (controllers, guests) = (&*self.controller, &*self.own.names()?);
        let machine =
            MachineEnsemble::open(file, MachineOptions { controllers, guests, spreads, rate_hz })?;
        let header = EnsembleHeader::of_machine(&machine, self.seed, self.cases);
        let rows = self.collect(&header, &outputs, |part| {
            let wanted = |case: u64, law: &str| part.wants(&machine.group.name, case, law);
            machine.run_some([self.seed, self.cases], wanted, |row| part.take(row))
        })?;
        report(&header, &rows, self.form(), outputs.csv.as_ref())?;
        match &outputs.plot {
            Some(directory) => {
                write_charts(directory, &charts(&header, &summaries(&header, &rows), &rows))
            }
            None => Ok(()),
        }
    }

    /// Draws the traces of the joint that `--case` selects. Without `--case`, draws the charts, and
    /// the traces of each law's worst joint.
    fn draw(
        &self,
        directory: &OutputDirectory,
        ensemble: &Ensemble,
        rows: &[CaseResult],
    ) -> Result<(), Error> {
        let header = EnsembleHeader::of(ensemble);
        let families = summaries(&header, rows);
        if self.case.is_none() {
            write_charts(directory, &charts(&header, &families, rows))?;
        }
        let mut drawn = Vec::new();
        for (family, (_, laws)) in ensemble.families.iter().zip(&families) {
            for summary in laws {
                let Some(rule) = ensemble.rules.iter().find(|rule| rule.law == summary.law) else {
                    continue;
                };
                let Some(number) = self.case.or(summary.worst.first().copied()) else { continue };
                let joint = Case::draw(ensemble.seed, *family, number, ensemble.kind);
                drawn.extend(traces(&joint, rule, ensemble.approach)?);
            }
        }
        write_figures(directory, &drawn)
    }

    fn ensemble(&self) -> Result<Ensemble, Error> {
        let rate_hz = allowed_rate(self.rate.unwrap_or(RATE_HZ))?;
        if let Some(case) = self.case.filter(|case| *case >= self.cases) {
            let (cases, last) = (self.cases, self.cases - 1);
            return Err(Error::Input(format!(
                "--case {case}: with --cases {cases} it must be a number from 0 to {last}"
            )));
        }
        Ok(Ensemble {
            seed: self.seed,
            cases: self.cases,
            kind: DrawOptions {
                hard: self.hard,
                rate_hz,
                condition: self.condition,
                bridge: self.bridge,
            },
            approach: self.motion.unwrap_or_default(),
            moves: self.moves,
            families: families_under(&self.plant, self.condition, self.bridge)?,
            rules: self.own.after(&self.controller)?,
        })
    }
}

/// Output paths that have passed the guard.
struct Outputs {
    csv: Option<OutputFile>,
    resume: Option<OutputFile>,
    plot: Option<OutputDirectory>,
}

/// Part of an ensemble that this command runs, and its rows so far.
struct Part {
    shard: Option<Shard>,
    /// The only joint to run, if `--case` selects one.
    only: Option<u64>,
    /// Family, case and law of the rows that an earlier run has written to the file.
    there: BTreeSet<(String, u64, String)>,
    kept: Option<Mutex<ResumeFile>>,
    rows: Mutex<Vec<CaseResult>>,
}

impl Part {
    fn wants(&self, family: &str, case: u64, law: &str) -> bool {
        self.shard.is_none_or(|shard| shard.has(case))
            && self.only.is_none_or(|only| only == case)
            && !self.there.contains(&(family.to_owned(), case, law.to_owned()))
    }

    fn take(&self, row: CaseResult) -> Result<(), Error> {
        if let Some(kept) = &self.kept {
            kept.lock().unwrap_or_else(PoisonError::into_inner).add(&row)?;
        }
        self.rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
        Ok(())
    }
}

impl EnsembleTuneArguments {
    fn tune(&self) -> Result<(), Error> {
        let ensemble = Ensemble {
            seed: self.seed,
            cases: self.cases,
            kind: DrawOptions::ORDINARY,
            approach: self.motion.unwrap_or_default(),
            moves: 0,
            families: families(&self.plant)?,
            rules: rules(&self.controller)?,
        };
        let mut table =
            grid::new(&["law", "c", "family", "success\n%", "settled\np95, s", "rest p90\ncounts"]);
        for ConstantTrial { law, constant, families } in tune(&ensemble, &Bar::new())? {
            for (family, summary) in families {
                let share = 100.0 * summary.success as f64 / summary.cases as f64;
                let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
                table.add_row([
                    law.to_owned(),
                    constant.to_string(),
                    family,
                    grid::number(Some(share), 1),
                    grid::number(finite(summary.settling_s.quantile(0.95)), 2),
                    grid::number(finite(summary.rest_counts.quantile(0.9)), 1),
                ]);
            }
        }
        print(&format!("{}\n", table.trim_fmt()))
    }
}

impl EnsembleIdentifyArguments {
    fn identify(&self) -> Result<(), Error> {
        let is_all = self.plant.iter().any(|name| name == "all");
        let mut names: Vec<&str> = self.plant.iter().map(String::as_str).collect();
        if is_all {
            names = identified_names(Family::USUAL);
        }
        let asked = IdentificationRequest { speed: self.speed, ..Default::default() };
        let of = |name: &&str| rates_within(&asked, name, self.seed, self.cases);
        let all: Vec<Rates> = names.iter().map(of).collect::<Result<_, Error>>()?;
        print(&if self.markdown { rates_markdown(&all) } else { rates_table(&all) })
    }
}

impl MergeArguments {
    fn merge(&self) -> Result<(), Error> {
        let guard = OverwriteGuard::new(self.force);
        let guard = self.files.iter().fold(guard, OverwriteGuard::reads);
        let csv = self.csv.as_ref().map(|path| guard.results("--csv", path)).transpose()?;
        check_standard_output(self.json, csv.as_ref())?;
        let mut files = Vec::new();
        for path in &self.files {
            let (header, rows) = read_rows(path)?;
            files.push((path.display().to_string(), header, rows));
        }
        let (header, rows) = merge(&files)?;
        let form = if self.json { Form::Json } else { Form::Table };
        report(&header, &rows, form, csv.as_ref())
    }
}

/// Form of the printed summaries.
#[derive(Clone, Copy)]
enum Form {
    Table,
    Markdown,
    Json,
}

fn report(
    header: &EnsembleHeader,
    rows: &[CaseResult],
    form: Form,
    csv: Option<&OutputFile>,
) -> Result<(), Error> {
    if let Some(file) = csv {
        file.write(&render_rows(header, rows)?)?;
    }
    let families = summaries(header, rows);
    let text = match form {
        Form::Json => format!("{:#}\n", object(header, &families)),
        Form::Markdown => markdown(header, &families),
        Form::Table => render(header, &families),
    };
    print_beside(csv, &text)
}
