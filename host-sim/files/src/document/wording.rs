//! What is wrong with a file, in words: what the parser and serde say, said to a person.

use toml::Value;

use crate::error::suggestion;

/// What serde found wrong with the value at a path, in one sentence.
pub fn refused(path: &str, at: Option<&Value>, message: &str) -> String {
    let message = one_line(message);
    let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent);
    let inside = |table: &str, key: &str| match table {
        "" => key.to_owned(),
        table => format!("{table}.{key}"),
    };
    // Names between back quotes: the one that was typed, then those that serde would have taken.
    let mut quoted = message.split('`').skip(1).step_by(2);
    if message.starts_with("unknown field") {
        let typed = quoted.next().unwrap_or_default();
        return format!("unknown key `{}`{}", inside(parent, typed), suggestion(typed, quoted));
    }
    if message.starts_with("duplicate field") {
        let twice = inside(if path == "." { "" } else { path }, quoted.next().unwrap_or_default());
        return format!("`{twice}` is there in two units");
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
    let found = at.map_or_else(|| "not what it should be".into(), describe);
    if message.starts_with("unknown variant") {
        let typed = quoted.next().unwrap_or_default();
        format!("`{path}` is {found}{}", suggestion(typed, quoted))
    } else if message.starts_with("invalid length") {
        let entries = at.and_then(Value::as_array).map_or(0, Vec::len);
        format!("`{path}` has {entries} entries; allowed are 2")
    } else {
        let expected = message.rsplit_once("expected ").map_or(&*message, |(_, expected)| expected);
        format!("`{path}` is {found}; allowed is {}", in_words(expected))
    }
}

/// The line at which the parser stopped, and what is wrong there.
pub fn syntax(text: &str, error: &toml::de::Error) -> (usize, String) {
    let span = error.span().unwrap_or_default();
    let line = 1 + text.bytes().take(span.start).filter(|byte| *byte == b'\n').count();
    let message = one_line(error.message());
    let (head, expected) = message.split_once(", expected ").unwrap_or((&message, ""));
    let what = match head {
        "duplicate key" => format!("`{}` is there twice", text.get(span).unwrap_or_default()),
        "string values must be quoted" => "a value is missing or lacks its quotes".into(),
        "invalid basic string" if expected == "`\"`" => "a text lacks its closing quote".into(),
        "invalid float" => "a number is malformed".into(),
        "recursion limit" => "it is nested too deeply".into(),
        _ if head.starts_with("cannot recurse") => "it is nested too deeply".into(),
        _ if head.starts_with("invalid type: integer") => {
            "a whole number has too many digits".into()
        }
        // What the parser would have taken is a term of its grammar, unless it is a character.
        _ if expected.starts_with('`') => message,
        _ => head.into(),
    };
    (line, what)
}

/// A value as a person would write it, in brief.
fn describe(value: &Value) -> String {
    match value {
        Value::String(text) => format!("{:?}", brief(text)),
        // With its point, which sets it apart from a whole number.
        Value::Float(number) => format!("{number:?}"),
        Value::Array(_) => brief(&value.to_string()),
        Value::Table(_) => "a table".into(),
        Value::Integer(_) | Value::Boolean(_) | Value::Datetime(_) => value.to_string(),
    }
}

/// What serde expected, in words.
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

/// A text in one line and not at length, since a list may be a page.
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
