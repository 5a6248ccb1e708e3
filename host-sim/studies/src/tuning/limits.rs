//! Limits of a tuning beside its goal: upper limits of metrics, and numbers of joints.

use std::ops::RangeInclusive;

use super::TuningFigures;
use files::error::{rounded, suggestion};
use files::typed_number;

/// Allowed number of joints in the search.
pub const CASES_ALLOWED: RangeInclusive<u64> = 1..=1000;

/// Time above which a tuning of one law is announced as long, s.
const LONG_S: f64 = 120.0;

/// Returns a sentence with the expected time of a tuning if it is long; `None` otherwise. `first_s`
/// is the time of one set of joints, s; the tuning runs about `sets` of them.
pub fn takes_long(controller: &str, first_s: f64, sets: u64, cases: u64) -> Option<String> {
    let about_s = first_s * sets as f64;
    (about_s > LONG_S).then(|| {
        format!(
            "{controller}: tuning may take some {:.0} minutes: one set of gains takes {} s on \
             {cases} joints, and it tries about {sets}; fewer --cases take less",
            (about_s / 60.0).ceil(),
            rounded(first_s)
        )
    })
}

/// Parses an upper limit of a figure, `FIGURE=MOST`.
///
/// # Errors
/// Returns the reason, without the text of the limit.
pub fn limit(text: &str) -> Result<(String, f64), String> {
    let Some((name, most)) = text.split_once('=') else {
        return Err("write FIGURE=MOST, as in chatter_v_per_s=5".into());
    };
    let name = name.trim();
    if !TuningFigures::names().contains(&name) {
        return Err(format!("there is no such figure{}", suggestion(name, TuningFigures::names())));
    }
    match typed_number::parse(most) {
        Ok(most) if most > 0.0 => Ok((name.to_owned(), most)),
        Ok(_) => Err("must be a number above 0".into()),
        Err(why) => Err(format!("must be a number above 0: {why}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tuning_of_more_than_two_minutes_is_reported_in_whole_minutes() {
        // 100 sets of 1.2 s are two minutes; of 1.23 s, a little more.
        assert_eq!(takes_long("srnf", 1.2, 100, 8), None);
        let said = takes_long("srnf", 1.23, 100, 8).unwrap();
        assert!(said.contains("srnf") && said.contains("some 3 minutes"), "{said}");
        assert!(said.contains("1.23 s on 8 joints") && said.contains("--cases"), "{said}");
    }

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
