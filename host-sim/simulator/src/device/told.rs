//! What `robust` is told of a joint that was identified.
//!
//! | told | from what was found |
//! |---|---|
//! | inertia, viscous friction | as found |
//! | lowest breakaway | half of the least of: slip friction less its error bar, each breakaway |
//! | highest breakaway | twice the largest of: top of the stick friction's range, each breakaway |
//! | load | constant load and gravity, if that is more than the slip friction less its bar holds |
//!
//! The factors of two are those of a first file ([`Told`]): an identification sees the joint of one
//! day, at one temperature. Where the joint is doubted, the ranges of `[spread]` are wider, and so
//! is this one. Everything else that the law was given, a bandwidth for one, stays, and the file
//! says so.
//!
//! The thresholds of the device stay, unless the joint that was found would trip one of them while it
//! rests against its load: then `breakaway_v`, and in proportion `stall_v`, `stall_impulse_vs` and
//! `wind_up_v`, are raised to the stick friction and the load that were found.

use std::collections::BTreeMap;

use stiction::Parameters;
use stiction::control::laws::{Gains, RobustGains};
use stiction::units::value::{About, Absent, Table as _, Values as _};

use super::identified::Identified;
use super::spread::commented;
use crate::draft::Told;
use crate::error::rounded;
use crate::machine::Joint;

/// Tells the `robust` of the device's parameters what was found, and says so in a comment. Without
/// that law there is nothing to tell.
pub fn retold(
    found: &Identified,
    joint: &Joint,
    spread: &BTreeMap<String, [f64; 2]>,
) -> (Parameters, Option<String>) {
    let mut parameters = found.parameters.clone();
    let told = of(found, joint, spread);
    let mut remark = None;
    for law in &mut parameters.controller.compensator {
        if let Gains::Robust(gains) = law {
            let before = *gains;
            tell(gains, &told);
            remark = Some(said(&before, gains));
        }
    }
    if let Some(said) = raise(&mut parameters, joint.friction.stick_v + load_v(found)) {
        remark = Some(remark.unwrap_or_default() + &said);
    }
    (parameters, remark)
}

/// Thresholds are raised if the joint needs more than this times as much: less is an error bar.
const MORE: f64 = 1.05;

/// Raises the thresholds under which a joint would stall that rests under an effort (V), and returns
/// a comment about it. A threshold that is off stays off.
fn raise(parameters: &mut Parameters, rests_v: f64) -> Option<String> {
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
        "`limits.breakaway_v` is raised from {} V, and with it `stall_v`, `stall_impulse_vs` and \
         `wind_up_v`: the joint that was found rests under more, against its friction and its load.",
        rounded(before.into())
    )))
}

/// Returns the largest effort that the load of the joint needs, V: constant load and gravity.
fn load_v(found: &Identified) -> f64 {
    found.summary.estimate.map_or(0.0, |estimate| {
        let [sine, cosine] = estimate.gravity.map(|[value, _]| f64::from(value));
        f64::from(estimate.offset[0]).abs() + sine.hypot(cosine)
    })
}

fn of(found: &Identified, joint: &Joint, spread: &BTreeMap<String, [f64; 2]>) -> Told {
    let end = |key: &str, end: usize, otherwise: f64| {
        spread.get(key).and_then(|range| range.get(end)).copied().unwrap_or(otherwise)
    };
    let slip = end("joint.friction.slip_v", 0, joint.friction.slip_v);
    let stick = end("joint.friction.stick_v", 1, joint.friction.stick_v);
    let senses = &found.summary.breakaway;
    let least = senses.iter().map(|sense| f64::from(sense.least)).fold(slip, f64::min);
    let largest = senses.iter().map(|sense| f64::from(sense.largest)).fold(stick, f64::max);
    let inertia = 1.0 / joint.gain_deg_per_s2_per_v;
    Told::new(inertia, joint.viscous_v_per_deg_per_s, [least, largest])
        .with_load(load_v(found), slip)
}

/// Four digits, as the first file has them: the error bars bear no more.
fn tell(gains: &mut RobustGains, told: &Told) {
    let number = |value: f64| rounded(value).parse().unwrap_or(value) as f32;
    gains.inertia = number(told.inertia);
    gains.viscous = number(told.viscous);
    [gains.breakaway_low, gains.breakaway_high] = told.breakaway.map(number);
    if told.load > 0.0 {
        gains.load = number(told.load);
    }
}

/// Says what was told anew, and what was left alone.
fn said(before: &RobustGains, after: &RobustGains) -> String {
    let number =
        |gains: &RobustGains, about: &About| gains.get(about.key).map_or(f32::NAN, f32::from_bits);
    let of = |holds: &dyn Fn(&About) -> bool, word: &dyn Fn(&About) -> String| {
        let chosen = RobustGains::ABOUT.iter().filter(|about| holds(about));
        chosen.map(word).collect::<Vec<_>>().join(", ")
    };
    let is_new = |about: &About| before.get(about.key) != after.get(about.key);
    let anew = of(&is_new, &|about| {
        let was = rounded(f64::from(number(before, about)));
        format!("{} (it was {was})", about.name)
    });
    let is_kept = |about: &About| {
        about.absent == Absent::Default
            && !is_new(about)
            && before.get(about.key) != RobustGains::EXAMPLE.get(about.key)
    };
    let kept = of(&is_kept, &|about| about.name.to_owned());
    let mut text = if anew.is_empty() {
        commented("What `robust` is told is what the identification has found.")
    } else {
        commented(&format!("From the identification, with its error bars: {anew}."))
    };
    text += &commented(
        "The breakaway is from half of the lowest friction to twice the highest, with their error \
         bars (docs/identification-on-the-board.md).",
    );
    if !kept.is_empty() {
        text += &commented(&format!("Left alone, as somebody has set them: {kept}."));
    }
    text
}
