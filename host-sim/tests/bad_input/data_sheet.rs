//! A data sheet that contradicts itself, lacks something, or describes a machine that cannot be
//! simulated.

use std::fs;

use super::refusal::{assert_all_refused, complaint};
use super::{shown, stiction};

/// A key of a typical joint that is set otherwise, and what is answered.
const CASES: &[(&str, &[&str])] = &[
    ("motor.kt_nm_per_a=0", &["`motor.kt_nm_per_a` is 0; must be a finite number above 0"]),
    ("motor.kt=1", &["unknown key `motor.kt`", "`kt_nm_per_a`?"]),
    ("motor.driven_by=volts", &["`motor.driven_by` is \"volts\"", "`voltage`?"]),
    ("motor.driven_by=current", &["`motor.amplifier_a_per_v` is missing; a motor driven"]),
    ("motor.amplifier_a_per_v=3", &["belongs to a motor driven by a current", "\"voltage\""]),
    ("motor.rotor_inertia_kg_m2=-1", &["`motor.rotor_inertia_kg_m2` is -1", "not below 0"]),
    ("motor.current_limit_a=nan", &["`motor.current_limit_a` is NaN", "a finite number above 0"]),
    ("motor.dead_time_s=0.1", &["`motor.dead_time_s` is 0.1; must be a number from 0 to 0.001"]),
    (
        "motor.thermal_time_motor_s=600",
        &["`motor.thermal_resistance_winding_k_per_w` is missing", "all four thermal keys"],
    ),
    ("motor.thermal_resistance_case_k_per_w=0", &["_case_k_per_w` is 0", "above 0"]),
    ("motor.ambient_c=25", &["`motor.thermal_resistance_winding_k_per_w` is missing"]),
    ("gear.ratio=inf", &["`gear.ratio` is inf; must be a finite number above 0"]),
    ("gear.efficiency=90", &["`gear.efficiency` is 90; must be a number above 0, up to 1"]),
    ("gear.backlash_deg=0.1", &["`gear.stiffness_nm_per_rad` is missing", "backlash"]),
    ("load.inertia_kg_m2=heavy", &["`load.inertia_kg_m2` is \"heavy\"; must be a number"]),
    ("friction.slip_nm=5", &["`friction.stick_nm` is 4.9", "not below `slip_nm` (5)"]),
    ("friction.ripple=1", &["`friction.ripple` is 1; must be a number from 0 to below 1"]),
    ("friction.ripple=0.1", &["`friction.ripple_per_turn` is missing"]),
    ("friction.stick_reverse_nm=6", &["`friction.stick_reverse_nm` is 6", "cannot be simulated"]),
    ("friction.motor_share=0.5", &["`friction.motor_share` is 0.5", "no stiffness"]),
    ("friction.bristle_stiffness_nm_per_rad=1e4", &["`friction.stribeck_rad_per_s` is missing"]),
    ("friction.bristle_damping_nm_s_per_rad=1", &["`friction.bristle_stiffness_nm_per_rad` is m"]),
    ("friction.viscous_nm_s_per_deg=1", &["are the same quantity; set only one"]),
    // 50 x 0.0909 N m/A x 12 A.
    ("friction.stick_nm=60", &["`friction.stick_nm` is 60; must be a number below 54.54"]),
    ("supply.voltage_v=0", &["`supply.voltage_v` is 0; must be a finite number above 0"]),
    ("supply.takes_current_back=1", &["`supply.takes_current_back` is 1"]),
    ("encoder.lines=0", &["`encoder.lines` is 0; must be a whole number above 0"]),
    ("encoder.lines=12.5", &["`encoder.lines` is 12.5; must be a whole number"]),
    ("encoder.at=gear", &["`encoder.at` is \"gear\"; must be one of motor, load"]),
    ("encoder.noise_counts=2", &["`encoder.noise_counts` is 2; must be 0 or 1"]),
    (
        "load_encoder.counts_per_turn=359",
        &["`load_encoder.counts_per_turn` is 359; must be a whole number from 360 to 67108864"],
    ),
    ("load_encoder.noise_counts=1", &["`load_encoder.counts_per_turn` is missing"]),
    ("loop.position=load", &["`loop.position` chooses one of two encoders", "`[load_encoder]`"]),
    ("encoder.resolution_deg=0.1", &["`encoder.resolution_deg` is 0.1", "`encoder.lines`"]),
    ("joint.friction.stick_v=0.4", &["`joint.friction.stick_v` is 0.4", "`friction.stick_nm`"]),
    ("drive.full_scale_v=24", &["`drive.full_scale_v` is 24", "`supply.voltage_v` (48)"]),
    // What follows from a key is blamed on that key.
    (
        "supply.voltage_v=1e-3",
        &["`supply.voltage_v` is 0.001 V; usual is 1 to 1000 V: the joint cannot"],
    ),
    ("motor.kt_nm_per_a=1e-9", &["`motor.kt_nm_per_a` is 1e-9 N m/A; usual is"]),
    ("drive.pwm_hz=1", &["`drive.pwm_hz` is 1; must be a number from"]),
];

