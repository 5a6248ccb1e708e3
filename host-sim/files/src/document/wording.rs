//! Translates errors of the TOML parser and of serde into sentences for the user.

use toml::Value;

use crate::error::suggestion;

/// Returns a sentence about serde's error at a path.
pub fn refused(path: &str, at: Option<&Value>, message: &str) -> String {
    let message = one_line(message);
    let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent);
    let inside = |table: &str, key: &str| match table {
        "" => key.to_owned(),
        table => format!("{table}.{key}"),
    };
    // Names between back quotes: the typed one, then the valid ones.
    let mut quoted = message.split('`').skip(1).step_by(2);
    if message.starts_with("unknown field") {
        let typed = quoted.next().unwrap_or_default();
        return format!("unknown key `{}`{}", inside(parent, typed), suggestion(typed, quoted));
    }
    if message.starts_with("duplicate field") {
        let twice = inside(if path == "." { "" } else { path }, quoted.next().unwrap_or_default());
        return format!("`{twice}` is set in two units");
    }
    if message.starts_with("missing field") {
        let key = inside(if path == "." { "" } else { path }, quoted.next().unwrap_or_default());
        const TABLES: [&str; 8] = [
            "joint",
            "joint.friction",
            "encoder",
            "drive",
            "loop",
            "controller",
            "friction",
            "run",
        ];
        let is_table = TABLES.contains(&&*key);
        return if is_table {
            format!("the table `[{key}]` is missing")
        } else {
            format!("`{key}` is missing")
        };
    }
    let found = at.map_or_else(|| "invalid".into(), describe);
    if message.starts_with("unknown variant") {
        let typed = quoted.next().unwrap_or_default();
        format!("`{path}` is {found}{}", suggestion(typed, quoted))
    } else if message.starts_with("invalid length") {
        let entries = at.and_then(Value::as_array).map_or(0, Vec::len);
        format!("`{path}` has {entries} entries; must have 2")
    } else {
        let expected = message.rsplit_once("expected ").map_or(&*message, |(_, expected)| expected);
        format!("`{path}` is {found}; must be {}", in_words(expected))
    }
}

/// Returns the line at which the parser stopped, and the error.
pub fn syntax(text: &str, error: &toml::de::Error) -> (usize, String) {
    let span = error.span().unwrap_or_default();
    let line = 1 + text.bytes().take(span.start).filter(|byte| *byte == b'\n').count();
    let message = one_line(error.message());
    let (head, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let what = match head {
        "duplicate key" => format!("`{}` is set twice", text.get(span).unwrap_or_default()),
        "string values must be quoted" => "a value is missing or lacks its quotes".into(),
        "invalid basic string" if expected == "`\"`" => "a text lacks its closing quote".into(),
        "invalid float" => "a number is malformed".into(),
        "recursion limit" => "it is nested too deeply".into(),
        _ if head.starts_with("cannot recurse") => "it is nested too deeply".into(),
        _ if head.starts_with("invalid type: integer") => {
            "a whole number has too many digits".into()
        }
        // The expected token is a term of the grammar, unless it is a character.
        _ if expected.starts_with('`') => message,
        _ => head.into(),
    };
    (line, what)
}

/// Returns a value as in a file, shortened.
fn describe(value: &Value) -> String {
    match value {
        Value::String(text) => format!("{:?}", brief(text)),
        // With its decimal point, which distinguishes it from a whole number.
        Value::Float(number) => format!("{number:?}"),
        Value::Array(_) => brief(&value.to_string()),
        Value::Table(_) => "a table".into(),
        Value::Integer(_) | Value::Boolean(_) | Value::Datetime(_) => value.to_string(),
    }
}

/// Returns the type that serde expected, in words.
fn in_words(expected: &str) -> &str {
    match expected {
        "f64" => "a number",
        "u32" => "a whole number not below 0",
        "a sequence" => "a list in square brackets",
        "a string" | "string only" => "a text in quotes",
        "a map" => "a table",
        _ if expected.starts_with("struct ") => "a table",
        _ => expected,
    }
}

/// Returns a text as one line, shortened to 60 characters.
pub fn brief(text: &str) -> String {
    const LONGEST: usize = 60;
    let text = one_line(text);
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
