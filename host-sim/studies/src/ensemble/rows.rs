//! Files of an ensemble's rows: `--csv` writes them, `--resume` continues them, and `stiction
//! ensemble merge` joins them.
//!
//! The file is CSV, after one line that identifies the ensemble:
//!
//! ```text
//! #{"schema":4,"seed":1,"cases":200,"hard":false,"rate_hz":1000.0,...}
//! family,law,case,...
//! rigid,pd,0,...
//! ```
//!
//! Numbers are written so that they are read back bit for bit. A file that lacks a column is
//! refused: a missing value would be read as an event that never happened, such as settling.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::bridge::Bridge;
use super::case_result::CaseResult;
use super::condition::Condition;
use super::group::Group;
use super::machine_file::MachineEnsemble;
use super::motions::Approach;
use super::run::Ensemble;
use files::error::Error;
use simulator::guest;
use simulator::output::OutputFile;
use simulator::rules::GainRule;

/// Version of the form. 2: every column is required, and a group states whether it is a family and
/// what its joints must reach. 3: with `law_signals`. 4: with both sides of the gear, the goal, and
/// the move that a fault ended.
const SCHEMA: u32 = 4;

/// Column that older files of the same form lack: there, all set points jumped to their targets.
const ADDED: &str = "set_point_rests_s";

/// Identity of the ensemble that rows belong to. Only files with equal headers can be merged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnsembleHeader {
    /// Version of this form.
    pub schema: u32,
    /// Version of the program: another one may have other laws.
    pub version: String,
    /// Commit of a released program; a program that was built from sources has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// The seed of every draw.
    pub seed: u64,
    /// Joints of each family, of all shards together.
    pub cases: u64,
    /// Whether the stick friction is 2 to 4 times the slip friction.
    pub hard: bool,
    /// Samples per second of the SI families.
    pub rate_hz: f64,
    /// Moves in a row.
    pub moves: u32,
    /// The families, in the order of reports.
    pub families: Vec<Group>,
    /// Names of the laws, in the order of reports.
    pub laws: Vec<String>,
    /// Text of a machine's own file, then the keys that were set or vary; empty for families.
    #[serde(default)]
    pub machine: Vec<String>,
    /// How the set point goes to the target; in older files, which lack the key, by a step.
    #[serde(default = "step")]
    pub motion: Approach,
    /// Condition of the joints; older files, which lack the key, have none.
    #[serde(default)]
    pub condition: Condition,
    /// What the bridge of the joints makes of an effort; left out with an ideal one.
    #[serde(default, skip_serializing_if = "is_ideal")]
    pub bridge: Bridge,
    /// Versions of the laws of other programs, by their names; left out without such laws.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub guests: BTreeMap<String, String>,
}

/// Returns the commit that a release sets.
fn commit() -> Option<String> {
    option_env!("STICTION_COMMIT").map(str::to_owned)
}

/// Returns the versions of the rules that are laws of other programs.
fn guests(rules: impl Iterator<Item = &'static GainRule>) -> BTreeMap<String, String> {
    rules.filter_map(|rule| Some((rule.law.to_owned(), guest::version(rule)?))).collect()
}

fn is_ideal(bridge: &Bridge) -> bool {
    *bridge == Bridge::Ideal
}

const fn step() -> Approach {
    Approach::Step
}

/// The place of a row: family, law and case.
type Place = (String, String, u64);

impl EnsembleHeader {
    /// Returns the header of an ensemble.
    pub fn of(ensemble: &Ensemble) -> Self {
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            commit: commit(),
            seed: ensemble.seed,
            cases: ensemble.cases,
            hard: ensemble.kind.hard,
            rate_hz: ensemble.kind.rate_hz,
            moves: ensemble.moves,
            families: ensemble.families.iter().copied().map(Group::from).collect(),
            laws: ensemble.rules.iter().map(|rule| rule.law.into()).collect(),
            machine: Vec::new(),
            motion: ensemble.approach,
            condition: ensemble.kind.condition,
            bridge: ensemble.kind.bridge,
            guests: guests(ensemble.rules.iter().copied()),
        }
    }

    /// Returns the header of an ensemble around a machine's own file.
    pub fn of_machine(machine: &MachineEnsemble, seed: u64, cases: u64) -> Self {
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            commit: commit(),
            seed,
            cases,
            hard: false,
            rate_hz: machine.rate_hz(),
            moves: 0,
            families: vec![machine.group.clone()],
            laws: machine.laws.clone(),
            machine: machine.written(),
            motion: Approach::Step,
            condition: Condition::Nominal,
            bridge: Bridge::Ideal,
            guests: guests(machine.laws.iter().filter_map(|law| guest::find(law))),
        }
    }

    /// Returns the number of rows of the whole ensemble.
    pub fn rows(&self) -> u64 {
        self.cases * (self.families.len() * self.laws.len()) as u64
    }

    /// Returns a description of the first key in which two headers differ; `None` if they are
    /// equal.
    fn difference(&self, other: &Self) -> Option<String> {
        let values = |header: &Self| {
            serde_json::to_value(header).ok().and_then(|value| value.as_object().cloned())
        };
        let (ours, theirs) = (values(self)?, values(other)?);
        // A key can be left out: that is another value as well.
        let keys: BTreeSet<&String> = ours.keys().chain(theirs.keys()).collect();
        keys.into_iter().find_map(|key| {
            let [value, found] = [&ours, &theirs]
                .map(|one| one.get(key).map_or_else(|| "none".into(), ToString::to_string));
            (found != value).then(|| match &**key {
                // A whole file is too long for a message.
                "machine" => "its machine's file, rate or spread is another one".into(),
                _ => format!("its `{key}` is {found}, not {value}"),
            })
        })
    }
}

