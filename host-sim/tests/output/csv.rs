//! The columns and rows of `--csv`.

use std::fs;

use stiction::control::signal::SIGNALS;

use super::stiction;

/// The columns that scripts rely on.
const LEADING: &str = "time_s,reference_deg,position_deg,error_deg,velocity_deg_per_s,v_pd_v,\
    v_c_v,v_v,code,stuck,v_applied_v";

/// The columns that scripts rely on, then every other signal of the core.
fn columns() -> String {
    let others = SIGNALS.iter().map(|signal| signal.name);
    let others = others.filter(|name| !["current_a", "motor_counts"].contains(name));
    let others = others.filter(|name| LEADING.split(',').all(|column| column != *name));
    [LEADING].into_iter().chain(others).collect::<Vec<_>>().join(",")
}

#[test]
fn csv_has_a_line_a_sample_under_the_documented_header() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    let file = path.to_str().unwrap();
    let csv = |arguments: &[&str]| {
        stiction(&[&["run", "--csv", file], arguments].concat());
        fs::read_to_string(&path).unwrap()
    };
    let columns = columns();
    let width = columns.split(',').count();
    // Seven signals have a column among those that scripts rely on. Without a sensor there is no
    // current, and with one encoder no position of the motor.
    assert_eq!(width, 11 + SIGNALS.len() - 9);
    let text = csv(&[
        "trajectory",
        "--controller",
        "srnf",
        "--set",
        "reference.trajectories=[{corner_times_s=[1, 3], \
         corner_positions_deg=[0, 10], half_blend_s=0.25}]",
        "--set",
        "run.duration_s=6",
    ]);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(&*columns));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 301);
    for (k, row) in rows.iter().enumerate() {
        let cell = |i: usize| row[i].parse::<f64>().unwrap();
        assert!(row.len() == width && (cell(0) - 0.02 * k as f64).abs() < 1e-9, "{row:?}");
        assert!(
            (cell(1) - cell(2) - cell(3)).abs() < 1e-9,
            "the error is reference minus position: {row:?}"
        );
        assert!(
            (cell(5) + cell(6) - cell(7)).abs() < 1e-5,
            "unsaturated, PD and compensator add up: {row:?}"
        );
        assert!((cell(8) - cell(7) / 0.00488).abs() <= 0.5 + 1e-3, "the code is in LSB: {row:?}");
        assert!(
            (cell(10) - cell(8) * 0.00488).abs() < 1e-6,
            "what is applied is the code's volts: {row:?}"
        );
        assert_eq!(cell(11), k as f64, "the tick: {row:?}");
        assert!(
            ["true", "false"].contains(&row[9]) && (row[9] == "false" || cell(4) == 0.0),
            "{row:?}"
        );
    }
    assert_eq!(rows[0][9], "true");

    let text =
        csv(&["friction-identification", "--set", "identification.ramp_rates_v_per_s=[0.02]"]);
    assert_eq!(text.lines().next(), Some(&*columns));
    // A ramp has no reference, no error and no controller.
    let row: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    let empty: Vec<usize> = (0..row.len()).filter(|i| row[*i].is_empty()).collect();
    assert_eq!((row.len(), empty), (width, vec![1, 3, 5, 6, 13, 14, 15, 16]));

    let text =
        csv(&["step-response", "--controller", "pd", "--set", "joint.gain_deg_per_s2_per_v=27"]);
    let header = format!("label,{columns}");
    assert_eq!(text.lines().next(), Some(header.as_str()));
    for label in ["pd/step-5.0,", "pd/step-2.5,", "pd/step-1.0,"] {
        assert_eq!(text.lines().filter(|line| line.starts_with(label)).count(), 501, "{label}");
    }
    assert_eq!(text.lines().count(), 1 + 3 * 501);
}
