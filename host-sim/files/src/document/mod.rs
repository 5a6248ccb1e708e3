//! TOML of a machine or a friction experiment: reads it, sets keys, and reports its errors.
//!
//! [`crate::machine`] and [`crate::setup`] define its tables; `simulator::experiment` and
//! `thesis::lab` run them.

mod builtin;
mod drawn;
mod missing;
mod origin;
mod recognize;
mod stand_alone;
mod wording;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::de::DeserializeOwned;
use stiction::control::pd::PdGains;
use stiction::units::value::Table as _;
use toml::{Table, Value};

pub use self::builtin::{Builtin, builtins, find};
pub use self::origin::{Origin, within};
pub use self::recognize::is_machine_file;
use self::wording::{brief, refused, syntax};
use crate::data_sheet::{self, DataSheet, Mapping, UnseenSlack};
use crate::error::{Error, suggestion};
use crate::hardware::STM32F405;
use crate::machine::{IdentifiedTable, MachineFile};
use crate::setup::Setup;
use crate::typed_number;

/// Largest size of a file, bytes. A machine's file has a few kilobytes; a device or a recording
/// given by mistake can be endless.
const MAX_BYTES: u64 = 1 << 20;

/// Longest name of a controller or variant, so that a table of 80 columns has room for its numbers.
const LONGEST_NAME: usize = 20;

/// Advice on how to write an assignment.
const HOW_TO_SET: &str = "write it as table.key=value, as in run.duration_s=120";

/// A parsed file, and its origin.
#[derive(Clone, Debug)]
pub struct Document {
    /// Origin of the file, for messages.
    pub origin: Origin,
    table: Table,
}

impl Document {
    /// Opens a built-in experiment by its name, or a file by its path. A path ends in `.toml`, has
    /// a separator, or exists and is not the name of a built-in experiment.
    ///
    /// # Errors
    /// Returns an error about the name, the file or the TOML.
    pub fn open(name: &str) -> Result<Self, Error> {
        let document = Self::parse(name, &Self::text(name)?)?;
        document.check()?;
        document.check_spread()?;
        Ok(document)
    }

    /// Returns the text of a built-in experiment or of a file, as [`open`](Self::open) finds it.
    ///
    /// # Errors
    /// Returns an error about the name or the file.
    pub fn text(name: &str) -> Result<String, Error> {
        let looks_like_a_file = name.ends_with(".toml") || name.contains(std::path::MAIN_SEPARATOR);
        match builtin::find(name) {
            Ok(builtin) => Ok(builtin.toml.into()),
            Err(unknown) if !looks_like_a_file && !Path::new(name).is_file() => Err(unknown),
            Err(_) => read(Path::new(name)),
        }
    }

    /// Parses a text.
    ///
    /// # Errors
    /// Returns an error that names the line.
    pub fn parse(name: &str, text: &str) -> Result<Self, Error> {
        let table = text.parse::<Table>().map_err(|error| {
            let (line, what) = syntax(text, &error);
            Error::Input(format!("{name}, line {line}: {what}"))
        })?;
        Ok(Self {
            origin: Origin { name: name.into(), variant: None, set: vec![], drawn: vec![] },
            table,
        })
    }

    /// Sets keys by assignments such as `table.key=value`, and checks the result.
    ///
    /// # Errors
    /// Returns an error that names the assignment.
    pub fn set(&mut self, assignments: &[String]) -> Result<(), Error> {
        for assignment in assignments {
            self.assign(assignment)
                .map_err(|why| Error::Input(format!("{}: {why}", brief(assignment))))?;
            self.origin.set.push(assignment.clone());
        }
        self.check()
    }

