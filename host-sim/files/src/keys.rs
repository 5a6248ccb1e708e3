//! Keys of a machine's file: a schema for editors, a list for the terminal, a page for docs/.
//!
//! All are generated from declarations: those of the core (`stiction::units::value`) and those of
//! the simulator's own tables ([`crate::machine`]).

use serde_json::Value;
use stiction::Fault;
use stiction::control::laws::{FIRST_LAW, Gains, MAX_TERMS};
use stiction::parameters;

use crate::data_sheet::OF_A_SHEET;
use crate::error::{Error, suggestion};
use crate::lines::wrapped;
use crate::machine::MachineFile;
use crate::written::shown_law;

/// Description of a key of a machine's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyRow {
    /// Table of the key.
    pub table: String,
    /// Name in that table.
    pub name: String,
    /// Allowed values.
    pub allowed: String,
    /// Default.
    pub otherwise: String,
    /// Number in records and over the link; empty for a key of the simulator.
    pub number: String,
    /// Meaning.
    pub text: String,
}

/// Returns the JSON schema of a machine's file.
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(MachineFile).into();
    for key in OF_A_SHEET {
        may_be_left_out(&mut schema, key);
    }
    // Both tables can be derived from a data sheet.
    may_be_left_out(&mut schema, "joint");
    may_be_left_out(&mut schema, "joint.friction");
    schema
}

/// Removes a key from the required ones of its table, since a data sheet can replace it.
fn may_be_left_out(schema: &mut Value, key: &str) {
    let (tables, name) = key.rsplit_once('.').unwrap_or(("", key));
    let root = schema.clone();
    let mut pointer = String::new();
    for table in tables.split('.').filter(|table| !table.is_empty()) {
        let inside = format!("{pointer}/properties/{table}");
        let reference = root.pointer(&inside).and_then(|inner| inner.get("$ref"));
        let target = reference.and_then(Value::as_str).and_then(|path| path.strip_prefix('#'));
        pointer = target.map_or(inside, Into::into);
    }
    let Some(Value::Object(table)) = schema.pointer_mut(&pointer) else { return };
    if let Some(Value::Array(required)) = table.get_mut("required") {
        required.retain(|one| one != name);
    }
    let property = table.get_mut("properties").and_then(|all| all.get_mut(name));
    if let Some(Value::Object(property)) = property {
        property.insert("x-of-a-sheet".into(), true.into());
    }
}

/// Returns all keys, in the order of the tables of a file.
pub fn rows() -> Vec<KeyRow> {
    let schema = schema();
    let mut rows = Vec::new();
    walk(&schema, &schema, "", &mut rows);
    rows
}

/// Lists the keys of one table, or all keys, for the terminal.
///
/// # Errors
/// Returns an error with the most similar name if there is no such table.
pub fn list(table: Option<&str>) -> Result<String, Error> {
    let rows = rows();
    let tables = tables(&rows);
    let is_wanted = |name: &str| table.is_none_or(|table| name == table || name == table_of(table));
    if let Some(table) = table.filter(|_| !tables.iter().any(|name| is_wanted(name))) {
        // A table with names chosen by the user has one row, its description.
        if let Some(row) = rows.iter().find(|row| row.table == AT_THE_TOP && row.name == table) {
            return Ok(shown_row(row));
        }
        let near = suggestion(table, tables.iter().map(String::as_str));
        return Err(Error::Input(format!("keys {table}: there is no such table{near}")));
    }
    let mut text = String::new();
    for name in tables.iter().filter(|name| is_wanted(name)) {
        text += &format!("[{name}]\n");
        for row in rows.iter().filter(|row| row.table == *name) {
            text += &shown_row(row);
        }
    }
    Ok(text)
}

fn shown_row(row: &KeyRow) -> String {
    format!("  {}\n      {}; {}\n", row.name, row.allowed, row.otherwise) + &wrapped(&row.text, 6)
}

/// Name for keys without a table.
const AT_THE_TOP: &str = "at the top";

