//! `stiction device identify --into`: the joint that was found, with its error bars, as a file that
//! other commands take; and its table in SI units. The joint is simulated, so that its truth is
//! known.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use simulator::device;
use simulator::device::identified::IdentifiedJoint;
use simulator::experiment::{Document, Experiment};
use stiction::identification::IdentificationRequest;
use studies::ensemble::{drawn, identify};

use super::{number, stiction};

fn output(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap()
}

fn asked(arguments: &[&str]) -> Output {
    output(&[&["device", "--simulated"], arguments].concat())
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn path(directory: &Path, name: &str) -> String {
    directory.join(name).to_str().unwrap().to_owned()
}

/// The thesis's joint: 27 deg/s^2 per V, 0.02 V s/deg, 0.40 V to start it and 0.38 V to keep it
/// moving.
const TRUTH: [(&str, f64, f64); 4] = [
    ("joint.gain_deg_per_s2_per_v", 27.0, 0.05),
    ("joint.viscous_v_per_deg_per_s", 0.02, 0.10),
    ("joint.friction.slip_v", 0.38, 0.03),
    ("joint.friction.stick_v", 0.40, 0.03),
];

#[test]
fn the_joint_that_was_found_is_a_file_whose_spread_holds_the_truth() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "found.toml");
    let found = asked(&["identify", "--into", &file]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    assert!(words(&found.stdout).contains("found.toml: written, with the identified joint"));
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# SIMULATED DEVICE"), "{text}");
    let written: toml::Table = text.parse().unwrap();
    for (key, truth, share) in TRUTH {
        let table = toml::Value::Table(written.clone());
        let value = key.split('.').try_fold(&table, |at, part| at.get(part));
        let value = value.and_then(toml::Value::as_float).unwrap();
        assert!((value / truth - 1.0).abs() < share, "{key}: {value}, and {truth}");
        let range: Vec<f64> = written["spread"][key]
            .as_array()
            .unwrap()
            .iter()
            .map(|end| end.as_float().unwrap())
            .collect();
        assert!(range[0] <= truth && truth <= range[1], "{key}: {range:?}, and {truth}");
        assert!(range[0] <= value && value <= range[1], "{key}: {range:?}, and {value}");
        assert!(range[1] - range[0] < 0.3 * truth, "{key}: {range:?} says nothing");
    }
    let said: toml::Table = [("verdict".to_owned(), "good".into())].into_iter().collect();
    assert_eq!(written["identified"].as_table(), Some(&said));
    // Other commands take the joint, and its error bars, and have nothing to warn of.
    let run = output(&["run", &file]);
    assert!(run.status.success() && run.stderr.is_empty(), "{}", words(&run.stderr));
    let out = path(directory.path(), "tuned.toml");
    let tuned = stiction(&["tune", &file, "--cases", "2", "--out", &out]);
    let [low, high] = [0, 1].map(|end| written["spread"]["joint.friction.slip_v"][end].as_float());
    let drawn = format!("joint.friction.slip_v={:?}..{:?}", low.unwrap(), high.unwrap());
    assert!(tuned.contains(&drawn), "{tuned}");
    // Nothing is written over, and nothing moves for that.
    let again = asked(&["identify", "--into", &file]);
    assert_eq!((again.status.code(), words(&again.stdout)), (Some(2), String::new()));
    assert!(
        words(&again.stderr).contains("the file exists; name another file, or add --force"),
        "{}",
        words(&again.stderr)
    );
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
}

#[test]
fn a_sequence_that_is_not_whole_writes_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "found.toml");
    let ended = asked(&["identify", "--time", "20", "--into", &file]);
    assert_eq!(ended.status.code(), Some(2));
    let said = words(&ended.stderr);
    assert!(said.contains("nothing is written") && said.contains("--time"), "{said}");
    assert!(said.contains("the motor is off") && !Path::new(&file).exists(), "{said}");
    // Twenty seconds of motion have a result, which is reported.
    assert!(words(&ended.stdout).contains("verdict    not whole"), "{}", words(&ended.stdout));
}

