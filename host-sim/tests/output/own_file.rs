//! A user's own machine file has a controller of its own.

use std::fs;
use std::process::Command;

use super::{labels, run, stiction};

#[test]
fn a_user_s_own_controller_adds_its_laws() {
    let own = r#"
        [joint]
        gain_deg_per_s2_per_v = 27.0
        viscous_v_per_deg_per_s = 0.02
        friction = { stick_v = 0.40, slip_v = 0.38 }
        [encoder]
        resolution_deg = 0.00242
        counter_bits = 16
        [drive]
        full_scale_v = 5.0
        lsb_v = 0.00488
        pwm_hz = 22000.0
        mode = "sign-magnitude"
        [loop]
        sample_time_s = 0.02
        controller = "mine"
        [controller.mine]
        laws = ["feedforward", "srnf"]
        kp_v_per_deg = 1.0
        kd_v_per_deg_per_s = 0.25
        v_slip_v = 0.37
        v_ff_deg_per_s = 0.001
        v_ms_v = 0.05
        alpha_per_deg = 100
        [[reference.trajectories]]
        corner_times_s = [1, 11]
        corner_positions_deg = [0, 50]
        half_blend_s = 0.25
    "#;
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let v_c_at_5_s = |laws: &str| {
        fs::write(file("my joint.toml"), own.replace("\"feedforward\", \"srnf\"", laws)).unwrap();
        let report = run(&[&file("my joint.toml"), "--csv", &file("run.csv")]);
        assert_eq!(labels(&report), ["mine/trajectory-5.0"]);
        assert_eq!(report["experiment"], file("my joint.toml"));
        let csv = fs::read_to_string(file("run.csv")).unwrap();
        let cells: Vec<&str> = csv.lines().nth(1 + 250).unwrap().split(',').collect();
        assert_eq!(cells[0], "5.0");
        cells[6].parse::<f64>().unwrap()
    };
    // In motion the feedforward gives v_slip; SRNF some of its 0.05 V, more where the error is
    // large.
    assert_eq!(v_c_at_5_s("\"feedforward\""), 0.37);
    assert_eq!(v_c_at_5_s("\"srnf\""), 0.05);
    assert_eq!(v_c_at_5_s(""), 0.0);
    let both = v_c_at_5_s("\"feedforward\", \"srnf\"");
    assert!(both > 0.38 && both <= 0.42, "{both} V");
}

/// Of a file whose `[spread]` says how far its joint may be off, `ensemble` asks what `tune` does.
#[test]
fn an_ensemble_around_a_file_draws_from_its_spread_and_warns_of_joints_that_are_all_alike() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let text = stiction(&["show", "step-response"]);
    fs::write(path("plain.toml"), &text).unwrap();
    let spread = "\n[spread]\n\"joint.friction.slip_v\" = [0.30, 0.39]\n";
    fs::write(path("spread.toml"), text + spread).unwrap();
    let rests = |file: &str, more: &[&str]| {
        let (file, csv) = (path(file), path("rows.csv"));
        let asked = ["ensemble", "--plant", &file, "--controller", "pd", "--cases", "3"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
        let done = command.args(asked).args(["--csv", &csv]).args(more).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let rows = fs::read_to_string(csv).unwrap();
        let (_, table) = rows.split_once('\n').unwrap();
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let column = reader.headers().unwrap().iter().position(|name| name == "rest_counts");
        let cell = |row: Result<csv::StringRecord, _>| row.unwrap()[column.unwrap()].to_owned();
        let rests: Vec<String> = reader.records().map(cell).collect();
        (rests, String::from_utf8(done.stderr).unwrap())
    };
    let (alike, said) = rests("plain.toml", &[]);
    assert!(alike[0] == alike[1] && alike[1] == alike[2], "{alike:?}");
    assert!(said.contains("warning") && said.contains("nothing varies"), "{said}");
    let (drawn, said) = rests("spread.toml", &[]);
    assert!(drawn[0] != drawn[1] && said.is_empty(), "{drawn:?} {said}");
    // What is given takes the place of what is written.
    let given = ["--spread", "joint.friction.slip_v=0.38..0.38"];
    assert_eq!(rests("spread.toml", &given).0, alike);
}
