//! Ranges that a user types: `0.15..0.4`, or a single number.
//!
//! The nominal of a range is the geometric mean of its ends. So both ends differ from it by the
//! same factor: for 0.15 to 0.4 N m the nominal is 0.2449 N m, and the factor is 1.63. If the lower
//! end is not above zero, there is no such factor, and the nominal is the middle. It has four
//! digits.

use files::typed_number;

/// Reads `LOW..HIGH`, or a single number for both ends.
///
/// # Errors
/// Returns one sentence with what was typed and what to type instead.
pub fn read(typed: &str) -> Result<[f64; 2], String> {
    if typed.contains("..") {
        return typed_number::parse_range(typed);
    }
    typed_number::parse(typed).map(|number| [number; 2])
}

/// Returns the nominal of a range.
pub fn nominal([low, high]: [f64; 2]) -> f64 {
    if low.to_bits() == high.to_bits() {
        return low;
    }
    let mean = if low > 0.0 { (low * high).sqrt() } else { 0.5 * (low + high) };
    format!("{mean:.3e}").parse().unwrap_or(mean)
}

/// Returns the rule of [`nominal`] for a range, in words.
pub fn rule([low, _]: [f64; 2]) -> &'static str {
    if low > 0.0 { "geometric mean" } else { "middle" }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_range_has_two_ends_in_order_or_one_number_for_both() {
        assert_eq!(read("0.15..0.4"), Ok([0.15, 0.4]));
        assert_eq!(read(" 0,15 .. 0,4 "), Ok([0.15, 0.4]));
        assert_eq!(read("-30..90"), Ok([-30.0, 90.0]));
        assert_eq!(read("0.2"), Ok([0.2, 0.2]));
        for (typed, said) in [
            ("0.4..0.15", "the lower end comes first; type 0.15..0.4"),
            ("0.4..", "is not a range; type one such as 0.15..0.4"),
            ("0.1..0.2..0.3", "is not a range"),
            ("0.1-0.2", "is not a number"),
            ("", "nothing was typed"),
        ] {
            let why = read(typed).unwrap_err();
            assert!(why.contains(said), "{typed:?}: {why}");
        }
    }

    #[test]
    fn the_nominal_is_off_by_the_same_factor_at_either_end_and_else_the_middle() {
        // sqrt(0.15 x 0.4) = 0.244949.
        assert!((nominal([0.15, 0.4]) - 0.2449).abs() < 1e-12);
        assert!((nominal([0.1, 0.9]) - 0.3).abs() < 1e-12);
        assert!((nominal([0.0, 0.5]) - 0.25).abs() < 1e-12);
        // A single number is not rounded.
        assert!((nominal([0.123_456_7; 2]) - 0.123_456_7).abs() < 1e-15);
    }
}
