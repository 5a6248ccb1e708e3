//! The `[spread]` of an identified joint: the range of each value in a machine's file.
//!
//! | key | range |
//! |---|---|
//! | gain | 1 / J, with the inertia J two standard deviations to either side, at least 2 % |
//! | viscous friction | two standard deviations to either side, and at least 5 % |
//! | slip friction | two standard deviations to either side, and at least 2 % |
//! | stick friction | from the least to the largest breakaway that was read, at least 2 % |
//!
//! A breakaway is the mean of both senses. The least shares cover errors of the model
//! (docs/how-to/identify.md). `draft/spread.rs` defines them, keeps slip and stick friction apart,
//! and writes the text; the identification from a log uses it as well.
//!
//! A doubt widens the range, since the error bars assume that the model holds:
//!
//! - *Few stretches*: four deviations instead of two, since Student's t at 95 % is 3.2 with three
//!   degrees of freedom.
//! - *Uneven breakaway*: n places of a uniform distribution show (n - 1)/(n + 1) of its range on
//!   average, so the stick friction is wider by r/(n - 1) to either side of the measured range r.
//!   The slip friction is wider by the same percentage of its level, since friction that depends on
//!   the angle rises and falls as a whole. The viscous friction is wider by that change of the slip
//!   friction, divided by the fastest speed of the map.
//! - *Lost motion*: a bristle, a gap or the motor alone gave way first, not the joint. So the stick
//!   friction is from one to two times the slip friction's highest value, as for the joints of
//!   docs/how-to/ensembles.md, and the inertia from half to one and a half times its value.
//!
//! The joint of the file lies within its ranges ([`inside`]).

use std::collections::BTreeMap;

use stiction::identification::{BreakawayLevels, Summary};

use super::identified::{IdentifiedJoint, doubts};
use crate::draft;
use crate::draft::spread::{LEAST, around, of_inertia, part, rounded};
use files::machine::JointTable;

/// Standard deviations to either side: in general, and with few stretches.
const DEVIATIONS: [f64; 2] = [2.0, 4.0];

/// Relative range of the inertia with lost motion: half of it can be beyond the gap.
const LOST: f64 = 0.5;

/// Largest ratio of stick to slip friction of a geared joint: that of the joints of
/// docs/how-to/ensembles.md.
const STICK_TO_SLIP: f64 = 2.0;

/// Range of each key, in the unit of the key.
pub type Ranges = BTreeMap<String, [f64; 2]>;

/// Returns the number of standard deviations to either side of an estimate.
pub(super) fn deviations(found: &IdentifiedJoint) -> f64 {
    DEVIATIONS[usize::from(found.summary.doubts.few_rows)]
}

/// Returns the `[spread]` of an identified joint; empty without an estimate.
pub fn spread(found: &IdentifiedJoint, joint: &JointTable) -> Ranges {
    let Some(estimate) = &found.summary.estimate else { return BTreeMap::new() };
    let Summary { breakaway, doubts, .. } = &found.summary;
    let [least_inertia, viscous, slip, stick] = LEAST;
    let deviations = deviations(found);
    let deviation = |value: [f32; 2]| deviations * f64::from(value[1]);
    let wider = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];

    let inertia = 1.0 / joint.gain_deg_per_s2_per_v;
    let off = of_inertia(inertia, deviation(estimate.inertia));
    let off = if doubts.lost_motion { off.max(LOST * inertia) } else { off };
    let [light, heavy] = around(inertia, off, least_inertia);

    let friction = &joint.friction;
    let mut slips = around(friction.slip_v, deviation(estimate.coulomb), slip);
    let mut viscouses = around(joint.viscous_v_per_deg_per_s, deviation(estimate.viscous), viscous);
    // The load cancels in the mean of both senses.
    let read = |of: fn(&BreakawayLevels) -> f64| breakaway.iter().map(of).sum::<f64>() / 2.0;
    let [least, largest] = [read(|of| of.least.into()), read(|of| of.largest.into())];
    let mut sticks = wider([least, largest], around(friction.stick_v, 0.0, stick));
    if doubts.uneven {
        let beyond = read(|of| f64::from(of.largest - of.least) / further(of));
        sticks = wider(sticks, [(least - beyond).max(0.0), largest + beyond]);
        let [low, high] = sticks.map(|level| level / friction.stick_v);
        slips = wider(slips, [low * friction.slip_v, high * friction.slip_v]);
        let change = (high - 1.0).max(1.0 - low) * friction.slip_v;
        let off = fastest(found).map_or(joint.viscous_v_per_deg_per_s, |speed| change / speed);
        viscouses = wider(viscouses, around(joint.viscous_v_per_deg_per_s, off, viscous));
    }
    if doubts.lost_motion {
        // The readings only show that the joint slips.
        sticks = [slips[1], sticks[1].max(STICK_TO_SLIP * slips[1])];
    } else {
        part(&mut slips, &mut sticks, [friction.slip_v, friction.stick_v]);
    }
    [
        ("joint.gain_deg_per_s2_per_v", [1.0 / heavy, 1.0 / light]),
        ("joint.viscous_v_per_deg_per_s", viscouses),
        ("joint.friction.slip_v", slips),
        ("joint.friction.stick_v", sticks),
    ]
    .map(|(key, range)| (key.to_owned(), range.map(rounded)))
    .into()
}

/// Moves the levels of a joint into their ranges. With lost motion the measured breakaway is that
/// of a part of the joint, and lies below the range of the joint's stick friction.
pub fn inside(joint: &mut JointTable, ranges: &Ranges) {
    let JointTable { gain_deg_per_s2_per_v, viscous_v_per_deg_per_s, friction } = joint;
    for (key, value) in [
        ("joint.gain_deg_per_s2_per_v", gain_deg_per_s2_per_v),
        ("joint.viscous_v_per_deg_per_s", viscous_v_per_deg_per_s),
        ("joint.friction.slip_v", &mut friction.slip_v),
        ("joint.friction.stick_v", &mut friction.stick_v),
    ] {
        if let Some([low, high]) = ranges.get(key) {
            *value = value.max(*low).min(*high);
        }
    }
}

/// Returns the number of places less one, at least 1.
fn further(levels: &BreakawayLevels) -> f64 {
    f64::from(levels.places.saturating_sub(1).max(1))
}

/// Returns the fastest speed of the map, deg/s.
fn fastest(found: &IdentifiedJoint) -> Option<f64> {
    let points = found.map.iter().flatten().filter(|point| point.windows > 0);
    points.map(|point| f64::from(point.velocity.abs())).filter(|v| *v > 0.0).reduce(f64::max)
}

/// Returns the verdict and the doubts as a table of the file.
pub fn remarks(found: &IdentifiedJoint) -> String {
    let doubted = doubts(&found.summary.doubts);
    let mut text = draft::spread::identified(found.verdict(), &doubted);
    if !doubted.is_empty() {
        text +=
            &commented("[spread] is therefore wider than the error bars (docs/how-to/identify.md)");
    }
    text
}

/// Returns a comment for a file, in lines of at most 80 columns.
pub fn commented(sentence: &str) -> String {
    let (mut text, mut line) = (String::new(), String::from("#"));
    for word in sentence.split_whitespace() {
        if line.len() + 1 + word.len() > 80 {
            text += &format!("{line}\n");
            line = "#  ".into();
        }
        line += &format!(" {word}");
    }
    text + &line + "\n"
}
