//! The parameters in use as a form: name, range and value of each.
//!
//! The names, bounds and sentences are those of the declarations ([`files::keys`]), and the values
//! those of a machine's file ([`simulator::device::machine_file`]), so the form has no list of its
//! own.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::control::pd::PdGains;
use stiction::units::value::Table as _;
use toml::Table;

use files::error::{Error, suggestion};
use files::keys::{self, KeyRow};
use files::typed_number;
use simulator::device::machine_file;
use simulator::experiment::{Document, about_law};

/// Values of the parameters, by their paths in a machine's file.
type Values = Vec<(String, String)>;

/// Returns the form of the parameters in use. `saved` are the parameters that a reset restores, if
/// known.
///
/// # Errors
/// Returns an error if a number cannot be written.
pub fn rows(now: &Parameters, saved: Option<&Parameters>) -> Result<Value, Error> {
    let declared = keys::rows();
    let before: BTreeMap<String, String> =
        saved.map(values).transpose()?.unwrap_or_default().into_iter().collect();
    // A table of gains is written with the defaults of every law. The form has only the own gains.
    let laws = now.controller.compensator.iter().flat_map(about_law);
    let own: Vec<&str> = PdGains::ABOUT.iter().chain(laws).map(|about| about.name).collect();
    let is_own = |path: &str| {
        let gain = path.strip_prefix("controller.").and_then(|path| path.split_once('.'));
        gain.is_none_or(|(_, name)| own.contains(&name))
    };
    let in_use = values(now)?.into_iter().filter(|(path, _)| is_own(path));
    let rows = in_use.map(|(path, value)| {
        let (table, name) = path.rsplit_once('.').unwrap_or(("", &path));
        let row = about(&declared, table, name);
        let was = if saved.is_some() { before.get(&path).cloned() } else { None };
        json!({
            "path": path,
            "table": table,
            "name": name,
            "value": value,
            "saved": was,
            "allowed": row.map_or("", |row| &row.allowed),
            "otherwise": row.map_or("", |row| &row.otherwise),
            "text": row.map_or("", |row| &row.text),
        })
    });
    Ok(rows.collect())
}

/// Changes values of a machine's file, and reads the parameters from the result.
///
/// # Errors
/// Returns an error that names an unknown or invalid value.
pub fn changed(text: &str, changes: &BTreeMap<String, String>) -> Result<Parameters, Error> {
    let mut document: Table =
        toml::from_str(text).map_err(|error| Error::Input(error.to_string()))?;
    for (path, written) in changes {
        let known: Vec<String> = flat(&document).into_iter().map(|(path, _)| path).collect();
        if !known.contains(path) {
            let near = suggestion(path, known.iter().map(String::as_str));
            return Err(Error::Input(format!("params: there is no value `{path}`{near}")));
        }
        let value =
            value(written).map_err(|why| Error::Input(format!("params: `{path}`: {why}")))?;
        put(&mut document, path, value);
    }
    let text = toml::to_string(&document).map_err(|error| Error::Input(error.to_string()))?;
    machine_file::read("params", &text)
}

/// Writes the parameters as a machine's file, with the joint of `machine`.
///
/// # Errors
/// Returns an error if the parameters cannot be written as a file.
pub fn file(of: &Parameters, machine: &str, warning: Option<&str>) -> Result<String, Error> {
    let joint = Document::open(machine)?.machine()?.joint;
    let warning = warning.map_or(String::new(), |warning| format!("# {warning}\n"));
    Ok(warning + &machine_file::render(of, &joint, machine)?)
}

/// Returns every value of the parameters, by its path.
///
/// # Errors
/// Returns an error if a number cannot be written.
pub fn values(of: &Parameters) -> Result<Values, Error> {
    let text = machine_file::tables(of)?;
    toml::from_str(&text).map_err(|error| Error::Input(error.to_string())).map(|table| flat(&table))
}

/// Returns every value of a table, by its path.
fn flat(table: &Table) -> Values {
    let mut all = Values::new();
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => {
                all.extend(flat(inner).into_iter().map(|(path, v)| (format!("{key}.{path}"), v)));
            }
            toml::Value::String(text) => all.push((key.clone(), text.clone())),
            other => all.push((key.clone(), other.to_string())),
        }
    }
    all
}

fn put(table: &mut Table, path: &str, value: toml::Value) {
    match path.split_once('.') {
        None => drop(table.insert(path.to_owned(), value)),
        Some((first, rest)) => {
            if let Some(toml::Value::Table(inner)) = table.get_mut(first) {
                put(inner, rest, value);
            }
        }
    }
}

