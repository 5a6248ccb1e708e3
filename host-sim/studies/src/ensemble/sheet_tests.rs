//! One rule book: a first file of a family's nominal joint has the gains that its ensemble runs.

use std::f64::consts::PI;

use toml::Value;

use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use simulator::draft::{Answers, DraftStyle, text_with};
use simulator::experiment::{Document, Experiment, parameters};
use simulator::rules::{JointBounds, MotorEncoder, MoveProfile, rules};

/// Effort of a volt of the data sheet, N m/V. The gains do not depend on it.
const NM_PER_V: f64 = 12.0;

/// Names of the controllers in a first file, and of the laws whose rules they have.
const CONTROLLERS: [(&str, &str); 4] =
    [("robust", "robust"), ("srnf", "srnf"), ("both", "feedforward+srnf"), ("pd", "pd")];

/// Returns the part of a joint's bounds that a data sheet describes. The effort that holds a load
/// is measured where the joint is armed (`overhauling` and its kind), and `new` does not ask for
/// the noise of an encoder (`noisy-declared`).
fn described(bounds: &JointBounds) -> JointBounds {
    let motor_encoder = bounds.motor_encoder.map(|motor| MotorEncoder { jitter: 0.0, ..motor });
    JointBounds { hold_effort: 0.0, jitter: 0.0, motor_encoder, ..*bounds }
}

/// Returns the first file of a joint: the bounds of its friction are half of the slip and twice the
/// stick friction of its data sheet.
fn first_file(bounds: &JointBounds) -> String {
    let per_radian = NM_PER_V * 180.0 / PI;
    let [low, high] = bounds.breakaway;
    let sampled = &bounds.sampled;
    // A disc has whole lines: 37190 of the thesis's axis are 0.002420005 deg a count.
    let of_motor = bounds.motor_encoder.map_or(sampled.count, |motor| motor.count);
    let lines = (90.0 / of_motor).round() as i64;
    let at_load = bounds.encoder_at_load && bounds.motor_encoder.is_none();
    let inertia = bounds.inertia * per_radian;
    // An elastic gear has an inertia on both sides.
    let of_rotor = if bounds.encoder_at_load { 0.5 } else { 0.0 };
    let number = |value: f64| Value::Float(value);
    let word = |word: &str| Value::String(word.into());
    let mut answers = Answers::default();
    for (key, value) in [
        ("motor.driven_by", word("current")),
        ("motor.amplifier_a_per_v", number(1.0)),
        ("motor.kt_nm_per_a", number(NM_PER_V)),
        ("motor.rotor_inertia_kg_m2", number(of_rotor * inertia)),
        ("motor.current_limit_a", number(sampled.largest_effort)),
        ("gear.ratio", number(1.0)),
        ("gear.efficiency", number(1.0)),
        ("load.inertia_kg_m2", number((1.0 - of_rotor) * inertia)),
        ("friction.stick_nm", number(0.5 * high * NM_PER_V)),
        ("friction.slip_nm", number(2.0 * low * NM_PER_V)),
        ("friction.viscous_nm_s_per_rad", number(bounds.viscous * per_radian)),
        ("encoder.lines", Value::Integer(lines)),
        ("encoder.at", word(if at_load { "load" } else { "motor" })),
        ("loop.sample_time_s", number(sampled.sample_time)),
    ] {
        answers.put(key, value, "");
    }
    if bounds.encoder_at_load {
        answers.put("gear.stiffness_nm_per_rad", number(1e3), "");
    }
    if bounds.motor_encoder.is_some() {
        let counts = Value::Integer((360.0 / sampled.count).round() as i64);
        answers.put("load_encoder.counts_per_turn", counts, "");
    }
    let lsb = format!("lsb_v = {:?}\n", sampled.lsb);
    let mut style = DraftStyle { drive: lsb.leak(), ..DraftStyle::of(None) };
    if bounds.load > 0.0 {
        style.more.push(("load", "constant_nm", bounds.load * NM_PER_V, ""));
    }
    text_with("nominal", &answers, &style).unwrap()
}

#[test]
fn a_first_file_has_the_gains_of_the_ensemble_to_the_last_bit() {
    for (family, number) in Family::all().flat_map(|family| [0, 1].map(|number| (family, number))) {
        for rate_hz in [1000.0, 200.0] {
            let case =
                Case::draw(1, family, number, DrawOptions { rate_hz, ..DrawOptions::ORDINARY });
            for bounds in case.each(described) {
                let text = first_file(&bounds);
                let document = Document::parse("nominal", &text).unwrap();
                let plans = Experiment::without_variants(&document, &[]).unwrap();
                for (name, law) in CONTROLLERS {
                    let rule = rules(&[law.into()]).unwrap()[0];
                    let expected = rule.gains(&bounds);
                    let is_named = |name: &str| {
                        plans.iter().find(move |plan| plan.controller.as_deref() == Some(name))
                    };
                    let plan = is_named(name).unwrap();
                    let found = plan.controller_config().unwrap();
                    let of = format!("{} {number} at {rate_hz} Hz, {name}", family.name());
                    assert_eq!(found.pd, expected.pd, "{of}");
                    assert_eq!(found.compensator[..], expected.laws[..], "{of}");
                    assert_eq!(found.velocity_window, expected.velocity_window, "{of}");
                    let profile = parameters(plan).unwrap().profile;
                    assert_eq!(profile, MoveProfile::of(&bounds).limits, "{of}");
                }
            }
        }
    }
}
