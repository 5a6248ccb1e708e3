//! A 12 V gearmotor with a planetary gear of 1:50, 0.6 deg of backlash, an unbalanced load and its
//! encoder on the motor, at 1 kHz, as `stiction new` writes it from options.

use std::path::Path;
use std::process::Command;

/// Backlash in counts: 0.6 deg of a disc with 4 x 512 counts a turn behind a gear of 50.
pub const SLACK: &str = "cannot see 171 counts of backlash";

/// Writes the file of the gearmotor with options of its friction.
pub fn new(directory: &Path, file: &str, friction: &[&str]) {
    let joint = [
        &["new", file, "--driven-by", "voltage", "--voltage-v", "12", "--resistance-ohm", "2.1"][..],
        &["--kt-nm-per-a", "0.016", "--rotor-inertia-kg-m2", "4e-6", "--current-limit-a", "5"],
        &["--ratio", "50", "--efficiency", "0.75", "--inertia-kg-m2", "0.02"],
        &["--backlash-deg", "0.6", "--stiffness-nm-per-rad", "200", "--unbalance-nm", "0.15"],
        &["--hangs-at-deg", "-90", "--travel-deg", "-60..60", "--lines", "512", "--at", "motor"],
        &["--viscous-nm-s-per-rad", "0.01", "--sample-time-s", "0.001"],
        friction,
    ];
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    let output = command.args(joint.concat()).current_dir(directory).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