#[test]
fn a_data_sheet_with_a_mistake_is_named_with_the_key() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    let made = stiction(&["new", &file, "--typical", "harmonic"]).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    assert_all_refused(CASES.iter().map(|(set, fragments)| {
        let command = stiction(&["run", &file, "--set", set]);
        ((*set).to_owned(), command, fragments.to_vec())
    }));
    // Tables that are missing.
    let text = fs::read_to_string(&file).unwrap();
    let table = |name: &str| {
        let begin = text.find(&format!("\n[{name}]")).unwrap();
        let end = text[begin + 2..].find("\n[").unwrap() + begin + 2;
        format!("{}{}", &text[..begin], &text[end..])
    };
    let without = [
        ("motor", "the table `[motor]` is missing; `[gear]` belongs to a data sheet"),
        ("load", "the table `[load]` is missing in the data sheet"),
        ("friction", "the table `[friction]` is missing in the data sheet"),
        ("supply", "the table `[supply]` is missing in the data sheet"),
    ];
    for (name, expected) in without {
        fs::write(&file, table(name)).unwrap();
        assert_eq!(complaint(stiction(&["run", &file]), &[expected]), None, "{name}");
    }
}

/// A number that follows from a data sheet is refused by the key that the user wrote.
#[test]
fn a_derived_number_out_of_its_range_is_blamed_on_what_was_written() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    assert!(stiction(&["new", &file, "--typical", "harmonic"]).output().unwrap().status.success());
    let last_line = |arguments: &[&str]| {
        let output = stiction(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap().lines().last().unwrap().to_owned()
    };
    for (set, blamed, derived) in [
        ("supply.voltage_v=1e7", "`supply.voltage_v` is 10000000 V", "`drive.full_scale_v`"),
        ("motor.kt_nm_per_a=1e6", "`motor.kt_nm_per_a` is 1000000 N m/A", "`limits.stop_gain"),
    ] {
        let said = last_line(&["params", &file, "-o", "-", "--set", set]);
        let both = said.find(blamed).zip(said.find(derived));
        assert!(both.is_some_and(|(blamed, derived)| blamed < derived), "{set}: {said}");
    }
    // A key that is usual, but was set by hand, is blamed for what follows from it; without one,
    // all from which it follows are listed.
    for (set, follows) in [
        ("motor.kt_nm_per_a=1e-4", "the motor's stall torque at the joint is"),
        ("motor.current_limit_a=1e-3", "the static friction (`friction.stick_nm`) is 4.9 N m"),
        ("motor.resistance_ohm=5e3", "the joint cannot move"),
        ("motor.kt_nm_per_a=1000", "this value leads to `limits.stop_gain_deg_per_s2_per_v`"),
    ] {
        let said = last_line(&["params", &file, "-o", "-", "--set", set]);
        assert!(said.starts_with(&format!("stiction: {set}: ")), "{set}: {said}");
        assert!(said.contains(follows), "{set}: {said}");
    }
    let text = fs::read_to_string(&file).unwrap();
    let weak = directory.path().join("weak.toml").to_str().unwrap().to_owned();
    for kt in ["1e-4", "1000.0"] {
        let line = text.lines().find(|line| line.starts_with("kt_nm_per_a = ")).unwrap();
        fs::write(&weak, text.replace(line, &format!("kt_nm_per_a = {kt}"))).unwrap();
        let said = last_line(&["params", &weak, "-o", "-"]);
        let listed = format!(
            "`motor.kt_nm_per_a` ({})",
            kt.replace("1e-4", "0.0001").trim_end_matches(".0")
        );
        assert!(said.contains("it follows from ") && said.contains(&listed), "{said}");
    }
    let other = directory.path().join("other.toml").to_str().unwrap().to_owned();
    let heavy = ["new", &other, "--typical", "harmonic", "--inertia-kg-m2", "1e12"];
    let said = last_line(&heavy);
    assert!(
        said.contains("`load.inertia_kg_m2` is 1000000000000 kg m^2; usual is")
            && said.contains("With it, `controller.robust.inertia_v_s2_per_deg` is"),
        "{said}"
    );
    // A supply in mV is shown, with a question.
    let text = fs::read_to_string(&file).unwrap().replace("voltage_v = 48", "voltage_v = 48000");
    fs::write(&file, text).unwrap();
    let shown = stiction(&["show", &file, "--units"]).output().unwrap();
    let said = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.status.success(), "{said}");
    assert!(said.contains("48000 V: are these mV? The key is in V"), "{said}");
}