/// Returns the page docs/reference/parameters.md.
pub fn markdown() -> String {
    let rows = rows();
    let mut page = String::from(
        "# Parameters\n\n\
         Every key of a machine's file. This page is generated: `stiction keys --markdown` prints \
         it, and a test holds it up\nto date. `stiction keys [TABLE]` shows the same in a \
         terminal, \
         `stiction keys --schema` a JSON schema for editors.\n\n\
         The *number* is that of the value in the record of the flash and over the link; keys \
         without one are the simulator's own.\n",
    );
    for table in tables(&rows) {
        page += &format!("\n## [{table}]\n\n| key | allowed | left out | number | |\n");
        page += "|---|---|---|---|---|\n";
        for row in rows.iter().filter(|row| row.table == table) {
            let number =
                if row.number.is_empty() { String::new() } else { format!("`{}`", row.number) };
            let text = row.text.replace('|', "\\|");
            page += &format!(
                "| `{}` | {} | {} | {number} | {text} |\n",
                row.name, row.allowed, row.otherwise
            );
        }
    }
    page += "\n## Numbers without a key\n\n\
             A record and the link also have the laws of the sum and the motion, which a file says \
             in other ways.\n\n| number | |\n|---|---|\n";
    let first = FIRST_LAW.0;
    page += &format!(
        "| `{first:#06x}` to `{:#06x}` | Which laws are added to PD, each once; 0: there is none, \
         nor after it. {}. |\n",
        first + MAX_TERMS as u16 - 1,
        Gains::EXAMPLES
            .iter()
            .map(|law| format!("{} {}", law.id(), shown_law(law)))
            .collect::<Vec<_>>()
            .join(", "),
    );
    let keyless = stiction::parameters::declarations().filter(|about| about.field.is_empty());
    for about in keyless {
        let number = about.key.0;
        let next = if number >= CORNERS { "; that of the next corner is 4 higher" } else { "" };
        page += &format!("| `{number:#06x}`{next} | {} |\n", about.text.trim());
    }
    page
}

/// Number of the first value of a corner.
const CORNERS: u16 = 0x0700;

/// Returns the table of docs/reference/faults.md.
pub fn faults() -> String {
    let mut table = String::from(
        "| code | fault | seen within | value | threshold | ends with \
         |\n|---|---|---|---|---|---|\n",
    );
    for fault in Fault::ALL {
        let value = match (fault.value(), fault.unit()) {
            ("", _) => String::new(),
            (value, unit) => format!("{value}, {unit}"),
        };
        // All of them belong to the table `[limits]`.
        let names = fault.limits().iter().filter_map(|key| parameters::about(*key));
        let limits = names.map(|about| format!("`{}`", about.name)).collect::<Vec<_>>().join(", ");
        let ends = match (fault.is_clearable(), fault.ends_with_parameters()) {
            (true, _) => "`faults --clear`",
            (false, true) => "valid parameters",
            (false, false) => "a reset",
        };
        table += &format!(
            "| {} | [{}](#{}) | {} | {value} | {limits} | {ends} |\n",
            *fault as u8,
            fault.describe(),
            anchor(fault.section()),
            fault.seen_within(),
        );
    }
    table
}

/// Returns the anchor of a heading.
fn anchor(heading: &str) -> String {
    heading.to_lowercase().replace(' ', "-").replace(',', "")
}

fn tables(rows: &[KeyRow]) -> Vec<String> {
    let mut tables: Vec<String> = Vec::new();
    for row in rows {
        if !tables.contains(&row.table) {
            tables.push(row.table.clone());
        }
    }
    tables
}

/// Returns the name of a table in the list: `controller.NAME` for `controller.srnf`.
fn table_of(table: &str) -> String {
    match table.split_once('.') {
        Some(("controller", _)) => "controller.NAME".into(),
        None if table == "controller" => "controller.NAME".into(),
        _ => table.into(),
    }
}

/// Follows the reference of a schema.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let target = schema.get("$ref").and_then(Value::as_str).and_then(|path| path.strip_prefix('#'));
    target.and_then(|path| root.pointer(path)).unwrap_or(schema)
}

/// Returns the schema of a value that is present, for one that can be left out.
fn present<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    let schema = resolved(root, schema);
    let choices = schema.get("anyOf").and_then(Value::as_array);
    let is_null = |choice: &&Value| choice.get("type").and_then(Value::as_str) == Some("null");
    match choices {
        Some(choices) if choices.iter().any(|choice| is_null(&choice)) => choices
            .iter()
            .find(|choice| !is_null(choice))
            .map_or(schema, |choice| resolved(root, choice)),
        _ => schema,
    }
}

