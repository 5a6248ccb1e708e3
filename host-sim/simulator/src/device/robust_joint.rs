//! Joint values of the law `robust`, set from an identification.
//!
//! | value | source |
//! |---|---|
//! | inertia, viscous friction | identified value |
//! | lowest breakaway | half of the least of: slip friction less its error bar, each breakaway |
//! | highest breakaway | twice the largest of: top of the stick friction's range, each breakaway |
//! | load | constant load and gravity, if they exceed the slip friction less its error bar |
//!
//! The factors of two are those of the rule book ([`JointBounds`]): an identification measures the
//! joint on one day, at one temperature. If the identification has doubts, the ranges of `[spread]`
//! are wider, and so is the range of the breakaway. All other gains of the law, such as its
//! bandwidth, stay, and the file lists them.
//!
//! The thresholds of the device stay, unless the identified joint would trip one of them while it
//! rests against its load. Then `breakaway_v` is raised to the identified stick friction plus load,
//! and `stall_v`, `stall_impulse_vs` and `wind_up_v` are raised in proportion.

use std::collections::BTreeMap;

use stiction::Parameters;
use stiction::control::laws::{Gains, RobustGains};
use stiction::units::value::{About, Absent, Table as _, Values as _};

use super::identified::IdentifiedJoint;
use super::spread::commented;
use crate::rules::{JointBounds, JointEstimate, SampledLoop, robust};
use files::error::rounded;
use files::machine::JointTable;

/// Returns the device's parameters with the identified joint in their law `robust`, and the comment
/// for the file that lists the changes. Without that law, the gains stay and there is no comment.
pub fn with_identified_joint(
    found: &IdentifiedJoint,
    joint: &JointTable,
    spread: &BTreeMap<String, [f64; 2]>,
) -> (Parameters, Option<String>) {
    let mut parameters = found.parameters.clone();
    let sampled = SampledLoop::of(&parameters.controller);
    let bounds = JointBounds::of(&joint_values(found, joint, spread), sampled);
    let mut remark = None;
    for law in &mut parameters.controller.compensator {
        if let Gains::Robust(gains) = law {
            let before = *gains;
            robust::set_joint(gains, &bounds);
            remark = Some(comment(&before, gains));
        }
    }
    let raised = raise_thresholds(&mut parameters, joint.friction.stick_v + load_v(found));
    if let Some(comment) = raised {
        remark = Some(remark.unwrap_or_default() + &comment);
    }
    (parameters, remark)
}

/// Ratio of the required to the configured breakaway effort above which thresholds are raised. A
/// smaller difference lies within the error bar.
const MORE: f64 = 1.05;

/// Raises the thresholds that a joint at rest under an effort (V) would trip, and returns a comment
/// about it. A threshold that is off stays off.
fn raise_thresholds(parameters: &mut Parameters, rests_v: f64) -> Option<String> {
    let Parameters { controller, limits, .. } = parameters;
    let largest = controller.drive.full_scale * controller.drive.duty_max;
    let before = limits.breakaway_effort;
    let rests: f32 = rounded(rests_v.min(largest.into())).parse().ok()?;
    if before <= 0.0 || f64::from(rests) <= MORE * f64::from(before) {
        return None;
    }
    let ratio = rests / before;
    limits.breakaway_effort = rests;
    limits.stall_effort = (limits.stall_effort * ratio).min(largest);
    limits.stall_impulse *= ratio;
    limits.wind_up_effort *= ratio;
    Some(commented(&format!(
        "`limits.breakaway_v` is raised from {} V, and `stall_v`, `stall_impulse_vs` and \
         `wind_up_v` in proportion: friction and load of the identified joint hold it at rest \
         under a larger effort.",
        rounded(before.into())
    )))
}

/// Returns the largest effort that the load of the joint needs, V: constant load and gravity.
fn load_v(found: &IdentifiedJoint) -> f64 {
    found.summary.estimate.map_or(0.0, |estimate| {
        let [sine, cosine] = estimate.gravity.map(|[value, _]| f64::from(value));
        f64::from(estimate.offset[0]).abs() + sine.hypot(cosine)
    })
}

fn joint_values(
    found: &IdentifiedJoint,
    joint: &JointTable,
    spread: &BTreeMap<String, [f64; 2]>,
) -> JointEstimate {
    let end = |key: &str, end: usize, otherwise: f64| {
        spread.get(key).and_then(|range| range.get(end)).copied().unwrap_or(otherwise)
    };
    let slip = end("joint.friction.slip_v", 0, joint.friction.slip_v);
    let stick = end("joint.friction.stick_v", 1, joint.friction.stick_v);
    let senses = &found.summary.breakaway;
    let least = senses.iter().map(|sense| f64::from(sense.least)).fold(slip, f64::min);
    let largest = senses.iter().map(|sense| f64::from(sense.largest)).fold(stick, f64::max);
    JointEstimate {
        inertia: 1.0 / joint.gain_deg_per_s2_per_v,
        viscous: joint.viscous_v_per_deg_per_s,
        friction: [least, largest],
        load: load_v(found),
        holds: slip,
    }
}

/// Returns the comment for the file: the changed values, and the unchanged values that are not
/// defaults.
fn comment(before: &RobustGains, after: &RobustGains) -> String {
    let number =
        |gains: &RobustGains, about: &About| gains.get(about.key).map_or(f32::NAN, f32::from_bits);
    let of = |holds: &dyn Fn(&About) -> bool, word: &dyn Fn(&About) -> String| {
        let chosen = RobustGains::ABOUT.iter().filter(|about| holds(about));
        chosen.map(word).collect::<Vec<_>>().join(", ")
    };
    let is_new = |about: &About| before.get(about.key) != after.get(about.key);
    let anew = of(&is_new, &|about| {
        let was = rounded(f64::from(number(before, about)));
        format!("{} (was {was})", about.name)
    });
    let is_kept = |about: &About| {
        about.absent == Absent::Default
            && !is_new(about)
            && before.get(about.key) != RobustGains::EXAMPLE.get(about.key)
    };
    let kept = of(&is_kept, &|about| about.name.to_owned());
    let mut text = if anew.is_empty() {
        commented("The joint values of `robust` agree with the identification.")
    } else {
        commented(&format!("Set from the identification, with its error bars: {anew}."))
    };
    text += &commented(
        "The breakaway range is from half of the lowest friction to twice the highest, with their \
         error bars (docs/how-to/identify.md).",
    );
    if !kept.is_empty() {
        text += &commented(&format!("Unchanged, since their values are not defaults: {kept}."));
    }
    text
}