    /// Sets numbers, each under its key, and checks the result.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn set_numbers(&mut self, numbers: &[(String, f64)]) -> Result<(), Error> {
        for (key, number) in numbers {
            let assignment = format!("{key}={number:?}");
            self.put(key, Value::Float(*number), HOW_TO_SET)
                .map_err(|why| Error::Input(format!("{}: {why}", brief(&assignment))))?;
            self.origin.set.push(assignment);
        }
        self.check()
    }

    /// Adds controllers with gains of zero and without a law, for laws of another program. Returns
    /// the controllers to run: `wanted` and `names`. If `wanted` is empty, the list is empty: all
    /// controllers run, those of the file and the added ones.
    ///
    /// # Errors
    /// Returns an error if the file already has a controller with one of the names.
    pub fn add_controllers(
        &mut self,
        wanted: &[String],
        names: &[String],
    ) -> Result<Vec<String>, Error> {
        if names.is_empty() {
            return Ok(wanted.to_vec());
        }
        let machine = self.machine()?;
        if let Some(name) = names.iter().find(|name| machine.controller.contains_key(*name)) {
            return Err(Error::Input(format!(
                "{}: a `[controller.{name}]` is in the file already",
                self.origin
            )));
        }
        let listed = machine.sampling.extras.list().iter().chain(names);
        let listed = listed.map(|name| Value::from(name.as_str())).collect();
        self.insert("loop", "controller", Value::Array(listed));
        for name in names {
            let laws = ("laws".to_owned(), Value::Array(Vec::new()));
            let gains = PdGains::ABOUT.iter().map(|about| (about.name.to_owned(), 0.0.into()));
            let none = Table::from_iter(gains.chain([laws]));
            self.insert("controller", name, Value::Table(none));
        }
        self.check()?;
        let all = wanted.iter().chain(names.iter().filter(|_| !wanted.is_empty()));
        Ok(all.cloned().collect())
    }

    fn insert(&mut self, table: &str, key: &str, value: Value) {
        let table = self.table.entry(table).or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(table) = table {
            table.insert(key.to_owned(), value);
        }
    }

    fn assign(&mut self, assignment: &str) -> Result<(), String> {
        let (key, value) = assignment.split_once('=').ok_or(HOW_TO_SET)?;
        self.put(key.trim(), parse_value(value.trim())?, HOW_TO_SET)
    }

    /// Checks that joints can be drawn from `[spread]`.
    fn check_spread(&self) -> Result<(), Error> {
        if self.is_lab() {
            return Ok(());
        }
        let spread = self.machine()?.spread;
        for (key, range) in &spread {
            let refuse = |why: &str| {
                Err(Error::Input(format!("{}: `spread.\"{key}\"`: {why}", self.origin)))
            };
            if let Some(why) = refused_spread(key, *range) {
                return refuse(why);
            }
            if self.get(key).is_some_and(|value| value.is_float() || value.is_integer()) {
                continue;
            }
            // Checks keys that the file does not set.
            let mut joint = self.clone();
            let drawn = joint.put(key, Value::Float(range[0]), HOW_TO_SET);
            if let Err(why) = drawn.map_err(Error::Input).and_then(|()| joint.check()) {
                let why = why.to_string();
                let why = why.strip_prefix(&format!("{}: ", self.origin)).unwrap_or(&why);
                return refuse(why);
            }
        }
        Ok(())
    }

    /// Returns whether the document is a friction experiment instead of a machine.
    pub fn is_lab(&self) -> bool {
        self.table.contains_key("mechanism")
    }

    /// Checks that every key is known and has a value of its type.
    fn check(&self) -> Result<(), Error> {
        if self.is_lab() { self.setup().map(|_| ()) } else { self.machine().map(|_| ()) }
    }

    /// Returns a copy of the document with the keys of a variant.
    ///
    /// # Errors
    /// Returns an error that names the variant.
    pub fn with(&self, variant: &str, keys: &Table) -> Result<Self, Error> {
        let mut copy = self.clone();
        copy.origin.variant = Some(variant.into());
        for (key, value) in keys {
            copy.put(key, value.clone(), "write it as \"table.key\" = value")
                .map_err(|why| Error::Input(format!("{}: {why}", copy.origin)))?;
        }
        copy.machine()?;
        Ok(copy)
    }

    /// Returns the value of a key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        let mut path = key.split('.');
        let first = self.table.get(path.next()?)?;
        path.try_fold(first, |value, part| value.get(part))
    }

    /// Returns the number under a key, whole or not.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key).and_then(typed_number::of_value)
    }

    /// Reads the machine that the document describes.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn machine(&self) -> Result<MachineFile, Error> {
        let mut table = self.table.clone();
        if let Some(sheet) = self.data_sheet()? {
            data_sheet::derive(&mut table, &sheet, &STM32F405).map_err(|why| self.refuse(&why))?;
        }
        stand_alone::fill(&mut table);
        let machine: MachineFile = self.read_of(&table)?;
        self.check_names(&machine)?;
        Ok(machine)
    }

    /// Reads the data sheet that the document has, if it has one.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn data_sheet(&self) -> Result<Option<DataSheet>, Error> {
        if self.is_lab() {
            return Ok(None);
        }
        let tables: data_sheet::SheetTables = self.read_of(&self.table)?;
        tables.sheet().map_err(|why| self.refuse(&why))
    }

    /// Maps the document's data sheet, if it has one, to the core's units.
    ///
    /// # Errors
    /// As [`data_sheet`](Self::data_sheet).
    pub fn mapping(&self) -> Result<Option<(DataSheet, Mapping)>, Error> {
        let Some(sheet) = self.data_sheet()? else { return Ok(None) };
        let mapping = data_sheet::mapping(&sheet, &self.table).map_err(|why| self.refuse(&why))?;
        Ok(Some((sheet, mapping)))
    }

    /// Returns the slack of the gear that the encoder cannot measure; `None` without a data sheet.
    ///
    /// # Errors
    /// As [`machine`](Self::machine).
    pub fn unseen_slack(&self) -> Result<Option<UnseenSlack>, Error> {
        let Some(sheet) = self.data_sheet()? else { return Ok(None) };
        Ok(UnseenSlack::of(&sheet, self.machine()?.count_deg()))
    }

    /// Returns warnings, one sentence each: implausible values of the data sheet, and doubts of the
    /// identification.
    ///
    /// # Errors
    /// As [`machine`](Self::machine).
    pub fn doubts(&self) -> Result<Vec<String>, Error> {
        if self.is_lab() {
            return Ok(vec![]);
        }
        let mut doubts =
            self.mapping()?.map_or_else(Vec::new, |(sheet, mapping)| sheet.doubts(&mapping));
        if let Some(IdentifiedTable { verdict, doubts: of_joint }) = self.machine()?.identified {
            let said = |doubt| format!("the identification of its joint was {verdict}: {doubt}");
            doubts.extend(of_joint.into_iter().map(said));
        }
        Ok(doubts.into_iter().map(|doubt| format!("{}: {doubt}", self.origin)).collect())
    }

    fn refuse(&self, why: &data_sheet::SheetRefusal) -> Error {
        Error::Input(self.origin.refusal(why))
    }

    /// Reads the friction experiment that the document describes.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn setup(&self) -> Result<Setup, Error> {
        self.read_of(&self.table)
    }

    fn read_of<T: DeserializeOwned>(&self, table: &Table) -> Result<T, Error> {
        serde_path_to_error::deserialize(Value::Table(table.clone())).map_err(|error| {
            let path = error.path().to_string();
            let message = error.inner().message();
            let more = missing::field(&path, message)
                .map(|first| missing::others::<T>(table.clone(), first))
                .unwrap_or_default();
            let what = refused(&path, at(table, &path), message) + &also(&more);
            Error::Input(format!("{}: {what}", self.origin.of(&path)))
        })
    }

    /// Checks the names of controllers and variants, which become labels, parts of file names and
    /// the first column of tables.
    fn check_names(&self, machine: &MachineFile) -> Result<(), Error> {
        let allowed = |name: &str, also: &str| {
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c) || also.contains(c);
            name.len() <= LONGEST_NAME && name.chars().all(plain)
        };
        let refuse = |what: &str, name: &str, allowed: &str| {
            let (origin, name) = (&self.origin, brief(name));
            let allowed = format!("must be 1 to {LONGEST_NAME} letters, digits, {allowed}");
            Err(Error::Input(format!("{origin}: {what} is {name:?}; {allowed}")))
        };
        if let Some(name) =
            machine.controller.keys().find(|name| name.is_empty() || !allowed(name, ""))
        {
            return refuse("the name of a controller", name, "`-` and `_`");
        }
        match machine.variant.iter().find(|variant| !allowed(&variant.slug, ".")) {
            Some(variant) => refuse("the `slug` of a variant", &variant.slug, "`-`, `_` and `.`"),
            None => Ok(()),
        }
    }

    fn put(&mut self, key: &str, value: Value, how: &str) -> Result<(), String> {
        let path: Vec<&str> = key.split('.').collect();
        let Some((last, tables)) = path.split_last().filter(|_| !path.contains(&"")) else {
            return Err(how.into());
        };
        if tables.is_empty() {
            return Err(format!("`{key}` names no table; {how}"));
        }
        if let ["controller", name, ..] = path[..] {
            let names = || {
                let controllers = self.get("controller").and_then(Value::as_table);
                controllers.into_iter().flat_map(Table::keys).map(String::as_str)
            };
            if !names().any(|known| known == name) {
                let near = suggestion(name, names());
                return Err(format!("there is no controller `{name}`{near}"));
            }
        }
        let mut table = &mut self.table;
        for part in tables {
            match table.entry(*part).or_insert_with(|| Value::Table(Table::new())) {
                Value::Table(inner) => table = inner,
                _ => return Err(format!("`{part}` in `{key}` is not a table")),
            }
        }
        table.insert((*last).into(), value);
        Ok(())
    }
}

