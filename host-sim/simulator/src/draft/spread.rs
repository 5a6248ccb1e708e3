//! Ranges of the joint of a file: the rules that every identification shares, and the text of
//! `[identified]` and `[spread]`.
//!
//! A range is the error bar to either side, and at least a share of the value ([`LEAST`]): an error
//! below one or two percent is not credible. The error bar of an inertia is limited to half of its
//! value. If the ranges of slip and stick friction overlap, they meet in the middle between both
//! levels: the slip friction of a joint never exceeds its stick friction.

use std::fmt::Write as _;

use super::answers::Answers;
use super::range::nominal;

/// Least error of inertia, viscous friction, slip friction and stick friction, as a share of the
/// value.
pub const LEAST: [f64; 4] = [0.02, 0.05, 0.02, 0.02];

/// Returns the range of a value: the error bar to either side, or at least a share of the value;
/// not below zero.
pub fn around(value: f64, off: f64, least: f64) -> [f64; 2] {
    let off = off.max(least * value);
    [(value - off).max(0.0), value + off]
}

/// Returns the error bar of an inertia, limited to half of the inertia.
pub const fn of_inertia(inertia: f64, off: f64) -> f64 {
    off.min(0.5 * inertia)
}

/// Separates the ranges of slip and stick friction in the middle between both levels if they
/// overlap.
pub const fn part(slips: &mut [f64; 2], sticks: &mut [f64; 2], [slip, stick]: [f64; 2]) {
    let middle = 0.5 * (slip + stick);
    if slips[1] > sticks[0] {
        (slips[1], sticks[0]) = (slips[1].min(middle), sticks[0].max(middle));
    }
}

/// Rounds to five significant digits.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Writes the table `[identified]`: verdict and doubts of an identification.
pub fn identified(verdict: &str, doubts: &[impl AsRef<str>]) -> String {
    let quoted = |text: &str| toml::Value::String(text.into()).to_string();
    let mut text = format!(
        "\n# What the identification says of this joint.\n[identified]\nverdict = {}\n",
        quoted(verdict)
    );
    if !doubts.is_empty() {
        text += "doubts = [\n";
        for doubt in doubts {
            let _ = writeln!(text, "    {},", quoted(doubt.as_ref()));
        }
        text += "]\n";
    }
    text
}

/// Writes the table `[spread]` with these ranges, for the end of a file.
pub fn table<'a>(ranges: impl IntoIterator<Item = (&'a str, [f64; 2])>) -> String {
    let mut text = "\n\
        # How far the joint may be off, by the error bars of its identification. `tune`\n\
        # and `device selftest` draw their joints from here.\n\
        [spread]\n"
        .to_owned();
    for (key, range) in ranges {
        let [low, high] = range.map(rounded);
        let _ = writeln!(text, "\"{key}\" = [{low:?}, {high:?}]");
    }
    text
}

/// Key with its range, and whether the range was answered; otherwise it is assumed.
pub type KeyRange = (&'static str, [f64; 2], bool);

/// Range to either side of an inertia and a viscous friction that were answered as a single number,
/// as a share of the value: the same as `tune` assumes for a file without `[spread]`.
const ASSUMED: [(&str, f64); 2] =
    [("load.inertia_kg_m2", 0.2), ("friction.viscous_nm_s_per_rad", 0.5)];

/// Keys of the joint whose answer can be a range.
const RANGED: [&str; 7] = [
    "load.inertia_kg_m2",
    "gear.backlash_deg",
    "gear.stiffness_nm_per_rad",
    "load.unbalance_nm",
    "friction.stick_nm",
    "friction.slip_nm",
    "friction.viscous_nm_s_per_rad",
];

/// Share of the stall torque that no assumed friction exceeds.
const OF_STALL: f64 = 0.99;

/// Returns the `[spread]` of a joint if the answer to any question is a range. Each single number
/// beside it has the range that `tune` assumes: an inertia of 20 % and a viscous friction of 50 %
/// to either side, a dynamic friction from 25 % below to the middle between both levels, and a
/// static friction from there to 25 % above.
pub fn answered(answers: &Answers) -> Option<Vec<KeyRange>> {
    if !RANGED.iter().any(|key| answers.only_range(key).is_some()) {
        return None;
    }
    let [slip, stick] = ["friction.slip_nm", "friction.stick_nm"]
        .map(|key| answers.range(key).map_or(0.0, nominal));
    let middle = 0.5 * (slip + stick);
    let most = answers.stall_nm().map_or(f64::INFINITY, |stall| OF_STALL * stall);
    let assumed = |key: &str| match key {
        "friction.slip_nm" if slip > 0.0 => Some([0.75 * slip, middle]),
        "friction.stick_nm" if stick > 0.0 => Some([middle, (1.25 * stick).min(most).max(middle)]),
        _ => {
            let (_, share) = ASSUMED.iter().find(|(one, _)| *one == key)?;
            let value = answers.number(key).filter(|value| *value > 0.0)?;
            Some([value * (1.0 - share), value * (1.0 + share)])
        }
    };
    let range = |key: &&'static str| match answers.only_range(key) {
        Some(range) => Some((*key, range, true)),
        None => assumed(key).map(|range| (*key, range, false)),
    };
    Some(RANGED.iter().filter_map(range).collect())
}