/// A gear whose friction varies by 10 % to either side with the angle, of a data sheet.
#[test]
fn the_file_of_a_doubtful_joint_says_what_is_doubted_and_is_wider_than_its_error_bars() {
    let directory = tempfile::tempdir().unwrap();
    let [sheet, file] = ["joint.toml", "found.toml"].map(|name| path(directory.path(), name));
    stiction(&["new", &sheet, "--typical", "thesis"]);
    let text = fs::read_to_string(&sheet).unwrap();
    let ripple = "[friction]\nripple = 0.1\nripple_per_turn = 9\n";
    fs::write(&sheet, text.replace("[friction]\n", ripple)).unwrap();
    let found = asked(&["--machine", &sheet, "identify", "--into", &file]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    let text = fs::read_to_string(&file).unwrap();
    let (_, table) = text.split_once("[identified]").unwrap();
    let (_, comment) = table.split_once("]\n").unwrap();
    assert!(comment.lines().all(|line| line.chars().count() <= 80), "{table}");
    let written: toml::Table = text.parse().unwrap();
    let end = |end: usize| written["spread"]["friction.slip_nm"][end].as_float().unwrap();
    // The levels of the joint are 10 % off either way; the bars of a good fit are some percent.
    assert!(end(1) / end(0) > 1.1, "{table}");
    // What varies with the angle was not measured as a number, and stays.
    assert_eq!(written["friction"]["ripple"].as_float(), Some(0.1));
    let said = &written["identified"];
    assert_eq!(said["verdict"].as_str(), Some("doubtful"));
    let doubt = said["doubts"][0].as_str().unwrap();
    assert!(doubt.contains("differs by more than 15 % from place to place"), "{doubt}");
    // Commands that use this joint warn of the doubt, with and without --json.
    let moves = ["selftest", "--moves", "2", "--joints", "3", "--json"];
    let tested = asked(&[&["--machine", &file], &moves[..]].concat());
    let object: Value = serde_json::from_slice(&tested.stdout).unwrap();
    assert!(object["doubts"][0].as_str().unwrap().contains(doubt), "{object}");
    // The name of the law is refused after the file was read.
    let tuning = output(&["tune", &file, "--controller", "none"]);
    for errors in [tested.stderr, tuning.stderr] {
        let errors = words(&errors);
        let warning = format!("warning: {file}: the identification of its joint was doubtful");
        assert!(errors.contains(&warning) && errors.contains(doubt), "{errors}");
    }
}

/// A load of 0.15 of the slip friction, and one that hangs 30 deg from where the joint is armed:
/// the file of the found joint has each as its data sheet would, and others take it. Heavier ones
/// trip the monitor of the stall.
#[test]
fn a_load_that_was_found_is_in_the_file_as_a_data_sheet_has_it() {
    let angle = 30f64.to_radians();
    for (keys, truths) in [
        ("constant_nm = -30.0", &[("constant_nm", -30.0, 3.0)][..]),
        (
            "unbalance_nm = 35.0\nhangs_at_deg = 30.0",
            &[("unbalance_nm", 35.0, 3.5), ("hangs_at_rad", angle, 0.1)],
        ),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let path = |name: &str| path(directory.path(), name);
        let [sheet, file, out] = ["joint.toml", "found.toml", "tuned.toml"].map(path);
        stiction(&["new", &sheet, "--typical", "thesis"]);
        let text = fs::read_to_string(&sheet).unwrap();
        fs::write(&sheet, text.replace("[load]\n", &format!("[load]\n{keys}\n"))).unwrap();
        let of: toml::Table = fs::read_to_string(&sheet).unwrap().parse().unwrap();
        let found = asked(&["--machine", &sheet, "identify", "--into", &file]);
        assert!(found.status.success(), "{}", words(&found.stderr));
        assert!(!words(&found.stdout).contains("has no key"), "{}", words(&found.stdout));
        let text = fs::read_to_string(&file).unwrap();
        let written: toml::Table = text.parse().unwrap();
        assert!(!written.contains_key("joint") && !text.contains("has no key"), "{text}");
        let value = |table: &toml::Table, name: &str, key: &str| {
            let value = &table[name][key];
            value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
        };
        for (key, truth, off) in truths {
            let is = value(&written, "load", key);
            assert!((is - truth).abs() < *off, "{key}: {is}, and {truth}: {text}");
        }
        for (key, share) in [("slip_nm", 0.03), ("stick_nm", 0.03)] {
            let [is, was] = [&written, &of].map(|table| value(table, "friction", key));
            assert!((is / was - 1.0).abs() < share, "{key}: {is}, and {was}");
        }
        let (key, truth, _) = truths[0];
        let ends = written["spread"][&format!("load.{key}")].as_array().unwrap();
        let [low, high] = [0, 1].map(|end| ends[end].as_float().unwrap());
        assert!(low < high && (0.5..2.0).contains(&((low + high) / 2.0 / truth)), "{low} {high}");
        // What the joint is, and what it is drawn from, both have the load.
        assert!(stiction(&["show", "--units", &file]).contains(if key == "constant_nm" {
            "constant load"
        } else {
            "unbalance"
        }));
        let tuned = stiction(&["tune", &file, "--cases", "2", "--out", &out]);
        assert!(tuned.contains(&format!("load.{key}=")), "{tuned}");
    }
}

/// Joints of the ensemble are in degrees and volts, for which a machine's file has no load.
#[test]
fn a_load_without_a_key_is_in_a_comment_and_reported() {
    let document = Document::open("step-response").unwrap();
    let plan = Experiment::without_variants(&document, &["pd".into()]).unwrap().remove(0);
    let parameters = device::parameters(&plan).unwrap();
    for (family, word) in [("loaded", "a load of "), ("gravity", "gravity of ")] {
        let loads = |number: u64| {
            let case = drawn(family, 3, number).unwrap();
            identify(&case, &IdentificationRequest::default()).unwrap()
        };
        // Of those that are known well enough for a file, the first whose load is no small part.
        let found = (0..8).map(loads).find(|found| {
            let slip = found.truth.slip;
            let is_heavy = family == "gravity" || found.truth.load.abs() > 0.1 * slip;
            is_heavy && !found.is_flagged()
        });
        let found = found.unwrap();
        let truth = found.truth.load.abs();
        let found = IdentifiedJoint {
            summary: found.summary.unwrap(),
            map: found.map,
            parameters: parameters.clone(),
            units: None,
            gear: None,
        };
        let device::into::IdentifiedFile { text, left_out, .. } =
            device::into::written(&found, &document).unwrap();
        let left_out = left_out.unwrap();
        let joined = text.replace("\n#", " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(joined.contains(&left_out), "{left_out}: {text}");
        for part in ["This file has no key for it", "predictions", "a data sheet in --machine"] {
            assert!(left_out.contains(part), "{part}: {left_out}");
        }
        let said = left_out.to_lowercase();
        let (_, level) = said.split_once(word).unwrap();
        let level: f64 = level.split_once(" v").unwrap().0.parse().unwrap();
        if family == "loaded" {
            assert!((level / truth - 1.0).abs() < 0.1, "{level} V, and {truth} V");
        } else {
            assert!(level > 0.0, "{left_out}");
        }
        // The file is one all the same.
        assert!(Document::parse("found.toml", &text).unwrap().machine().is_ok(), "{text}");
    }
}

/// A bridge whose dead time takes volts from each effort: what was found has them in its friction.
#[test]
fn the_file_of_a_joint_that_was_found_does_not_count_the_dead_time_twice() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "joint.toml");
    stiction(&["new", &file, "--typical", "gimbal"]);
    let text = fs::read_to_string(&file).unwrap();
    let sheet = text.replace("[motor]\n", "[motor]\ndead_time_s = 1e-6\n");
    let document = Document::parse("joint.toml", &sheet).unwrap();
    let plan = Experiment::plan(&document, &[], &[]).unwrap().runs.remove(0);
    let parameters = device::parameters(&plan).unwrap();
    assert!((parameters.device.dead_time - 1e-6).abs() < 1e-12, "{}", parameters.device.dead_time);
    let of_a_joint =
        identify(&drawn("loaded", 3, 0).unwrap(), &IdentificationRequest::default()).unwrap();
    let mut summary = of_a_joint.summary.unwrap();
    // It is braked by more than the back-EMF of the sheet's motor.
    summary.estimate.as_mut().unwrap().viscous = [0.1, 0.001];
    let found = IdentifiedJoint {
        summary,
        map: of_a_joint.map,
        parameters: parameters.clone(),
        units: document.mapping().unwrap().map(|(_, mapping)| mapping.units),
        gear: None,
    };
    let device::into::IdentifiedFile { text, left_out, .. } =
        device::into::written(&found, &document).unwrap();
    assert_eq!(left_out, None);
    let written: toml::Table = text.parse().unwrap();
    assert!(written["motor"].get("dead_time_s").is_none(), "{text}");
    // The device has it all the same.
    let of_device = written["device"]["dead_time_s"].as_float();
    assert!(of_device.is_some_and(|time| (time - 1e-6).abs() < 1e-12), "{text}");
    let again = Document::parse("found.toml", &text).unwrap();
    let plan = Experiment::plan(&again, &[], &[]).unwrap().runs.remove(0);
    assert_eq!(device::parameters(&plan).unwrap().device, parameters.device);
}