#[test]
fn a_disc_without_a_data_sheet_is_refused() {
    let command = stiction(&["run", "step-response", "--set", "encoder.lines=500"]);
    let expected = ["`encoder.lines` belongs to a data sheet", "`[motor]`"];
    assert_eq!(complaint(command, &expected), None);
}

#[test]
fn an_amplifier_s_supply_is_what_it_can_give_and_no_more() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    let made = stiction(&["new", &file, "--typical", "thesis"]).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    let ohm = "motor.resistance_ohm=1";
    let cases: [(&[&str], &str); 4] = [
        (&["motor.no_load_rpm=3000"], "`supply.voltage_v` is missing; the motor's speed"),
        (
            &["supply.voltage_v=40"],
            "`motor.resistance_ohm` is missing; it limits the current of an amplifier",
        ),
        (
            &[ohm, "supply.voltage_v=40", "supply.internal_resistance_ohm=1"],
            "`supply.internal_resistance_ohm` is 1; must be 0",
        ),
        (
            &[ohm, "supply.voltage_v=40", "supply.takes_current_back=false"],
            "`supply.takes_current_back` is false; must be true",
        ),
    ];
    assert_all_refused(cases.into_iter().map(|(set, expected)| {
        let set: Vec<&str> = set.iter().flat_map(|set| ["--set", *set]).collect();
        let command = stiction(&[&["run", &file], &set[..]].concat());
        (format!("{set:?}"), command, vec![expected])
    }));
}

#[test]
fn only_a_data_sheet_has_two_systems_of_units() {
    let expected = ["show --units: step-response has no data sheet", "docs/reference/units.md"];
    assert_eq!(complaint(stiction(&["show", "--units", "step-response"]), &expected), None);
    assert_eq!(complaint(stiction(&["show", "--units", "spring-mass"]), &["no data sheet"]), None);
}

#[test]
fn what_only_a_run_simulates_is_refused_by_what_cannot() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    assert!(stiction(&["new", &file, "--typical", "gimbal"]).output().unwrap().status.success());
    let bridge = ["run", &file, "--set", "motor.dead_time_s=1e-6", "--set", "drive.mode=analog"];
    let expected = ["`motor.dead_time_s` is 1e-6; must be 0, since `drive.mode` is \"analog\""];
    assert_eq!(complaint(stiction(&bridge), &expected), None);
    let by_steps = ["run", &file, "--solver", "rk4", "--set", "load.unbalance_nm=0.01"];
    let expected = ["`run.solver` is \"rk4\"; must be \"exact\""];
    assert_eq!(complaint(stiction(&by_steps), &expected), None);
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("[supply]", "[supply]\ninternal_resistance_ohm = 0.1")).unwrap();
    let device = stiction(&["device", "--simulated", "--machine", &file, "status"]);
    assert_eq!(complaint(device, &["`supply` is simulated by `stiction run`"]), None);
}