/// Returns the highest static friction of the drawn joints, N m; `None` without `[spread]`.
pub fn highest_stick(answers: &Answers) -> Option<f64> {
    let ranges = answered(answers)?;
    ranges.iter().find(|(key, ..)| *key == "friction.stick_nm").map(|(_, [_, high], _)| *high)
}

/// Writes the table `[spread]` with the source of each range as a comment.
pub fn commented(ranges: Vec<KeyRange>) -> String {
    let mut text = "\n\
        # Ranges of the joint. `tune`, `ensemble` and `device selftest` draw their joints from\n\
        # here; where the dynamic friction comes out above the static one, it is lowered to it.\n\
        [spread]\n"
        .to_owned();
    for (key, range, is_answered) in ranges {
        let [low, high] = range.map(rounded);
        let line = format!("\"{key}\" = [{low:?}, {high:?}]");
        let why = if is_answered { "yours" } else { "assumed: you gave one number" };
        let _ = writeln!(text, "{line:<52} # {why}");
    }
    text
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_the_error_bar_or_the_least_share_and_friction_stays_apart() {
        assert_eq!(around(2.0, 0.5, 0.02), [1.5, 2.5]);
        assert_eq!(around(2.0, 0.01, 0.02), [1.96, 2.04]);
        assert_eq!(around(2.0, 3.0, 0.02), [0.0, 5.0]);
        assert_eq!([0.3, 3.0].map(|off| of_inertia(2.0, off)), [0.3, 1.0]);
        let parted = |mut slips: [f64; 2], mut sticks: [f64; 2]| {
            part(&mut slips, &mut sticks, [1.0, 2.0]);
            [slips, sticks]
        };
        assert_eq!(parted([0.9, 1.1], [1.8, 2.2]), [[0.9, 1.1], [1.8, 2.2]]);
        assert_eq!(parted([0.2, 1.8], [1.2, 2.8]), [[0.2, 1.5], [1.5, 2.8]]);
    }

    /// 0.15 and 0.4 N m have the geometric mean 0.2449 N m.
    #[test]
    fn one_range_brings_those_that_are_assumed_of_single_numbers() {
        use crate::draft::{QUESTIONS, Question, Typical};
        let mut answers = Typical::find("gimbal").unwrap().answers().unwrap();
        assert_eq!(answered(&answers), None);
        let stick = QUESTIONS[Question::place("friction.stick_nm").unwrap()];
        answers.put(stick.key, stick.read("0.15..0.4").unwrap(), "");
        let ranges = answered(&answers).unwrap();
        let of = |key: &str| ranges.iter().find(|(one, ..)| *one == key).unwrap();
        assert_eq!(*of("friction.stick_nm"), ("friction.stick_nm", [0.15, 0.4], true));
        for (key, expected) in [
            ("load.inertia_kg_m2", [0.004, 0.006]),
            ("friction.viscous_nm_s_per_rad", [3.5e-4, 10.5e-4]),
            ("friction.slip_nm", [0.045, 0.152_45]),
        ] {
            let (_, range, is_answered) = of(key);
            let off = [0, 1].map(|end| (range[end] / expected[end] - 1.0).abs());
            assert!(!is_answered && off.iter().all(|off| *off < 1e-6), "{key}: {range:?}");
        }
        assert_eq!(ranges.len(), 4);
    }

    #[test]
    fn a_table_is_read_as_the_ranges_that_were_written() {
        let ranges = [("load.constant_nm", [-0.1, 1.0 / 3.0]), ("friction.slip_nm", [1.0, 2.0])];
        let written: toml::Table = table(ranges).parse().unwrap();
        let end = |key: &str, end: usize| written["spread"][key][end].as_float().unwrap();
        assert_eq!([0, 1].map(|one| end("load.constant_nm", one)), [-0.1, 0.333_33]);
        assert_eq!([0, 1].map(|one| end("friction.slip_nm", one)), [1.0, 2.0]);
    }
}
