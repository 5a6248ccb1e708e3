//! How far the joint of a file may be off: the rules that every identification shares, and the text
//! of `[identified]` and `[spread]`.
//!
//! A range is the error bar to either side, and at least a share of the value ([`LEAST`]): no error
//! of less than a percent or two is to be taken for real. An inertia that may be none at all is
//! known to be above half of what was found. Where the ranges of slip and stick friction overlap,
//! they meet in the middle between both levels: no joint slips with more than it sticks with.

use std::fmt::Write as _;

/// Least share by which each of inertia, viscous friction, slip and stick may be off.
pub const LEAST: [f64; 4] = [0.02, 0.05, 0.02, 0.02];

/// The range of a value with an error bar to either side, or at least a share of it; not below
/// zero.
pub fn around(value: f64, off: f64, least: f64) -> [f64; 2] {
    let off = off.max(least * value);
    [(value - off).max(0.0), value + off]
}

/// The error bar of an inertia, of which no more than half is believed.
pub const fn of_inertia(inertia: f64, off: f64) -> f64 {
    off.min(0.5 * inertia)
}

/// Lets the ranges of slip and stick friction meet in the middle of both levels, where they
/// overlap.
pub const fn part(slips: &mut [f64; 2], sticks: &mut [f64; 2], [slip, stick]: [f64; 2]) {
    let middle = 0.5 * (slip + stick);
    if slips[1] > sticks[0] {
        (slips[1], sticks[0]) = (slips[1].min(middle), sticks[0].max(middle));
    }
}

/// To five digits.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Writes the table of what an identification says of its result.
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

/// Writes the table of the ranges as it stands at the end of a file.
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

#[cfg(test)]
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

    #[test]
    fn a_table_is_read_as_the_ranges_that_were_written() {
        let ranges = [("load.constant_nm", [-0.1, 1.0 / 3.0]), ("friction.slip_nm", [1.0, 2.0])];
        let written: toml::Table = table(ranges).parse().unwrap();
        let end = |key: &str, end: usize| written["spread"][key][end].as_float().unwrap();
        assert_eq!([0, 1].map(|one| end("load.constant_nm", one)), [-0.1, 0.333_33]);
        assert_eq!([0, 1].map(|one| end("friction.slip_nm", one)), [1.0, 2.0]);
    }
}
