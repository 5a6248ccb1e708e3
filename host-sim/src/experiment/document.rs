//! A machine's TOML as text: reading it, setting keys in it, and saying what is wrong with it.

use std::fs;
use std::path::Path;

use toml::{Table, Value};

use super::builtin;
use crate::error::{Error, suggestion};
use crate::machine::Machine;

/// A parsed file, and where it came from.
#[derive(Clone, Debug)]
pub struct Document {
    /// A built-in experiment's name or a file's path, for messages.
    pub origin: String,
    table: Table,
}

impl Document {
    /// Opens a built-in experiment by its name, or a file by its path (ending in `.toml` or holding a separator).
    ///
    /// # Errors
    /// Says what is wrong with the name, the file or the TOML.
    pub fn open(name: &str) -> Result<Self, Error> {
        let looks_like_a_file = name.ends_with(".toml") || name.contains(std::path::MAIN_SEPARATOR);
        let document = if looks_like_a_file || Path::new(name).is_file() {
            let path = Path::new(name);
            let text = fs::read_to_string(path).map_err(|source| Error::File {
                action: "read",
                path: path.to_owned(),
                source,
            })?;
            Self::parse(name, &text)?
        } else {
            Self::parse(name, builtin::find(name)?.toml)?
        };
        document.machine()?;
        Ok(document)
    }

    /// Parses a text.
    ///
    /// # Errors
    /// Names the line.
    pub fn parse(origin: &str, text: &str) -> Result<Self, Error> {
        let table = text.parse::<Table>().map_err(|error| {
            let line =
                error.span().map_or(1, |span| text[..span.start.min(text.len())].lines().count().max(1));
            Error::Input(format!("{origin}, line {line}: {}", one_line(error.message())))
        })?;
        Ok(Self { origin: origin.into(), table })
    }

    /// Sets keys as on the command line, `table.key=value` each, and checks the result after each.
    ///
    /// # Errors
    /// Names the assignment.
    pub fn set(&mut self, assignments: &[String]) -> Result<(), Error> {
        for assignment in assignments {
            let origin = format!("--set {assignment}");
            let Some((key, value)) = assignment.split_once('=') else {
                return Err(Error::Input(format!("{origin}: write it as table.key=value")));
            };
            self.put(
                key.trim(),
                parse_value(value.trim()).map_err(|why| Error::Input(format!("{origin}: {why}")))?,
            )
            .and_then(|()| self.machine())
            .map_err(|error| Error::Input(format!("{origin}: {}", self.without_origin(&error))))?;
        }
        Ok(())
    }

    /// The document with a variant's keys set.
    ///
    /// # Errors
    /// Names the variant.
    pub fn with(&self, slug: &str, keys: &Table) -> Result<Self, Error> {
        let mut copy = self.clone();
        copy.origin = format!("{}, variant `{slug}`", self.origin);
        for (key, value) in keys {
            copy.put(key, value.clone())
                .map_err(|error| Error::Input(format!("{}: {}", copy.origin, self.without_origin(&error))))?;
        }
        copy.machine()?;
        Ok(copy)
    }

    /// What a key has been set to.
    pub fn get(&self, key: &str) -> Option<&Value> {
        let mut path = key.split('.');
        let first = self.table.get(path.next()?)?;
        path.try_fold(first, |value, part| value.get(part))
    }

    /// The machine that the document describes.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn machine(&self) -> Result<Machine, Error> {
        serde_path_to_error::deserialize(Value::Table(self.table.clone())).map_err(|error| {
            let path = error.path().to_string();
            let message = explain(&path, error.inner().message());
            Error::Input(format!("{}: {message}", self.origin))
        })
    }

    fn put(&mut self, key: &str, value: Value) -> Result<(), Error> {
        let refuse = |why: String| Err(Error::Input(why));
        let mut path: Vec<&str> = key.split('.').collect();
        let Some(last) = path.pop().filter(|_| !path.is_empty()) else {
            return refuse(format!("`{key}` names no table; write it as table.key=value"));
        };
        if let ["controller", name, ..] = path[..] {
            let names: Vec<&str> = self
                .get("controller")
                .and_then(Value::as_table)
                .map_or(vec![], |controllers| controllers.keys().map(String::as_str).collect());
            if !names.contains(&name) {
                let near = suggestion(name, names.iter().copied());
                return refuse(format!("there is no controller `{name}`{near}"));
            }
        }
        let mut table = &mut self.table;
        for part in path {
            match table.entry(part).or_insert_with(|| Value::Table(Table::new())) {
                Value::Table(inner) => table = inner,
                _ => return refuse(format!("`{part}` in `{key}` is not a table")),
            }
        }
        table.insert(last.into(), value);
        Ok(())
    }

    fn without_origin(&self, error: &Error) -> String {
        let text = error.to_string();
        text.strip_prefix(&format!("{}: ", self.origin)).unwrap_or(&text).into()
    }
}

/// A TOML value; a bare word is a string, so that `run.solver=rk4` needs no quotes inside quotes.
fn parse_value(text: &str) -> Result<Value, String> {
    if let Ok(mut table) = format!("value = {text}").parse::<Table>()
        && let Some(value) = table.remove("value")
    {
        return Ok(value);
    }
    if !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Ok(Value::String(text.into()));
    }
    Err(format!("`{text}` is neither a number, a word, a quoted string nor a list"))
}

/// Says in one sentence what serde found wrong at a path.
fn explain(path: &str, message: &str) -> String {
    let message = one_line(message);
    let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent);
    // The second to last names between back quotes are what serde would have taken.
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if message.starts_with("unknown field") {
        let (typed, known) = quoted.split_first().unwrap_or((&"", &[]));
        let whole = if parent.is_empty() { (*typed).to_owned() } else { format!("{parent}.{typed}") };
        let mut near = suggestion(typed, known.iter().copied());
        if near.is_empty() {
            near = format!("; allowed are {}", known.join(", "));
        }
        format!("unknown key `{whole}`{near}")
    } else if message.starts_with("unknown variant") {
        let (typed, known) = quoted.split_first().unwrap_or((&"", &[]));
        let near = suggestion(typed, known.iter().copied());
        format!("`{path}` is `{typed}`; allowed are {}{near}", known.join(", "))
    } else if message.starts_with("missing field") {
        let prefix = if path == "." { String::new() } else { format!("{path}.") };
        format!("`{prefix}{}` is missing", quoted.first().unwrap_or(&""))
    } else if let Some((found, expected)) =
        message.strip_prefix("invalid type: ").and_then(|rest| rest.split_once(", expected "))
    {
        let expected = match expected {
            "f64" => "a number",
            "u8" | "usize" => "a whole number",
            "a sequence" => "a list",
            other => other,
        };
        format!("`{path}` is {found}; allowed is {expected}")
    } else {
        format!("`{path}`: {message}")
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
