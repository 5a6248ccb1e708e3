//! The thesis's tables beside the values used here, from the built-in experiments and the runs.

use serde::Serialize;
use toml::Value;

use super::content::{RowText, TableText};
use super::evidence::ReportEvidence;
use files::error::{Error, shown};
use simulator::experiment;

/// A table of the page.
#[derive(Debug, Serialize)]
pub struct ThesisTable {
    /// Its number in the thesis.
    pub number: u32,
    /// Heading.
    pub title: String,
    /// Built-in experiment that has its values.
    pub experiment: String,
    /// Note below the table.
    pub note: String,
    /// Rows.
    pub rows: Vec<TableRow>,
}

/// A row of the page.
#[derive(Debug, Serialize)]
pub struct TableRow {
    /// Quantity.
    pub what: String,
    /// Value that the thesis prints.
    pub printed: String,
    /// Value used here.
    pub used: String,
    /// Reason of a difference.
    pub note: String,
}

/// Returns all tables.
///
/// # Errors
/// Returns an error that names a key that no experiment has, or a run that is missing.
pub fn tables(texts: &[TableText], evidence: &ReportEvidence) -> Result<Vec<ThesisTable>, Error> {
    texts.iter().map(|text| table(text, evidence)).collect()
}

fn table(text: &TableText, evidence: &ReportEvidence) -> Result<ThesisTable, Error> {
    let file = match text.experiment.as_str() {
        "" => None,
        name => Some(
            experiment::find(name)?
                .toml
                .parse::<toml::Table>()
                .map(Value::Table)
                .map_err(|error| Error::Input(format!("{name}: {}", error.message())))?,
        ),
    };
    let row = |row: &RowText| {
        let used = used(row, file.as_ref(), evidence).ok_or_else(|| {
            Error::Input(format!("table {} of the report: no value of `{}`", text.number, row.what))
        })?;
        Ok(TableRow {
            what: row.what.clone(),
            printed: row.printed.clone(),
            used,
            note: row.note.clone(),
        })
    };
    Ok(ThesisTable {
        number: text.number,
        title: text.title.clone(),
        experiment: text.experiment.clone(),
        note: text.note.clone(),
        rows: text.rows.iter().map(row).collect::<Result<_, Error>>()?,
    })
}

fn used(row: &RowText, file: Option<&Value>, evidence: &ReportEvidence) -> Option<String> {
    if let Some(text) = &row.used {
        return Some(text.clone());
    }
    if let Some(run) = &row.evaluations {
        return Some(match evidence.lab(run) {
            Some(result) => {
                let wall_s = result.wall.as_secs_f64();
                let wall = if wall_s < 1.0 {
                    format!("{:.1} ms", 1e3 * wall_s)
                } else {
                    format!("{wall_s:.1} s")
                };
                format!("{} evaluations, {wall}", grouped(result.evaluations))
            }
            None => evidence.trouble(run)?.to_owned(),
        });
    }
    let key = row.key.as_ref()?;
    let value = key.split('/').try_fold(file?, |value, part| match value {
        Value::Array(list) => list.get(part.parse::<usize>().ok()?),
        other => other.get(part),
    })?;
    let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
    Some(number(value)? + &unit)
}

/// Formats a number, or a list of numbers or of ranges.
fn number(value: &Value) -> Option<String> {
    match value {
        Value::Float(number) => Some(six_digits(*number)),
        Value::Integer(number) => Some(number.to_string()),
        Value::Array(list) => {
            let all = list.iter().map(|entry| match entry {
                Value::Array(range) => {
                    Some(range.iter().map(number).collect::<Option<Vec<_>>>()?.join("\u{2013}"))
                }
                other => number(other),
            });
            Some(all.collect::<Option<Vec<_>>>()?.join(", "))
        }
        _ => None,
    }
}

/// Formats a number with six digits, without trailing zeros.
fn six_digits(value: f64) -> String {
    shown(format!("{value:.5e}").parse().unwrap_or(value))
}

/// Groups the digits of a count: 2 000 001.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups =
        digits.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group).into_owned());
    groups.collect::<Vec<_>>().join("\u{202f}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_a_person_would_write_them() {
        let value = |text: &str| format!("a = {text}").parse::<toml::Table>().unwrap()["a"].clone();
        assert_eq!(number(&value("0.10")).unwrap(), "0.1");
        assert_eq!(number(&value("9.948376736e-7")).unwrap(), "9.94838e-7");
        assert_eq!(number(&value("[[3.0, 5.0], [8.0, 10.0]]")).unwrap(), "3\u{2013}5, 8\u{2013}10");
        assert_eq!(number(&value("\"pd\"")), None);
        assert_eq!(grouped(2_000_001), "2\u{202f}000\u{202f}001");
    }
}
