//! Wraps text to lines of at most 80 columns.

/// Least width of a terminal, columns.
const COLUMNS: usize = 80;

/// Returns a text in lines of at most 80 columns, all indented by `indent` blanks, with a line
/// break at the end. A longer word has a line of its own.
pub fn wrapped(text: &str, indent: usize) -> String {
    let (mut lines, mut line) = (String::new(), String::new());
    for word in text.split_whitespace() {
        let width = indent + line.chars().count() + 1 + word.chars().count();
        if !line.is_empty() && width > COLUMNS {
            lines += &format!("{:indent$}{line}\n", "");
            line.clear();
        }
        line += if line.is_empty() { "" } else { " " };
        line += word;
    }
    lines + &format!("{:indent$}{line}\n", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_80_columns_at_most_and_lose_no_word() {
        let text = "seven at ".repeat(30);
        let lines = wrapped(&text, 2);
        assert!(lines.lines().all(|line| line.starts_with("  ") && line.len() <= 80), "{lines}");
        // The next word would not have fitted.
        assert!(lines.lines().rev().skip(1).all(|line| line.len() > 80 - 6), "{lines}");
        assert!(lines.split_whitespace().eq(text.split_whitespace()));
    }
}