fn walk(root: &Value, schema: &Value, table: &str, rows: &mut Vec<KeyRow>) {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return };
    let required = schema.get("required").and_then(Value::as_array);
    let is_required = |name: &str| required.is_some_and(|all| all.iter().any(|one| one == name));
    let mut inner = Vec::new();
    for (name, property) in properties {
        let target = present(root, property);
        let path = if table.is_empty() { name.clone() } else { format!("{table}.{name}") };
        let item = target.get("items").map(|item| present(root, item));
        if target.get("properties").is_some() {
            inner.push((target, path));
        } else if let Some(item) = item.filter(|item| item.get("properties").is_some()) {
            inner.push((item, format!("[{path}]")));
        } else if let Some(named) =
            target.get("additionalProperties").filter(|named| named.is_object())
            && resolved(root, named).get("properties").is_some()
        {
            inner.push((resolved(root, named), format!("{path}.NAME")));
        } else {
            rows.push(row(root, table, name, property, is_required(name)));
        }
    }
    for (schema, path) in inner {
        walk(root, schema, &path, rows);
    }
}

fn row(root: &Value, table: &str, name: &str, property: &Value, is_required: bool) -> KeyRow {
    let target = present(root, property);
    let text = |key: &str| property.get(key).or_else(|| target.get(key)).and_then(Value::as_str);
    let default = property.get("default").filter(|default| !default.is_null());
    let otherwise = match default {
        _ if is_required => "needed".to_owned(),
        _ if property.get("x-of-a-sheet").is_some() => "needed without a data sheet".to_owned(),
        _ if property.get("x-derived").is_some() => "derived".to_owned(),
        Some(Value::String(text)) if text.is_empty() => "empty".to_owned(),
        Some(default) => shown(default),
        None if text("x-laws").is_some() => {
            format!("needed by {}", text("x-laws").unwrap_or_default())
        }
        None => "none".to_owned(),
    };
    KeyRow {
        table: if table.is_empty() { AT_THE_TOP.into() } else { table.to_owned() },
        name: name.to_owned(),
        allowed: allowed(root, target),
        otherwise,
        number: text("x-number").unwrap_or_default().to_owned(),
        text: text("description")
            .unwrap_or_default()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" "),
    }
}

fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) => {
            number.as_f64().map_or_else(|| number.to_string(), crate::error::shown)
        }
        _ => value.to_string(),
    }
}

/// Describes the allowed values.
fn allowed(root: &Value, schema: &Value) -> String {
    if let Some(constant) = schema.get("const") {
        return format!("`\"{}\"`", shown(constant));
    }
    if let Some(words) = schema.get("x-bounds").and_then(Value::as_str) {
        return format!("a number {words}");
    }
    let words = |values: &Vec<Value>| values.iter().map(shown).collect::<Vec<_>>().join(" or ");
    if let Some(values) = schema.get("enum").and_then(Value::as_array) {
        return words(values);
    }
    if let Some(choices) =
        schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array)
    {
        let constants: Vec<String> =
            choices.iter().filter_map(|one| one.get("const")).map(shown).collect();
        let others: Vec<String> =
            choices.iter().map(|one| allowed(root, present(root, one))).collect();
        return if constants.len() == choices.len() { constants } else { others }.join(" or ");
    }
    let limit = |key: &str| schema.get(key).map(shown);
    let what = match schema.get("type").map(|kind| kind.as_str().or_else(|| kind.get(0)?.as_str()))
    {
        Some(Some("integer")) => "a whole number",
        Some(Some("boolean")) => return "true or false".into(),
        Some(Some("string")) => return "a text".into(),
        Some(Some("array")) => {
            let item = schema
                .get("items")
                .map_or("values".into(), |item| allowed(root, present(root, item)));
            return format!("a list of: {item}");
        }
        Some(Some("object")) => return "a table".into(),
        _ => "a number",
    };
    match (limit("minimum"), limit("exclusiveMinimum"), limit("maximum")) {
        (Some(low), _, Some(high)) => format!("{what} from {low} to {high}"),
        (_, Some(low), Some(high)) => format!("{what} above {low}, up to {high}"),
        _ => what.into(),
    }
}