/// Sorts rows as reports have them: by family, law and case.
pub fn sort(header: &EnsembleHeader, rows: &mut [CaseResult]) {
    rows.sort_by_key(|row| {
        let family = header.families.iter().position(|group| group.name == row.family);
        (family, header.laws.iter().position(|law| *law == row.law), row.case)
    });
}

/// Renders a whole file: the header, the titles and the rows.
///
/// # Errors
/// If the rows cannot be written as CSV.
pub fn render(header: &EnsembleHeader, rows: &[CaseResult]) -> Result<Vec<u8>, Error> {
    let first = serde_json::to_string(header).map_err(|error| Error::Input(error.to_string()))?;
    // The titles are there before there is a row.
    let titles = lines(&[CaseResult::default()], true)?;
    let end = titles.iter().position(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let parts = [format!("#{first}\n").into_bytes(), titles[..end].to_vec(), lines(rows, false)?];
    Ok(parts.concat())
}

fn lines(rows: &[CaseResult], with_titles: bool) -> Result<Vec<u8>, Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_titles).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|error| Error::Input(error.to_string()))?;
    }
    writer.into_inner().map_err(|error| Error::Input(error.to_string()))
}

/// Reads a file. A last line that is cut off, where a run was interrupted, is left out.
///
/// # Errors
/// Returns an error that names the file and the invalid line.
pub fn read(path: &Path) -> Result<(EnsembleHeader, Vec<CaseResult>), Error> {
    let text = fs::read_to_string(path).map_err(|source| Error::File {
        action: "read",
        path: path.to_owned(),
        source,
    })?;
    parse(&text).map_err(|why| Error::Input(format!("{}: {why}", path.display())))
}

fn parse(text: &str) -> Result<(EnsembleHeader, Vec<CaseResult>), String> {
    const NONE: &str =
        "these are no rows of an ensemble; it must be a file that --csv or --resume wrote";
    let (first, body) = text.split_once('\n').unwrap_or((text, ""));
    let json = first.strip_prefix('#').ok_or(NONE)?;
    let header: serde_json::Value =
        serde_json::from_str(json).map_err(|error| format!("{NONE} ({error})"))?;
    if let Some(schema) = header.get("schema").filter(|schema| **schema != SCHEMA) {
        return Err(format!(
            "its rows have the form {schema}, and this program reads the form {SCHEMA}, in which \
             each joint is judged at the encoder and at the load; run the ensemble anew"
        ));
    }
    let header = serde_json::from_value(header).map_err(|error| format!("{NONE} ({error})"))?;
    let whole = body.rfind('\n').map_or("", |end| &body[..=end]);
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let found = reader.headers().map_err(|error| format!("line 2: {error}"))?;
    // A value that is not there is read as none, also where its whole column is missing.
    let is_gone = |title: &String| title != ADDED && !found.iter().any(|one| one == title);
    if let Some(title) = titles()?.into_iter().find(is_gone) {
        return Err(format!("line 2: the column `{title}` is missing"));
    }
    // The line before the table is the first one.
    let rows = reader
        .deserialize()
        .enumerate()
        .map(|(i, row)| row.map_err(|error: csv::Error| format!("line {}: {error}", i + 3)));
    Ok((header, rows.collect::<Result<_, _>>()?))
}

/// Returns the titles of the columns.
fn titles() -> Result<Vec<String>, String> {
    let text = lines(&[CaseResult::default()], true).map_err(|error| error.to_string())?;
    let mut reader = csv::Reader::from_reader(text.as_slice());
    let titles = reader.headers().map_err(|error| error.to_string())?;
    Ok(titles.iter().map(str::to_owned).collect())
}