/// The joint of a data sheet by hand: `J = J_load + eta n^2 J_rotor`, and a winding that brakes by
/// its back-EMF: `B = b + eta (n K_t)^2 / R`. A motor that is driven by its current is not braked.
/// Every typical joint is identified within the bounds by default, as
/// docs/tutorial/commission-a-joint.md has it.
#[test]
fn each_typical_joint_is_found_within_the_bounds_by_default_as_its_data_sheet_has_it() {
    for name in simulator::draft::TYPICAL.map(|typical| typical.name) {
        let directory = tempfile::tempdir().unwrap();
        let [file, into] = ["joint.toml", "found.toml"].map(|name| path(directory.path(), name));
        stiction(&["new", &file, "--typical", name]);
        let sheet: toml::Table = fs::read_to_string(&file).unwrap().parse().unwrap();
        let of = |table: &str, key: &str| {
            let value = sheet[table].get(key);
            value.map_or(0.0, |value| {
                value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
            })
        };
        let (ratio, efficiency) = (of("gear", "ratio"), of("gear", "efficiency"));
        let rotor = efficiency * ratio.powi(2) * of("motor", "rotor_inertia_kg_m2");
        let inertia = of("load", "inertia_kg_m2") + rotor;
        let braked = if sheet["motor"]["driven_by"].as_str() == Some("voltage") {
            let kt = ratio * of("motor", "kt_nm_per_a");
            efficiency * kt.powi(2) / of("motor", "resistance_ohm")
        } else {
            0.0
        };
        let viscous = of("friction", "viscous_nm_s_per_rad") + braked;
        let found = asked(&["--machine", &file, "identify", "--json", "--into", &into]);
        assert!(found.status.success(), "{name}: {}", words(&found.stderr));
        let found: Value = serde_json::from_slice(&found.stdout).unwrap();
        assert_eq!((&found["outcome"], &found["verdict"]), (&"done".into(), &"good".into()));
        assert_eq!((&found["written"], &found["left_out"]), (&into.clone().into(), &Value::Null));
        for (parameter, unit, truth, share) in [
            ("inertia", "kg m^2", inertia, 0.05),
            ("viscous", "N m s/rad", viscous, 0.10),
            ("slip", "N m", of("friction", "slip_nm"), 0.03),
        ] {
            let row = &found["si"][parameter];
            let value = number(&row["value"]);
            assert_eq!(row["unit"], unit);
            let off = (value - truth).abs();
            assert!(off < share * truth, "{name} {parameter}: {value}, and {truth} {unit}");
            // A normal error is beyond four deviations once in 16,000 times.
            assert!(off < 4.0 * number(&row["sd"]), "{name} {parameter}: {row}, and {truth}");
            // Both columns are the same number in two units: so is their relative deviation.
            let core = if parameter == "slip" { "coulomb" } else { parameter };
            let core = &found["parameters"][core];
            let relative = |of: &Value| number(&of["sd"]) / number(&of["value"]);
            assert!((relative(row) / relative(core) - 1.0).abs() < 1e-6, "{name}: {found}");
        }
        // The effort gain is the ratio of the slip level in both units.
        let per_volt = number(&found["si"]["slip"]["value"])
            / number(&found["parameters"]["coulomb"]["value"]);
        for sense in ["breakaway_positive", "breakaway_negative"] {
            let level = number(&found[sense]["median_v"]) * per_volt;
            // The object in SI has the same, with its error bar and ends.
            let row = &found["si"][sense];
            assert_eq!(row["unit"], "N m");
            for (in_si, in_volts) in
                [("value", "median_v"), ("sd", "sd_v"), ("min", "min_v"), ("max", "max_v")]
            {
                let same = number(&row[in_si]) / (number(&found[sense][in_volts]) * per_volt);
                assert!((same - 1.0).abs() < 1e-5, "{name} {sense} {in_si}: {found}");
            }
            let share = level / of("friction", "stick_nm");
            assert!((share - 1.0).abs() < 0.03, "{name} {sense}: {level} N m");
        }
        // The law gets this joint, and the range includes all measured levels: half of the
        // least slip friction or breakaway, twice the largest breakaway, and their error bars.
        let sheet = &sheet["controller"]["robust"];
        let written: toml::Table = fs::read_to_string(&into).unwrap().parse().unwrap();
        let law = &written["controller"]["robust"];
        for (key, share) in [("inertia_v_s2_per_deg", 0.05), ("viscous_v_s_per_deg", 0.10)] {
            let [was, is] = [sheet, law].map(|table| table[key].as_float().unwrap());
            assert!((is / was - 1.0).abs() < share, "{name} {key}: {was} and {is}");
        }
        let read = |end: &str| {
            ["breakaway_positive", "breakaway_negative"].map(|sense| number(&found[sense][end]))
        };
        let slip = number(&found["parameters"]["coulomb"]["value"]);
        let least = read("min_v").into_iter().fold(slip, f64::min);
        let largest = read("max_v").into_iter().fold(0.0, f64::max);
        let of = |key: &str| law[key].as_float().unwrap();
        let [low, high] = [of("breakaway_low_v") / least, of("breakaway_high_v") / largest];
        assert!((0.45..0.5).contains(&low), "{name}: {low} of {least} V");
        assert!((2.0..2.2).contains(&high), "{name}: {high} of {largest} V");
    }
}

