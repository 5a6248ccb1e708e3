//! A machine's file of an identified joint, by data sheet.
//!
//! The effort of the log stands for the core's volts: `motor.amplifier_a_per_v` is 1 and
//! `motor.kt_nm_per_a` the effort gain, with the gear's ratio 1. So all that the regression found
//! is at the joint. A user who knows motor and gear writes them instead.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use toml::Value;

use super::Identified;
use super::model::Fitted;
use crate::document::Document;
use crate::draft::{Answers, Told, robust, text};
use crate::error::{Error, rounded};

/// Lines of an encoder whose counts are too fine to be seen in the log.
const ASSUMED_LINES: u32 = 4096;

/// Where the table of the law begins that is told of the joint.
const ROBUST: &str = "\n[controller.robust]";

/// Sample times of a board, s.
const SAMPLE_TIMES: [f64; 2] = [1e-4, 0.02];

/// Writes the text of a file.
///
/// # Errors
/// Says why no joint can be written.
pub fn machine_file(name: &str, log: &str, identified: &Identified) -> Result<String, Error> {
    let refuse = |why: &str| Error::Input(format!("--into {name}: {why}"));
    if identified.scale.is_linear {
        return Err(refuse(
            "the machine moves along a line, and a machine's file describes a joint that turns; \
             leave --into out",
        ));
    }
    let Some(gain) = identified.scale.effort else {
        return Err(refuse(
            "a file in N m needs what a unit of effort is; say it with --effort-gain (N m at the \
             joint for each unit)",
        ));
    };
    let fitted = &identified.fitted;
    let [forward, backward] = fitted.levels();
    let mean = 0.5 * (forward + backward);
    // A load that is stronger than the friction is no friction of either direction.
    let is_friction = forward >= 0.0 && backward >= 0.0;
    if mean < 0.0 {
        return Err(refuse("the friction comes out negative, and no joint has that"));
    }
    let slip = if is_friction { forward } else { mean };
    let stribeck = fitted.stribeck(0.0).max(0.0);
    let [b_forward, b_backward] = fitted.viscous();
    let viscous = (0.5 * (b_forward + b_backward)).max(0.0);
    let (lines, lines_from) = lines(identified);
    let number = |value: f64| Value::Float(rounded_number(value));
    let mut answers = Answers::default();
    for (key, value, source) in [
        ("motor.driven_by", Value::String("current".into()), "as the log's effort"),
        (
            "motor.amplifier_a_per_v",
            number(1.0),
            "a volt of the core is a unit of the log's effort",
        ),
        ("motor.kt_nm_per_a", number(gain.abs()), "--effort-gain, at the joint"),
        ("motor.rotor_inertia_kg_m2", number(0.0), "is in that of the load"),
        (
            "motor.current_limit_a",
            number(identified.read.top_effort / gain.abs()),
            "the largest effort of the log",
        ),
        ("gear.ratio", number(1.0), "all is at the joint"),
        ("gear.efficiency", number(1.0), "is in the friction"),
        ("load.inertia_kg_m2", number(fitted.inertia()), "identified"),
        (
            "friction.stick_nm",
            number(slip + stribeck),
            if stribeck > 0.0 { "identified" } else { "as slip: a log of motion does not tell it" },
        ),
        ("friction.slip_nm", number(slip), "identified"),
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
    let text = text(name, &answers, None)?;
    let begin = format!(
        "# Written by `stiction identify {log}`: a fit that is {}.\n# Residual {} % of the effort; \
         velocity of the free run explained by {} %.\n",
        identified.verdict.quality.word(),
        super::output::short(fitted.relative_residual_percent()),
        super::output::short(100.0 * identified.free_run.velocity_r2)
    );
    let text = text.replacen("# Written by `stiction new`. ", &format!("{begin}# "), 1);
    let text = text.replacen(
        "title = \"A joint of my own\"",
        &format!("title = {:?}", format!("Identified from {log}")),
        1,
    );
    let mut friction = String::new();
    if is_friction && rounded(forward) != rounded(backward) {
        let _ = writeln!(
            friction,
            "slip_reverse_nm = {:?}\nstick_reverse_nm = {:?}",
            rounded_number(backward),
            rounded_number(backward + stribeck)
        );
    }
    if let Some(velocity) = fitted.model.stribeck.filter(|_| stribeck > 0.0) {
        let _ = writeln!(friction, "stribeck_rad_per_s = {:?}", rounded_number(velocity));
    }
    let mut load = String::new();
    if !is_friction {
        // A constant torque on the joint is what the effort has to bear, turned round.
        let _ = writeln!(load, "constant_nm = {:?}", rounded_number(-0.5 * (forward - backward)));
    }
    if fitted.model.has_gravity {
        // g_s sin q + g_c cos q = U sin(q - q_h).
        let [sine, cosine] = ["gravity_sine", "gravity_cosine"]
            .map(|name| fitted.get(name).map_or(0.0, |found| found.value));
        let _ = writeln!(
            load,
            "unbalance_nm = {:?}\nhangs_at_rad = {:?}",
            rounded_number(sine.hypot(cosine)),
            rounded_number((-cosine).atan2(sine))
        );
    }
    let text = text.replacen("[friction]\n", &format!("[friction]\n{friction}"), 1);
    let text = text.replacen("[load]\n", &format!("[load]\n{load}"), 1);
    Ok(retold(name, text, fitted)? + &spread(fitted, slip, stribeck, viscous))
}

/// Why `robust` is told what it is told of a log.
const BY_LOG: [&str; 4] = [
    "identified",
    "identified, mean of both ways",
    "half of the lowest slip, less 2 sd",
    "twice the highest stick, plus 2 sd",
];

/// Tells `robust` the friction of both ways, with its error bars, and the load.
fn retold(name: &str, text: String, fitted: &Fitted) -> Result<String, Error> {
    let Some((sheet, mapping)) = Document::parse(name, &text)?.mapping()? else { return Ok(text) };
    let Some((before, law)) = text.split_once(ROBUST) else { return Ok(text) };
    let after = law.split_once("\n[").map_or("", |(_, after)| after);
    let by_sheet = Told::of(&sheet, &mapping);
    let [low, high] = by_sheet.breakaway.map(|level| level / mapping.volts(1.0));
    // Half of the lowest, and twice the highest. What is no more than its error bar is no zero.
    let [low_off, high_off] = off(fitted);
    let low = (low - 0.5 * low_off).max(0.5 * low);
    let breakaway = [low, high + 2.0 * high_off].map(|level| mapping.volts(level));
    Ok(format!("{before}{}\n[{after}", robust(&Told { breakaway, ..by_sheet }, &BY_LOG)))
}

/// Two standard deviations of the lower and of the upper end of the friction, N m.
fn off(fitted: &Fitted) -> [f64; 2] {
    let deviation = |name: &str| fitted.get(name).map_or(0.0, |found| found.sd);
    let slip = ["coulomb", "coulomb_positive", "coulomb_negative"].map(deviation);
    let slip = slip.into_iter().fold(0.0, f64::max);
    [2.0 * slip, 2.0 * (slip + deviation("stribeck"))]
}

/// The error bars as `[spread]`, from which `tune` draws its joints: two standard deviations, and
/// at least 2 %; of the viscous friction 5 %. A log of motion does not tell the stick friction: it
/// may be a quarter more.
fn spread(fitted: &Fitted, slip: f64, stribeck: f64, viscous: f64) -> String {
    let deviation = |name: &str| fitted.get(name).map_or(0.0, |found| 2.0 * found.sd);
    let range = |value: f64, off: f64, least: f64| {
        let off = off.max(least * value);
        [(value - off).max(0.0), value + off]
    };
    let inertia = fitted.inertia();
    let of_viscous = ["viscous", "viscous_positive", "viscous_negative"].map(deviation);
    let [slip_off, stick_off] = off(fitted);
    let stick = slip + stribeck;
    let middle = 0.5 * (slip + stick);
    let mut slips = range(slip, slip_off, 0.02);
    let is_told = stribeck > 0.0;
    let mut sticks = range(stick, stick_off, if is_told { 0.02 } else { 0.25 });
    // No joint slips with more than it sticks with.
    if !is_told {
        sticks[0] = slips[1];
    } else if slips[1] > sticks[0] {
        (slips[1], sticks[0]) = (slips[1].min(middle), sticks[0].max(middle));
    }
    // An inertia that may be none at all is known to be above half of what was found.
    let inertias = range(inertia, deviation("inertia").min(0.5 * inertia), 0.02);
    let viscouses = range(viscous, of_viscous.into_iter().fold(0.0, f64::max), 0.05);
    let mut text = "\n# How far the joint may be off, by the error bars of the fit. `tune` and\n\
        # `device selftest` draw their joints from here.\n[spread]\n"
        .to_owned();
    for (key, ends) in [
        ("load.inertia_kg_m2", inertias),
        ("friction.viscous_nm_s_per_rad", viscouses),
        ("friction.slip_nm", slips),
        ("friction.stick_nm", sticks),
    ] {
        let [low, high] = ends.map(rounded_number);
        if high > 0.0 {
            let _ = writeln!(text, "\"{key}\" = [{low:?}, {high:?}]");
        }
    }
    text
}

/// Lines of an encoder with the counts of the log, and where that is from.
fn lines(identified: &Identified) -> (u32, &'static str) {
    let lines = TAU / (4.0 * identified.read.count);
    if lines.is_finite() && (1.0..=65536.0).contains(&lines.round()) {
        (lines.round() as u32, "the smallest change of the logged position")
    } else {
        (ASSUMED_LINES, "assumed: the log's position is finer than counts")
    }
}

/// To four digits, as the standard deviations hardly bear more.
fn rounded_number(value: f64) -> f64 {
    rounded(value).parse().unwrap_or(value)
}
