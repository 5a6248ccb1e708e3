//! A first file of a joint with an encoder on either side of its gear: what it configures, and
//! where its load rests.

use stiction::control::laws::Gains;
use stiction::control::motor_encoder::MotorEncoder;
use toml::Value;

use super::{Question, Typical, both_encoders};
use crate::experiment::{Experiment, RunPlan, for_a_device};
use crate::run::run;
use files::document::Document;

/// Returns that file with keys set.
fn document(set: &[&str]) -> Document {
    let mut document = Document::parse("two", &both_encoders().unwrap()).unwrap();
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
    document
}

fn plan(set: &[&str]) -> RunPlan {
    Experiment::plan(&document(set), &["robust".into()], &[]).unwrap().runs.remove(0)
}

#[test]
fn loop_counts_at_the_load_unless_the_file_chooses_the_motor() {
    let both = plan(&[]).controller_config().unwrap();
    assert_eq!(both.encoder.resolution, 360.0 / 16384.0);
    // 500 lines behind a gear of 50.
    assert_eq!(both.motor.count, 0.0036);
    // Twice: 0.3 deg of slack, twice 4.9 N m behind 1000 N m/rad, two counts of both.
    let twist = 2.0 * (0.3 + (9.8 / 1000.0_f32).to_degrees() + 2.0 * (0.0036 + 360.0 / 16384.0));
    assert!((both.motor.twist - twist).abs() < 1e-3 * twist, "{} {twist}", both.motor.twist);
    assert!(matches!(both.compensator[..], [Gains::RobustDual(_)]));
    let motor = plan(&["loop.position=motor"]).controller_config().unwrap();
    assert_eq!((motor.encoder.resolution, motor.motor), (0.0036, MotorEncoder::NONE));
    assert!(matches!(motor.compensator[..], [Gains::Robust(_)]));
}

#[test]
fn load_rests_where_its_own_encoder_closes_the_loop_and_not_behind_the_motor_s() {
    for (position, within_deg) in [("load", [0.0, 2.0 * 360.0 / 16384.0]), ("motor", [0.1, 0.4])] {
        let plan = plan(&[&format!("loop.position={position}")]);
        let result = run(&plan).unwrap();
        let counts = result.metrics.sides.rest_at_load_counts.unwrap();
        let off_deg = counts.abs() * plan.machine.count_deg();
        assert!((within_deg[0]..=within_deg[1]).contains(&off_deg), "{position}: {off_deg} deg");
        assert_eq!(result.unseen_slack.is_some(), position == "motor");
    }
}

#[test]
fn gain_of_two_encoders_is_refused_by_its_key() {
    let set = "controller.robust.motor_jitter_counts=101";
    let refused = Experiment::plan(&document(&[set]), &["robust".into()], &[]).unwrap_err();
    let message = refused.to_string();
    let expected = "`controller.robust.motor_jitter_counts` is 101; must be a number from 0 to 100";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn key_of_the_law_for_other_encoders_is_refused_and_a_default_is_not() {
    for (set, position, why) in [
        ("encoder_side=load", "load", "has no effect in a loop with two encoders"),
        ("bandwidth_rad_per_s=20", "load", "has no effect in a loop with two encoders"),
        ("motor_jitter_counts=2", "motor", "needs a `[load_encoder]` in the loop"),
    ] {
        let set = format!("controller.robust.{set}");
        let document = document(&[&set, &format!("loop.position={position}")]);
        let refused = Experiment::plan(&document, &["robust".into()], &[]).unwrap_err();
        let message = refused.to_string();
        assert!(message.contains("must be left out") && message.contains(why), "{message}");
    }
    let _ = plan(&["controller.robust.encoder_side=motor"]);
    let _ = plan(&["controller.robust.motor_jitter_counts=0", "loop.position=motor"]);
}

#[test]
fn spread_of_the_gear_widens_the_twist_that_is_tolerated() {
    let nominal = plan(&[]).controller_config().unwrap().motor;
    let spread = "\n[spread]\n\"gear.stiffness_nm_per_rad\" = [500.0, 2000.0]\n";
    let document = Document::parse("two", &(both_encoders().unwrap() + spread)).unwrap();
    let plan = Experiment::plan(&document, &["robust".into()], &[]).unwrap().runs.remove(0);
    let spread = plan.controller_config().unwrap().motor;
    // 9.8 N m behind 500 instead of 1000 N m/rad, twice.
    let more = 2.0 * (9.8 / 1000.0_f32).to_degrees();
    assert!(
        (spread.twist - nominal.twist - more).abs() < 1e-3,
        "{} {}",
        spread.twist,
        nominal.twist
    );
}

#[test]
fn device_gets_both_encoders_or_the_motor_s_alone() {
    for (position, has_both) in [("load", true), ("motor", false)] {
        let plan = plan(&[&format!("loop.position={position}")]);
        let controller = for_a_device(&plan).unwrap().controller;
        assert_eq!(controller.motor.count().is_some(), has_both);
        let counters = plan.plant().unwrap().counters();
        assert_eq!(counters.motor.is_some(), has_both, "{counters:?}");
    }
}

#[test]
fn second_encoder_is_asked_for_behind_a_gear_with_the_first_on_the_motor() {
    let question = super::QUESTIONS[Question::place("load_encoder.counts_per_turn").unwrap()];
    let mut answers = Typical::find("harmonic").unwrap().answers().unwrap();
    assert!(!answers.asks(&question));
    answers.put("gear.backlash_deg", Value::Float(0.3), "");
    assert!(answers.asks(&question) && answers.open().is_empty());
    answers.put("encoder.at", Value::String("load".into()), "");
    assert!(!answers.asks(&question));
    for (typed, expected) in [("none", "none".into()), ("16384", Value::Integer(16384))] {
        assert_eq!(question.read(typed).unwrap(), expected);
    }
    assert!(question.read("16384.5").unwrap_err().contains("or none"));
}