/// Parses a typed value: a number, a flag, a list, or else a word. A list has brackets, so a comma
/// without them is a decimal comma.
fn value(written: &str) -> Result<toml::Value, String> {
    let typed = written.trim();
    let number = match typed_number::parse(typed) {
        // A key of a whole number does not accept 5.0.
        Ok(number) => {
            let whole = typed.parse().map(toml::Value::Integer);
            return Ok(whole.unwrap_or(toml::Value::Float(number)));
        }
        Err(why) => why,
    };
    let parsed: Result<Table, _> = toml::from_str(&format!("value = {written}"));
    let parsed = parsed.ok().filter(|table| table.len() == 1);
    match parsed.and_then(|mut table| table.remove("value")) {
        // TOML also accepts 1_000 and 0x10, which are typing errors here.
        Some(toml::Value::Integer(_) | toml::Value::Float(_)) => Err(number),
        Some(value) => Ok(value),
        // A text that starts like a number is a typing error, not a word.
        None if typed.starts_with(|c: char| c.is_ascii_digit() || "+-.,\u{2212}".contains(c)) => {
            Err(number)
        }
        None => Ok(toml::Value::String(typed.to_owned())),
    }
}

/// Returns the declaration of a key. If its table has none, that of the table's kind is used, as
/// `controller.NAME` for `controller.srnf`.
pub fn about<'a>(rows: &'a [KeyRow], table: &str, name: &str) -> Option<&'a KeyRow> {
    let of = |wanted: &str| rows.iter().find(|row| row.table == wanted && row.name == name);
    let kind = table.split_once('.').map(|(first, _)| format!("{first}.NAME"));
    of(table).or_else(|| of(&kind?))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use simulator::experiment::Experiment;

    fn parameters() -> Parameters {
        let document = Document::open("step-response").unwrap();
        let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
        simulator::device::parameters(&plan).unwrap()
    }

    fn set(path: &str, value: &str) -> Result<Parameters, Error> {
        let text = file(&parameters(), "step-response", None).unwrap();
        changed(&text, &[(path.to_owned(), value.to_owned())].into())
    }

    #[test]
    fn every_row_of_the_form_has_its_sentence_and_its_bounds() {
        let rows = rows(&parameters(), None).unwrap();
        let rows = rows.as_array().unwrap();
        assert!(rows.len() > 40, "{}", rows.len());
        for row in rows {
            let all = ["path", "name", "allowed", "text"];
            assert!(all.iter().all(|key| !row[key].as_str().unwrap().is_empty()), "{row}");
            assert!(row["saved"].is_null());
        }
        let gains = rows.iter().filter(|row| row["table"] == "controller.srnf");
        let names: Vec<&str> = gains.map(|row| row["name"].as_str().unwrap()).collect();
        let srnf = ["kp_v_per_deg", "kd_v_per_deg_per_s", "v_ms_v", "alpha_per_deg"];
        assert!(srnf.iter().all(|name| names.contains(name)), "{names:?}");
        assert!(!names.contains(&"stop_band_counts"), "a gain of another law");
    }

    #[test]
    fn a_value_is_changed_alone_and_marked_against_what_is_saved() {
        let before = parameters();
        let after = set("limits.stall_s", "0.75").unwrap();
        assert_eq!(machine_file::changes(&before, &after).unwrap().len(), 1);
        let rows = rows(&after, Some(&before)).unwrap();
        let is_changed = |row: &&Value| row["saved"] != row["value"];
        let changed: Vec<&Value> = rows.as_array().unwrap().iter().filter(is_changed).collect();
        assert_eq!(changed.len(), 1, "{changed:?}");
        assert_eq!(
            (&changed[0]["path"], &changed[0]["value"]),
            (&"limits.stall_s".into(), &"0.75".into())
        );
    }

    #[test]
    fn a_word_is_read_as_it_is_typed() {
        let now = set("limits.link_timeout_s", "off").unwrap();
        assert_eq!(now.limits.link_timeout, 0.0);
        let reverse = set("encoder.direction", "reverse").unwrap();
        assert_ne!(reverse.controller.encoder.direction, parameters().controller.encoder.direction);
    }

    #[test]
    fn a_decimal_comma_is_read_as_in_the_field_of_a_position() {
        let stall = |value| set("limits.stall_s", value).map(|now| now.limits.stall_time);
        assert_eq!(stall("0,75").unwrap(), 0.75);
        assert_eq!(stall(".75").unwrap(), 0.75);
        for (typed, why) in [
            ("60,125", "`60,125` is ambiguous"),
            ("1_000", "`1_000` is not a number"),
            ("0x1", "`0x1` is not a number"),
            ("7,5,5", "`7,5,5` is not a number"),
            ("1 s", "`1 s` is not a number"),
        ] {
            let said = stall(typed).unwrap_err().to_string();
            assert!(said.contains(why) && said.contains("limits.stall_s"), "{said}");
        }
    }

    #[test]
    fn what_is_not_allowed_is_refused_with_its_name() {
        let said = |path, value| set(path, value).map(|_| ()).unwrap_err().to_string();
        assert!(said("limits.stall_s", "-1").contains("limits.stall_s"));
        assert!(said("limits.stall_s", "soon").contains("limits.stall_s"));
        assert!(said("limits.stal_s", "1").contains("did you mean `limits.stall_s`"));
        assert!(said("limits.stall_s", "1\nstall_v = 2").contains("limits.stall_s"), "two lines");
    }
}