/// The joint differs from the one in the device's file: the law gets the identified joint, and keys
/// set by the user stay.
#[test]
fn robust_gets_the_identified_joint_and_keeps_the_keys_set_by_the_user() {
    let directory = tempfile::tempdir().unwrap();
    let [file, into] = ["joint.toml", "found.toml"].map(|name| path(directory.path(), name));
    stiction(&["new", &file, "--typical", "thesis"]);
    // The device is configured with half of the inertia and a third of the friction, and a
    // bandwidth.
    let text = fs::read_to_string(&file).unwrap();
    let table: toml::Table = text.parse().unwrap();
    let truth = |key: &str| table["controller"]["robust"][key].as_float().unwrap();
    let mut wrong = text.clone();
    for (key, factor) in [
        ("inertia_v_s2_per_deg", 0.5),
        ("viscous_v_s_per_deg", 0.5),
        ("breakaway_low_v", 0.3),
        ("breakaway_high_v", 0.7),
    ] {
        let line = format!("{key} = {:?}", truth(key));
        assert!(wrong.contains(&line), "{line}: {wrong}");
        wrong = wrong.replace(&line, &format!("{key} = {:?}", factor * truth(key)));
    }
    let own = "[controller.robust]\nbandwidth_rad_per_s = 6.5\nleast_gain = 0.2";
    fs::write(&file, wrong.replace("[controller.robust]", own)).unwrap();
    let found = asked(&["--machine", &file, "identify", "--into", &into]);
    assert!(found.status.success(), "{}", words(&found.stderr));
    let text = fs::read_to_string(&into).unwrap();
    let written: toml::Table = text.parse().unwrap();
    let law = |key: &str| written["controller"]["robust"][key].as_float().unwrap();
    assert!((law("inertia_v_s2_per_deg") / truth("inertia_v_s2_per_deg") - 1.0).abs() < 0.02);
    assert!((law("viscous_v_s_per_deg") / truth("viscous_v_s_per_deg") - 1.0).abs() < 0.05);
    // Half of 0.38 V and twice 0.40 V, and no less wide than these; the error bars are 2 %.
    let [low, high] = ["breakaway_low_v", "breakaway_high_v"].map(law);
    assert!((0.95 * 0.19..0.19).contains(&low), "{low}");
    assert!((0.80..1.05 * 0.80).contains(&high), "{high}");
    assert_eq!((law("bandwidth_rad_per_s"), law("least_gain")), (6.5, 0.2));
    // The file says where the numbers are from, and what was left alone.
    let (head, _) = text.split_once("[controller.robust]").unwrap();
    let (_, comment) = head.rsplit_once("\n\n").unwrap();
    let joined = comment.replace("\n#", " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(joined.contains("Set from the identification"), "{head}");
    assert!(joined.contains("inertia_v"), "{head}");
    let kept = joined.split_once("Unchanged").map(|(_, kept)| kept).unwrap_or_default();
    assert!(kept.contains("bandwidth_rad_per_s") && kept.contains("least_gain"), "{head}");
    assert!(!kept.contains("jitter"), "{head}");
    assert!(comment.lines().all(|line| line.chars().count() <= 80), "{comment}");
}

#[test]
fn a_bound_of_the_speed_at_which_the_encoder_shows_nothing_is_refused_before_anything_moves() {
    let directory = tempfile::tempdir().unwrap();
    let file = path(directory.path(), "joint.toml");
    stiction(&["new", &file, "--typical", "gimbal"]);
    let slow = asked(&["--machine", &file, "identify", "--speed", "10"]);
    let said = words(&slow.stderr);
    assert_eq!(slow.status.code(), Some(2), "{said}");
    // 2 * 3 * 20 rad/s * 0.1125 deg / 0.7 = 19.3 deg/s.
    assert!(
        said.contains("a speed of 22 deg/s or more") && said.contains("Nothing has moved"),
        "{said}"
    );
}
