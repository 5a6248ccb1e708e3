//! `stiction device identify --into` of a gear with slack and an elastic shaft, which its encoder
//! cannot see: the file keeps what was not measured, and names what the measurement contradicts.

use std::fs;
use std::process::Command;

use serde_json::Value;
use simulator::device;
use simulator::device::identified::IdentifiedJoint;
use simulator::experiment::{Document, Experiment};
use stiction::identification::IdentificationRequest;
use studies::ensemble::{drawn, identify};

/// The joint of the fixture.
const FILE: &str = "tests/joints_under_test/gear_with_backlash.toml";
const LIGHT: &str = "unbalance_nm = 0.15";

/// What the fixture says of its gear and its motor, and no identification measures; with lost
/// motion, the stick friction is among it.
const KEPT: [(&str, f64); 5] = [
    ("gear.backlash_deg", 0.6),
    ("gear.stiffness_nm_per_rad", 200.0),
    ("gear.damping_nm_s_per_rad", 0.3),
    ("motor.rotor_inertia_kg_m2", 4e-6),
    ("friction.stick_nm", 0.35),
];

fn value(of: &Document, key: &str) -> f64 {
    let value = of.get(key).unwrap_or_else(|| panic!("{key}"));
    value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
}

#[test]
fn the_file_of_a_gear_with_slack_keeps_its_slack_and_its_spread_holds_the_nominal_joint() {
    let directory = tempfile::tempdir().unwrap();
    let into = directory.path().join("found.toml").to_str().unwrap().to_owned();
    let file = directory.path().join("bl.toml").to_str().unwrap().to_owned();
    // So light that it does not fall through the slack when the device is armed, and with a monitor
    // that expects the load.
    let text = fs::read_to_string(FILE).unwrap().replace("unbalance_nm = 0.25", LIGHT);
    // Both ways stick and slip alike, and the file says so.
    let reverse = "[friction]\nstick_reverse_nm = 0.35\nslip_reverse_nm = 0.22\n";
    let text = text.replace("[friction]\n", reverse);
    fs::write(&file, text + "\n[limits]\nbreakaway_v = 1.8\n").unwrap();
    let asked = ["device", "--simulated", "--machine", &file, "identify", "--json"];
    let asked = [&asked[..], &["--into", &into]].concat();
    let found = Command::new(env!("CARGO_BIN_EXE_stiction")).args(asked).output().unwrap();
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    let found: Value = serde_json::from_slice(&found.stdout).unwrap();
    assert_eq!((&found["written"], &found["left_out"]), (&into.clone().into(), &Value::Null));
    let of = Document::open(&into).unwrap();
    for (key, truth) in KEPT {
        assert!((value(&of, key) - truth).abs() < 1e-12 * truth.abs(), "{key}: {found}");
        let kept = found["kept"].as_array().unwrap();
        assert!(kept.contains(&key.into()), "{key}: {found}");
    }
    // The measured levels hold for both ways.
    for key in ["friction.stick_reverse_nm", "friction.slip_reverse_nm"] {
        assert_eq!(of.get(key), None, "{key}: {found}");
    }
    // The gravity was measured.
    assert!((value(&of, "load.unbalance_nm") - 0.15).abs() < 0.015, "{found}");
    assert!((value(&of, "load.hangs_at_rad") + std::f64::consts::FRAC_PI_2).abs() < 0.1, "{found}");
    assert!(of.unseen_slack().unwrap().is_some_and(|slack| slack.backlash_counts > 150.0));
    // The device and the file are one joint.
    assert_eq!(found["contradicted"], Value::Array(vec![]), "{found}");
    let text = fs::read_to_string(&into).unwrap();
    let spread = of.get("spread").and_then(toml::Value::as_table).unwrap();
    assert!(spread.len() >= 4, "{text}");
    for (key, range) in spread {
        let [low, high] = [0, 1].map(|end| range[end].as_float().unwrap());
        let nominal = value(&of, key);
        assert!(low <= nominal && nominal <= high, "{key}: {nominal} in {range}: {text}");
    }
    // Rotor and load share what was measured: the load is within what two bodies bear.
    let [load, truth] = [value(&of, "load.inertia_kg_m2"), 0.02];
    assert!((0.5..2.0).contains(&(load / truth)), "{load}: {text}");
    // A joint that is drawn from the file can be simulated.
    let out = directory.path().join("tuned.toml").to_str().unwrap().to_owned();
    let tune = ["tune", &into, "--cases", "2", "--out", &out];
    let tuned = Command::new(env!("CARGO_BIN_EXE_stiction")).args(tune).output();
    let said = String::from_utf8_lossy(&tuned.unwrap().stderr).into_owned();
    assert!(!said.contains("spread") && !said.contains("allowed"), "{said}");
}