#[test]
fn a_new_file_is_refused_by_what_is_missing_or_there() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    let all_open = [
        "missing: --driven-by, --kt-nm-per-a,",
        "--sample-time-s (or use --typical NAME: harmonic, gimbal, thesis)",
    ];
    assert_eq!(complaint(stiction(&["new", &file]), &all_open), None);
    let unknown = ["new", &file, "--typical", "gimball"];
    assert_eq!(complaint(stiction(&unknown), &["--typical gimball", "`gimbal`?"]), None);
    // An answer with which nothing can move: the error uses the terms of the sheet, and no file is
    // written.
    let stuck = ["new", &file, "--typical", "gimbal", "--stick-nm", "3"];
    assert_eq!(complaint(stiction(&stuck), &["`friction.stick_nm` is 3; must be"]), None);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    fs::write(&file, "mine").unwrap();
    let again = ["new", &file, "--typical", "gimbal"];
    assert_eq!(
        complaint(stiction(&again), &["the file exists; name another file, or add --force"]),
        None
    );
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert!(stiction(&[&again[..], &["--force"]].concat()).output().unwrap().status.success());
    assert_ne!(fs::read_to_string(&file).unwrap(), "mine");
}

/// Each answer by an option is refused by the rules of the dialogue, and no file is written.
#[test]
fn an_option_of_a_new_file_is_refused_as_its_question_is() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    assert_all_refused(
        [
            (["--stick", "0.4..0.15"], vec!["the lower end comes first; type 0.15..0.4"]),
            (["--stick-nm", "0.3..0.8"], vec!["`friction.stick_nm` is 0.8", "0.748 N m"]),
            (["--slip", "0.09"], vec!["dynamic friction (0.09 N m)", "static friction (0.08 N m)"]),
            (["--efficiency", "1.2"], vec!["`gear.efficiency`", "above 0, up to 1"]),
            (["--unbalance", "2"], vec!["gravity (2 N m)", "reduce the unbalance"]),
            (["--travel", "10..90"], vec!["both sides of 0", "-5..90"]),
            (["--stiffness", "soft"], vec!["`soft` is not a number"]),
        ]
        .into_iter()
        .map(|(option, expected)| {
            let new = ["new", &file, "--typical", "gimbal"];
            (format!("{option:?}"), stiction(&[&new[..], &option].concat()), expected)
        }),
    );
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

/// The variants and figures of a file belong to what it was copied from.
#[test]
fn what_is_left_of_the_file_that_was_copied_does_no_harm() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml").to_str().unwrap().to_owned();
    // A controller is gone that figures and a variant name.
    let text = shown("srnf-robustness")
        .replace("[controller.srnf]", "[controller.mine]\nlaws = [\"srnf\"]");
    fs::write(&file, text.replace("controller = \"srnf\"", "controller = \"mine\"")).unwrap();
    let done = stiction(&["run", &file, "--json"]).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success(), "{said}");
    let omitted =
        said.lines().filter(|line| line.contains("is left out: it sets `controller.srnf."));
    assert_eq!(omitted.count(), said.lines().count(), "{said}");
    assert!(said.contains("variant test-1 is left out"), "{said}");
    // The joint is described by a data sheet now, and a variant sets the thesis's.
    let sheet = stiction(&["new", &file, "--typical", "thesis", "--force"]).output().unwrap();
    assert!(sheet.status.success());
    let variant =
        "\n[[variant]]\nslug = \"old\"\nset = { \"joint.gain_deg_per_s2_per_v\" = 1.0 }\n";
    fs::write(&file, fs::read_to_string(&file).unwrap() + variant).unwrap();
    let done = stiction(&["run", &file]).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(
        done.status.success() && said.contains("which is derived from the data sheet"),
        "{said}"
    );
}
