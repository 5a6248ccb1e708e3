//! Numbers that a person types: in a terminal, as an argument, in a field of the studio.
//!
//! Every place where a number is typed reads it by these rules, so that `4,5` is the same position
//! everywhere. The studio's page has the same rules in TypeScript (`typed-number.ts`); both are
//! tested by `typed_number_cases.json`.

use crate::error::shown;

/// Reads a number that was typed where no list is possible.
///
/// A number has a sign, digits, one decimal point or comma, and an exponent; all but one digit can
/// be left out. White space around it is ignored. A comma with exactly three digits behind it is
/// refused: `1,234` is 1.234 in one country and 1234 in another.
///
/// # Errors
/// Returns one sentence with what was typed and what to type instead.
pub fn parse(typed: &str) -> Result<f64, String> {
    let typed = typed.trim();
    // U+2212 is the minus of word processors and of the studio's page.
    let plain = typed.replace('\u{2212}', "-");
    let refused = || format!("`{typed}` is not a number; type one such as -2.5");
    if typed.is_empty() {
        return Err("nothing was typed; type a number such as -2.5".into());
    }
    // Rust also reads `inf` and `nan`, which are no positions.
    if !plain.chars().all(|c| matches!(c, '0'..='9' | '+' | '-' | '.' | ',' | 'e' | 'E')) {
        return Err(refused());
    }
    let with_point = plain.replace(',', ".");
    let number: f64 = with_point.parse().map_err(|_| refused())?;
    if let Some((whole, rest)) = plain.split_once(',') {
        let digits = rest.find(['e', 'E']).unwrap_or(rest.len());
        if digits == 3 {
            // No thousands begin with a zero.
            let other = match whole.trim_start_matches(['+', '-', '0']) {
                "" => String::new(),
                _ => format!(" or {whole}{rest}"),
            };
            return Err(format!(
                "`{typed}` is ambiguous: type {with_point}{other}, without a comma"
            ));
        }
    }
    if number.is_finite() {
        Ok(number)
    } else {
        Err(format!("`{typed}` is too large; type a number below 1.8e308"))
    }
}

/// Reads a range `LOW..HIGH`, whose ends are read as [`parse`] reads a number.
///
/// # Errors
/// Returns one sentence with what was typed and what to type instead.
pub fn parse_range(typed: &str) -> Result<[f64; 2], String> {
    let typed = typed.trim();
    let ends = typed.split_once("..").map(|(low, high)| [low.trim(), high.trim()]);
    let is_end = |end: &str| !end.is_empty() && !end.contains("..");
    let Some(ends) = ends.filter(|ends| ends.iter().all(|end| is_end(end))) else {
        return Err(format!("`{typed}` is not a range; type one such as 0.15..0.4"));
    };
    let [low, high] = match ends.map(parse) {
        [Ok(low), Ok(high)] => [low, high],
        [Err(why), _] | [_, Err(why)] => return Err(format!("`{typed}`: {why}")),
    };
    if low > high {
        let [low, high] = [low, high].map(shown);
        return Err(format!("`{typed}`: the lower end comes first; type {high}..{low}"));
    }
    Ok([low, high])
}

/// Reads a number that the device takes as an `f32`, as [`parse`] does.
///
/// # Errors
/// Returns one sentence with what was typed and what to type instead.
pub fn parse_single(typed: &str) -> Result<f32, String> {
    let number = parse(typed)? as f32;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(format!("`{}` is too large; type a number below 3.4e38", typed.trim()))
    }
}

/// Returns the number of a TOML value, whole or not.
pub fn of_value(value: &toml::Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|whole| whole as f64))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{parse, parse_range, parse_single};

    #[test]
    fn a_number_that_is_too_large_for_the_device_is_refused() {
        assert_eq!(parse_single("0,02"), Ok(0.02));
        assert!(parse_single("1e39").unwrap_err().contains("`1e39` is too large"));
    }

    #[test]
    fn a_range_has_two_ends_and_a_refused_end_keeps_its_reason() {
        assert_eq!(parse_range("0.15..0.4"), Ok([0.15, 0.4]));
        assert_eq!(parse_range(" 0,15 .. 0,4 "), Ok([0.15, 0.4]));
        assert_eq!(parse_range("-30..90"), Ok([-30.0, 90.0]));
        assert_eq!(parse_range("1e-3..1e-3"), Ok([1e-3; 2]));
        for (typed, said) in [
            ("0.4..0.15", "`0.4..0.15`: the lower end comes first; type 0.15..0.4"),
            ("0.4..", "`0.4..` is not a range; type one such as 0.15..0.4"),
            ("..0.4", "`..0.4` is not a range; type one such as 0.15..0.4"),
            ("0.1..0.2..0.3", "`0.1..0.2..0.3` is not a range; type one such as 0.15..0.4"),
            ("0.1", "`0.1` is not a range; type one such as 0.15..0.4"),
            ("0,125..0,2", "`0,125..0,2`: `0,125` is ambiguous: type 0.125, without a comma"),
            ("0..nan", "`0..nan`: `nan` is not a number; type one such as -2.5"),
        ] {
            assert_eq!(parse_range(typed), Err(said.into()));
        }
    }

    #[derive(serde::Deserialize)]
    struct Case {
        typed: String,
        reads: Option<f64>,
        refused: Option<String>,
    }

    #[test]
    fn every_case_that_the_page_shares_is_read_or_refused_as_in_the_table() {
        let cases: Vec<Case> =
            serde_json::from_str(include_str!("typed_number_cases.json")).unwrap();
        assert!(cases.len() > 20);
        for Case { typed, reads, refused } in cases {
            let expected = match (reads, refused) {
                (Some(number), None) => Ok(number),
                (None, Some(why)) => Err(why),
                _ => panic!("`{typed}` needs either `reads` or `refused`"),
            };
            assert_eq!(parse(&typed), expected, "{typed:?}");
        }
    }
}