/// Merges the rows of several files into those of one run.
///
/// # Errors
/// Returns an error that names a file of another ensemble, a row with other values in another file,
/// or the first missing row.
pub fn merge(
    files: &[(String, EnsembleHeader, Vec<CaseResult>)],
) -> Result<(EnsembleHeader, Vec<CaseResult>), Error> {
    let Some((_, header, _)) = files.first() else {
        return Err(Error::Input("merge: no file is given".into()));
    };
    let mut rows: BTreeMap<Place, &CaseResult> = BTreeMap::new();
    for (name, found, of_file) in files {
        if let Some(difference) = header.difference(found) {
            return Err(Error::Input(format!(
                "{name}: these rows are of another ensemble: {difference}"
            )));
        }
        for row in of_file {
            if let Some(other) = rows.insert(place(row), row)
                && *other != *row
            {
                let CaseResult { family, law, case, .. } = row;
                return Err(Error::Input(format!(
                    "{name}: case {case} of {family} under {law} is in another file with other \
                     values"
                )));
            }
        }
    }
    let mut rows: Vec<CaseResult> = rows.into_values().cloned().collect();
    complete(header, &rows)?;
    sort(header, &mut rows);
    Ok((header.clone(), rows))
}

/// Rejects an incomplete set of rows.
///
/// # Errors
/// Returns an error that names the first missing row.
pub fn complete(header: &EnsembleHeader, rows: &[CaseResult]) -> Result<(), Error> {
    if rows.len() as u64 == header.rows() {
        return Ok(());
    }
    let there: BTreeSet<Place> = rows.iter().map(place).collect();
    for Group { name: family, .. } in &header.families {
        for law in &header.laws {
            for case in 0..header.cases {
                if !there.contains(&(family.clone(), law.clone(), case)) {
                    let (found, all) = (rows.len(), header.rows());
                    return Err(Error::Input(format!(
                        "merge: {found} of {all} rows are there; the first that is missing is case \
                         {case} of {family} under {law}"
                    )));
                }
            }
        }
    }
    Err(Error::Input("merge: there are more rows than the ensemble has".into()))
}

fn place(row: &CaseResult) -> Place {
    (row.family.clone(), row.law.clone(), row.case)
}

/// A file to which rows are added as they come.
#[derive(Debug)]
pub struct ResumeFile {
    file: File,
    path: PathBuf,
}

impl ResumeFile {
    /// Opens a file to append rows, and returns its rows. Creates the file if it does not exist.
    ///
    /// # Errors
    /// Returns an error that names the file if it cannot be read or written, or is of another
    /// ensemble.
    pub fn open(
        output: &OutputFile,
        header: &EnsembleHeader,
    ) -> Result<(Self, Vec<CaseResult>), Error> {
        let path = output.path();
        let fails = |source: io::Error| Error::File { action: "write", path: path.into(), source };
        let there = fs::metadata(path).is_ok_and(|found| found.len() > 0);
        let rows = if there {
            let (found, rows) = read(path)?;
            if let Some(difference) = header.difference(&found) {
                return Err(Error::Input(format!(
                    "--resume {}: the file is of another ensemble: {difference}; take another name",
                    path.display()
                )));
            }
            rows
        } else {
            Vec::new()
        };
        // Written anew: a line that was cut off must not lie before the next one.
        output.write(&render(header, &rows)?)?;
        let file = OpenOptions::new().append(true).open(path).map_err(fails)?;
        Ok((Self { file, path: path.into() }, rows))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// Returns an error that names the file if it cannot be written.
    pub fn add(&mut self, row: &CaseResult) -> Result<(), Error> {
        let line = lines(std::slice::from_ref(row), false)?;
        let path = &self.path;
        let fails = |source: io::Error| Error::File { action: "write", path: path.clone(), source };
        self.file.write_all(&line).map_err(fails)
    }
}

/// Part `k` of `n` of an ensemble's cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1 to `of`.
    pub number: u64,
    /// Number of parts.
    pub of: u64,
}

impl Shard {
    /// Reads `k/n`.
    ///
    /// # Errors
    /// Returns an error that states what is allowed.
    pub fn read(text: &str) -> Result<Self, Error> {
        let read = || {
            let (number, of) = text.split_once('/')?;
            let shard = Self { number: number.parse().ok()?, of: of.parse().ok()? };
            (1..=shard.of).contains(&shard.number).then_some(shard)
        };
        read().ok_or_else(|| {
            Error::Input(format!("--shard {text}: must be K/N with K from 1 to N, as in 3/16"))
        })
    }

    /// Returns whether a case belongs to this part. Successive pairs of cases go to different
    /// parts, so that the costs of a family are spread.
    pub const fn has(self, case: u64) -> bool {
        // The resolution of the encoder alternates. By pairs, every part has both, also of an even
        // number of parts.
        (case / 2) % self.of == self.number - 1
    }
}
