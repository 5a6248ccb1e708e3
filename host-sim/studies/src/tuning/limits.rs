//! What may be asked of a tuning beside its goal: figures that are not to be exceeded, and how many
//! joints.

use std::ops::RangeInclusive;

use super::Figures;
use crate::error::suggestion;

/// How many joints gains may be looked for on.
pub const CASES_ALLOWED: RangeInclusive<u64> = 1..=1000;

/// Reads a limit, `FIGURE=MOST`.
///
/// # Errors
/// Says what is wrong with it, without naming it.
pub fn limit(text: &str) -> Result<(String, f64), String> {
    let Some((name, most)) = text.split_once('=') else {
        return Err("write FIGURE=MOST, as in chatter_v_per_s=5".into());
    };
    let name = name.trim();
    if !Figures::names().contains(&name) {
        return Err(format!("there is no such figure{}", suggestion(name, Figures::names())));
    }
    match most.trim().parse::<f64>() {
        Ok(most) if most.is_finite() && most > 0.0 => Ok((name.to_owned(), most)),
        _ => Err("allowed is a number above 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_a_figure_with_a_number_above_zero() {
        assert_eq!(limit(" held_v = 0.5 "), Ok(("held_v".into(), 0.5)));
        let refused = |text: &str| limit(text).unwrap_err();
        assert!(refused("held_v").contains("FIGURE=MOST"));
        assert!(refused("helt_v=1").contains("`held_v`"), "{}", refused("helt_v=1"));
        for number in ["0", "-1", "inf", "NaN", "some", ""] {
            assert!(refused(&format!("held_v={number}")).contains("above 0"), "{number}");
        }
    }
}
