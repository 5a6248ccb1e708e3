//! An SVG document as an element of an HTML page.

/// Decimals in a page: smaller differences are invisible.
const DIGITS: usize = 2;

/// Returns an SVG document as an element that scales with the page, without background, and with
/// its name for screen readers. Invisible digits of numbers are dropped, which halves the document.
pub(super) fn element(svg: &str, name: &str) -> String {
    let (head, body) = svg.split_once('>').unwrap_or(("", svg));
    let size =
        |key: &str| head.split(&format!("{key}=\"")).nth(1).and_then(|rest| rest.split('"').next());
    let (width, height) = (size("width").unwrap_or("0"), size("height").unwrap_or("0"));
    let body = body
        .split_once("/>")
        .filter(|(first, _)| first.contains("<rect"))
        .map_or(body, |(_, rest)| rest);
    let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let head = format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\">");
    let mut out = head;
    for chunk in body.split_inclusive('>') {
        // Labels keep their digits: only numbers inside a tag are rounded.
        let (label, tag) = chunk.split_at(chunk.find('<').unwrap_or(chunk.len()));
        out.push_str(label);
        out.push_str(&shorter(tag));
    }
    out
}

/// Returns a tag with its numbers rounded to [`DIGITS`] decimals.
fn shorter(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(point) = rest.find('.') {
        let is_digit = |c: char| c.is_ascii_digit();
        let before = rest[..point].trim_end_matches(is_digit).len();
        let after =
            rest[point + 1..].find(|c: char| !is_digit(c)).map_or(rest.len(), |n| point + 1 + n);
        let number = &rest[before..after];
        out.push_str(&rest[..before]);
        match number.parse::<f64>() {
            Ok(value) if after > point + 1 + DIGITS && before < point => {
                out.push_str(&rounded(value))
            }
            _ => out.push_str(number),
        }
        rest = &rest[after..];
    }
    out.push_str(rest);
    out
}

fn rounded(value: f64) -> String {
    let text = format!("{value:.DIGITS$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_their_digits() {
        let svg = "<svg width=\"9\" height=\"4\"><text x=\"1.00001\">0.00242</text></svg>";
        let expected = "<svg viewBox=\"0 0 9 4\" role=\"img\" aria-label=\"A &amp; B\"><text \
            x=\"1\">0.00242</text></svg>";
        assert_eq!(element(svg, "A & B"), expected);
    }

    #[test]
    fn numbers_are_rounded_and_everything_else_is_left_alone() {
        let text = "d=\"M 92 326.82 L 93.57000000000001 325.826 L -0.001 2.0000001\" />";
        assert_eq!(shorter(text), "d=\"M 92 326.82 L 93.57 325.83 L -0 2\" />");
    }
}
