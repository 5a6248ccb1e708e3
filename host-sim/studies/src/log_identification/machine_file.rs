//! Machine's file of a joint that was identified from a log, as a data sheet.
//!
//! The effort of the log replaces the core's volts: `motor.amplifier_a_per_v` is 1,
//! `motor.kt_nm_per_a` is the effort gain, and the gear's ratio is 1. So all identified values are
//! at the joint. A user who has the data of motor and gear replaces these values.

use std::f64::consts::TAU;

use toml::Value;

use super::IdentifiedMachine;
use super::model::FittedModel;
use files::data_sheet::resting_torque;
use files::error::{Error, rounded};
use simulator::draft::spread::{
    LEAST, around, identified as said, of_inertia, part, rounded as digits, table,
};
use simulator::draft::{Answers, DraftStyle, Sources, text_with};
use simulator::rules::JointEstimate;

/// Assumed lines of an encoder whose counts are too fine to show in the log.
const ASSUMED_LINES: u32 = 4096;

/// Relative range of a stick friction that the log does not identify.
const UNIDENTIFIED: f64 = 0.25;

/// Range of sample times of a board, s.
const SAMPLE_TIMES: [f64; 2] = [1e-4, 0.02];

/// Returns the text of the machine's file.
///
/// # Errors
/// Returns why the joint cannot be written.
pub fn machine_file(
    name: &str,
    log: &str,
    identified: &IdentifiedMachine,
) -> Result<String, Error> {
    let refuse = |why: &str| Error::Input(format!("--into {name}: {why}"));
    if identified.scale.is_linear {
        return Err(refuse(
            "the machine moves along a line, but a machine's file describes a rotary joint; leave \
             --into out",
        ));
    }
    let Some(gain) = identified.scale.effort else {
        return Err(refuse(
            "the unit of the effort is unknown, and the file is in N m; set --effort-gain (N m at \
             the joint for each unit)",
        ));
    };
    let fitted = &identified.fitted;
    let [forward, backward] = fitted.levels();
    let slip = 0.5 * (forward + backward);
    if slip < 0.0 {
        return Err(refuse("the identified friction is negative, which is impossible"));
    }
    // The load has the opposite sign of the effort that holds it.
    let constant = if rounded(forward) == rounded(backward) { 0.0 } else { backward - slip };
    let stribeck = fitted.stribeck(0.0).max(0.0);
    let [b_forward, b_backward] = fitted.viscous();
    let viscous = (0.5 * (b_forward + b_backward)).max(0.0);
    // Without a Stribeck term, the stick friction is the upper end of the slip friction's range.
    let (stick, stick_from) = if stribeck > 0.0 {
        (rounded_number(slip + stribeck), "identified")
    } else {
        let [_, most] = around(slip, off(fitted).mean, LEAST[2]);
        (digits(most), "slip + 2 sd: not in a log of motion")
    };
    let (lines, lines_from) = lines(identified);
    let number = |value: f64| Value::Float(rounded_number(value));
    let mut answers = Answers::default();
    for (key, value, source) in [
        ("motor.driven_by", Value::String("current".into()), "like the log's effort"),
        (
            "motor.amplifier_a_per_v",
            number(1.0),
            "a volt of the core is a unit of the log's effort",
        ),
        ("motor.kt_nm_per_a", number(gain.abs()), "--effort-gain, at the joint"),
        ("motor.rotor_inertia_kg_m2", number(0.0), "included in that of the load"),
        (
            "motor.current_limit_a",
            number(identified.read.top_effort / gain.abs()),
            "the largest effort of the log",
        ),
        ("gear.ratio", number(1.0), "all values are at the joint"),
        ("gear.efficiency", number(1.0), "included in the friction"),
        ("load.inertia_kg_m2", number(fitted.inertia()), "identified"),
        ("friction.stick_nm", Value::Float(stick), stick_from),
        ("friction.slip_nm", number(slip), "identified, mean of both ways"),
        ("friction.viscous_nm_s_per_rad", number(viscous), "identified, mean of both ways"),
        ("encoder.lines", Value::Integer(lines.into()), lines_from),
        ("encoder.at", Value::String("load".into()), ""),
        (
            "loop.sample_time_s",
            number(identified.read.sample_time_s.clamp(SAMPLE_TIMES[0], SAMPLE_TIMES[1])),
            "of the log",
        ),
    ] {
        answers.put(key, value, source);
    }
    let begin = format!(
        "# Written by `stiction identify {log}`: a fit that is {}.\n# Residual {} % of the effort. \
         A simulation with the logged effort explains\n# {} % of the velocity's variance.\n# ",
        identified.verdict.quality.word(),
        super::output::short(fitted.relative_residual_percent()),
        super::output::short(100.0 * identified.free_run.velocity_r2)
    );
    // g_s sin q + g_c cos q = U sin(q - q_h).
    let [sine, cosine] = ["gravity_sine", "gravity_cosine"]
        .map(|name| fitted.get(name).map_or(0.0, |found| found.value));
    let mut more = Vec::new();
    if let Some(velocity) = fitted.model.stribeck.filter(|_| stribeck > 0.0) {
        more.push(("friction", "stribeck_rad_per_s", velocity, "identified"));
    }
    if constant != 0.0 {
        let why = "identified: half of the difference between both ways";
        more.push(("load", "constant_nm", constant, why));
        let starts = resting_torque(stick, constant, sine.hypot(cosine)) / gain.abs();
        let why = if fitted.model.has_gravity {
            "stick friction, constant load and unbalance"
        } else {
            "stick friction and constant load"
        };
        more.push(("limits", "breakaway_v", starts, why));
    }
    if fitted.model.has_gravity {
        more.push(("load", "unbalance_nm", sine.hypot(cosine), "identified"));
        more.push(("load", "hangs_at_rad", (-cosine).atan2(sine), "identified"));
    }
    more.iter_mut().for_each(|(_, _, value, _)| *value = rounded_number(*value));
    let volts = |torque: f64| torque / gain.abs();
    // If the load exceeds the friction, the levels of the two directions are not friction levels.
    let is_held = constant.abs() < slip;
    let [low, high] =
        if is_held { [forward.min(backward), forward.max(backward)] } else { [slip; 2] };
    let off = off(fitted);
    // A level within its error bar does not become zero.
    let ends = [(low - off.slip).max(0.5 * low), high + stribeck + off.stick].map(volts);
    let joint = JointEstimate {
        inertia: volts(fitted.inertia()).to_radians(),
        viscous: volts(viscous).to_radians(),
        friction: ends,
        load: volts(constant.abs() + sine.hypot(cosine)),
        holds: volts(slip),
    };
    let style = DraftStyle {
        begin,
        title: format!("Identified from {log}"),
        more,
        joint: Some((joint, BY_LOG)),
        ..DraftStyle::of(None)
    };
    let verdict = &identified.verdict;
    Ok(text_with(name, &answers, &style)?
        + &said(verdict.quality.word(), &verdict.doubts)
        + &spread(fitted, [slip, stribeck, viscous, constant], &off))
}