/// Tables of the joint: the core's, and those of a data sheet.
const OF_THE_JOINT: [&str; 5] = ["joint", "motor", "gear", "load", "friction"];

/// Returns why a key cannot vary over a range; `None` if it can.
pub fn refused_spread(key: &str, [low, high]: [f64; 2]) -> Option<&'static str> {
    let table = key.split('.').next().unwrap_or_default();
    if !OF_THE_JOINT.contains(&table) {
        return Some("only keys of [joint], [motor], [gear], [load] and [friction] can vary");
    }
    let is_range = low.is_finite() && high.is_finite() && low <= high;
    (!is_range).then_some("the range must be LOW..HIGH: two numbers, the lower one first")
}

/// Returns the value at a path with indices, such as `figures[0].of`.
fn at<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    let mut steps = path.split(['.', '[']).map(|step| step.trim_end_matches(']'));
    let first = table.get(steps.next()?)?;
    steps.try_fold(first, |value, step| match value {
        Value::Array(list) => list.get(step.parse::<usize>().ok()?),
        value => value.get(step),
    })
}

/// Returns the rest of a sentence: the other missing keys.
fn also(more: &[String]) -> String {
    let named: Vec<String> = more.iter().map(|key| format!("`{key}`")).collect();
    match &named[..] {
        [] => String::new(),
        [one] => format!(", and so is {one}"),
        [all @ .., last] => format!(", and so are {} and {last}", all.join(", ")),
    }
}

fn read(path: &Path) -> Result<String, Error> {
    let fail = |source| Error::File { action: "read", path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
    read.map_err(fail)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(fail(io::Error::other("it is larger than 1 MiB, so it is no machine's file")));
    }
    String::from_utf8(bytes).map_err(|_| fail(io::Error::other("it is not text (UTF-8)")))
}

/// Parses a TOML value. A bare word is a string, so that `run.solver=rk4` needs no quotes.
fn parse_value(text: &str) -> Result<Value, String> {
    if text.is_empty() {
        return Err("there is no value after the `=`".into());
    }
    if let Ok(mut table) = format!("value = {text}").parse::<Table>()
        && let Some(value) = table.remove("value")
        && table.is_empty()
    {
        return Ok(value);
    }
    if text.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Ok(Value::String(text.into()));
    }
    Err(format!("{text:?} is neither a number, a word, a quoted text nor a list"))
}