/// The joint of an ensemble has nothing to do with the fixture, so that each number is another one.
#[test]
fn what_the_identification_contradicts_is_named_with_both_numbers() {
    let text = fs::read_to_string(FILE).unwrap();
    let text = text.replace("unbalance_nm = 0.25", LIGHT).replace(LIGHT, "constant_nm = 0.0");
    let document = Document::parse("bl.toml", &text).unwrap();
    let plan = Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0);
    let of_a_joint =
        identify(&drawn("rigid", 3, 0).unwrap(), &IdentificationRequest::default()).unwrap();
    let mut summary = of_a_joint.summary.unwrap();
    let units = document.mapping().unwrap().unwrap().1.units;
    // It is braked by a third more than by the back-EMF of the file's motor, and has its inertia.
    let estimate = summary.estimate.as_mut().unwrap();
    estimate.viscous = [units.per_degree(0.305) as f32, units.per_degree(0.003) as f32];
    estimate.inertia = [units.per_degree(0.0275) as f32, units.per_degree(0.0001) as f32];
    let slip = units.effort(f64::from(estimate.coulomb[0]));
    let found = IdentifiedJoint {
        summary,
        map: of_a_joint.map,
        parameters: device::parameters(&plan).unwrap(),
        units: Some(units),
        gear: None,
    };
    let new = device::into::written(&found, &document).unwrap();
    assert_eq!(new.left_out, None);
    let named: Vec<&str> = new.contradicted.iter().map(|one| one.key.as_str()).collect();
    assert_eq!(named[..2], ["friction.viscous_nm_s_per_rad", "friction.slip_nm"], "{named:?}");
    let one = &new.contradicted[1];
    assert!((one.in_file - 0.22).abs() < 1e-12 && (one.measured / slip - 1.0).abs() < 1e-6);
    assert!(one.off >= 0.02 * slip, "{one:?}");
    let kept = "kept from bl.toml, not measured: ";
    let said = new.words.iter().find(|words| words.starts_with(kept)).unwrap();
    for part in ["gear.backlash_deg = 0.6", "gear.stiffness_nm_per_rad = 200"] {
        assert!(said.contains(part), "{said}");
    }
    let said = new.words.iter().find(|words| words.contains("friction.slip_nm")).unwrap();
    assert!(said.starts_with("contradicted: friction.slip_nm is 0.22 in bl.toml, "), "{said}");
    assert!(said.ends_with(" measured") && said.contains(" +- "), "{said}");
    // 0.0275 kg m^2 less 0.75 x 50^2 x 4e-6 of the rotor; 0.305 less 0.75 x 0.8^2 / 2.1 of the EMF.
    let of = Document::parse("found.toml", &new.text).unwrap();
    assert!((value(&of, "load.inertia_kg_m2") - 0.02).abs() < 1e-5, "{}", new.text);
    let viscous = value(&of, "friction.viscous_nm_s_per_rad");
    assert!((viscous - (0.305 - 0.75 * 0.64 / 2.1)).abs() < 1e-5, "{viscous}");
}

#[test]
fn a_range_of_the_file_that_holds_the_measured_value_narrows_the_measured_range() {
    let text = fs::read_to_string(FILE).unwrap();
    let found = |spread: &str| {
        let document = Document::parse("bl.toml", &format!("{text}\n[spread]\n{spread}\n"));
        let document = document.unwrap();
        let plan = Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0);
        let of_a_joint =
            identify(&drawn("rigid", 3, 0).unwrap(), &IdentificationRequest::default()).unwrap();
        let mut summary = of_a_joint.summary.unwrap();
        let units = document.mapping().unwrap().unwrap().1.units;
        let estimate = summary.estimate.as_mut().unwrap();
        estimate.viscous = [units.per_degree(0.305) as f32, units.per_degree(0.003) as f32];
        // Half of the inertia is within two deviations.
        estimate.inertia = [units.per_degree(0.0275) as f32, units.per_degree(0.002) as f32];
        let found = IdentifiedJoint {
            summary,
            map: of_a_joint.map,
            parameters: device::parameters(&plan).unwrap(),
            units: Some(units),
            gear: None,
        };
        let new = device::into::written(&found, &document).unwrap();
        Document::parse("found.toml", &new.text).unwrap()
    };
    let range = |of: &Document, key: &str| {
        let range = of.get("spread").unwrap()[key].clone();
        [0, 1].map(|end| range[end].as_float().unwrap())
    };
    const KEY: &str = "load.inertia_kg_m2";
    let measured = range(&found(""), KEY);
    assert!((measured[0] - 0.016).abs() < 1e-5 && (measured[1] - 0.024).abs() < 1e-5);
    let of = found("\"load.inertia_kg_m2\" = [0.018, 0.05]\n\"gear.backlash_deg\" = [0.5, 0.7]");
    assert_eq!(range(&of, KEY), [0.018, measured[1]]);
    // What was not measured is drawn as before.
    assert_eq!(range(&of, "gear.backlash_deg"), [0.5, 0.7]);
    // A range that does not hold the measured value is no knowledge of this joint.
    assert_eq!(range(&found("\"load.inertia_kg_m2\" = [0.03, 0.05]"), KEY), measured);
}
