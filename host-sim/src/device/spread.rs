//! How far an identified joint may be off, as the `[spread]` of a machine's file.
//!
//! | key | range |
//! |---|---|
//! | gain | 1 / J, with the inertia J two standard deviations off, and at least 2 % |
//! | viscous friction | two standard deviations to either side, and at least 5 % |
//! | slip friction | two standard deviations to either side, and at least 2 % |
//! | stick friction | from the least breakaway to the largest that was read, the means of both senses, and at least 2 % |
//!
//! The floors are for what the model does not say; no error of less than a percent or two is to be
//! taken for real (docs/identification-on-the-board.md). Where the ranges of slip and stick
//! friction overlap, they meet in the middle between both: no joint slips with more than it sticks
//! with.

use std::collections::BTreeMap;

use super::identified::Identified;
use crate::machine::Joint;

/// Least share by which each of gain, viscous friction, slip and stick may be off.
const LEAST: [f64; 4] = [0.02, 0.05, 0.02, 0.02];

/// Standard deviations to either side.
const DEVIATIONS: f64 = 2.0;

/// Makes the `[spread]` of an identified joint. A joint without an estimate has none.
pub fn spread(found: &Identified, joint: &Joint) -> BTreeMap<String, [f64; 2]> {
    let Some(estimate) = &found.summary.estimate else { return BTreeMap::new() };
    let [gain, viscous, slip, stick] = LEAST;
    let deviation = |value: [f32; 2]| DEVIATIONS * f64::from(value[1]);
    let around = |value: f64, off: f64, least: f64| {
        let off = off.max(least * value);
        [(value - off).max(0.0), value + off]
    };
    let inertia = 1.0 / joint.gain_deg_per_s2_per_v;
    // An inertia that may be none at all is known to be above half of what was found.
    let [light, heavy] = around(inertia, deviation(estimate.inertia).min(0.5 * inertia), gain);
    let friction = &joint.friction;
    let mut slips = around(friction.slip_v, deviation(estimate.coulomb), slip);
    let read = |of: fn(&stiction::identification::Levels) -> f32| {
        found.summary.breakaway.iter().map(|levels| f64::from(of(levels))).sum::<f64>() / 2.0
    };
    let [least, most] = around(friction.stick_v, 0.0, stick);
    let mut sticks = [read(|of| of.least).min(least), read(|of| of.largest).max(most)];
    let middle = 0.5 * (friction.slip_v + friction.stick_v);
    if slips[1] > sticks[0] {
        (slips[1], sticks[0]) = (slips[1].min(middle), sticks[0].max(middle));
    }
    let viscous = around(joint.viscous_v_per_deg_per_s, deviation(estimate.viscous), viscous);
    [
        ("joint.gain_deg_per_s2_per_v", [1.0 / heavy, 1.0 / light]),
        ("joint.viscous_v_per_deg_per_s", viscous),
        ("joint.friction.slip_v", slips),
        ("joint.friction.stick_v", sticks),
    ]
    .map(|(key, range)| (key.to_owned(), range.map(rounded)))
    .into()
}

/// To five digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Writes the table as it stands at the end of a file.
pub fn table(spread: &BTreeMap<String, [f64; 2]>) -> String {
    let begin = "\n# How far the joint may be off, by the error bars of its identification. `tune`\n\
                 # and `device selftest` draw their joints from here.\n[spread]\n";
    let lines =
        spread.iter().map(|(key, [low, high])| format!("\"{key}\" = [{low:?}, {high:?}]\n"));
    begin.to_owned() + &lines.collect::<String>()
}