/// Comments on the joint values of `robust` from a log.
const BY_LOG: Sources = [
    "identified",
    "identified, mean of both ways",
    "half of: lowest slip - 2 sd",
    "twice: highest stick + 2 sd",
];

/// Error bars of the friction: two standard deviations, N m.
struct Off {
    /// Slip friction of one way; includes the error of the constant load.
    slip: f64,
    stick: f64,
    /// Mean slip friction of both ways.
    mean: f64,
    load: f64,
}

/// Returns the error bars of the friction.
fn off(fitted: &FittedModel) -> Off {
    let deviation = |name: &str| fitted.get(name).map_or(0.0, |found| 2.0 * found.sd);
    let parameters = fitted.parameters();
    let load = parameters.iter().find(|(name, _)| *name == "offset");
    let load = load.map_or(0.0, |(_, offset)| 2.0 * offset.sd);
    let ways = ["coulomb_positive", "coulomb_negative"].map(deviation);
    let larger = ways[0].max(ways[1]);
    let [slip, mean] = if fitted.model.is_asymmetric {
        [larger; 2]
    } else {
        [deviation("coulomb").hypot(load), deviation("coulomb")]
    };
    Off { slip, stick: slip + deviation("stribeck"), mean, load }
}

/// Returns the error bars as `[spread]`, from which `tune` draws its joints. A log of motion does
/// not identify the stick friction; its range extends by a quarter.
fn spread(
    fitted: &FittedModel,
    [slip, stribeck, viscous, constant]: [f64; 4],
    off: &Off,
) -> String {
    let deviation = |name: &str| fitted.get(name).map_or(0.0, |found| 2.0 * found.sd);
    let [least_inertia, least_viscous, least_slip, least_stick] = LEAST;
    let inertia = fitted.inertia();
    let inertias = around(inertia, of_inertia(inertia, deviation("inertia")), least_inertia);
    let of_viscous = ["viscous", "viscous_positive", "viscous_negative"].map(deviation);
    let of_viscous = of_viscous.into_iter().fold(0.0, f64::max);
    let stick = slip + stribeck;
    let mut slips = around(slip, off.mean, least_slip);
    let has_stick = stribeck > 0.0;
    let of_stick = off.mean + deviation("stribeck");
    let mut sticks = around(stick, of_stick, if has_stick { least_stick } else { UNIDENTIFIED });
    if has_stick {
        part(&mut slips, &mut sticks, [slip, stick]);
    } else {
        // The stick friction of a joint is not below its slip friction.
        sticks[0] = slips[1];
    }
    let frictions = [
        ("load.inertia_kg_m2", inertias),
        ("friction.viscous_nm_s_per_rad", around(viscous, of_viscous, least_viscous)),
        ("friction.slip_nm", slips),
        ("friction.stick_nm", sticks),
    ];
    let load = (constant != 0.0)
        .then_some(("load.constant_nm", [constant - off.load, constant + off.load]));
    table(frictions.into_iter().filter(|(_, [_, high])| *high > 0.0).chain(load))
}

/// Returns the lines of an encoder with the counts of the log, and the source of the number.
fn lines(identified: &IdentifiedMachine) -> (u32, &'static str) {
    let lines = TAU / (4.0 * identified.read.count);
    if lines.is_finite() && (1.0..=65536.0).contains(&lines.round()) {
        (lines.round() as u32, "the smallest change of the logged position")
    } else {
        (ASSUMED_LINES, "assumed: the log's position is finer than counts")
    }
}

/// Rounds to four digits; the standard deviations are larger than that rounding.
fn rounded_number(value: f64) -> f64 {
    rounded(value).parse().unwrap_or(value)
}
