//! `cargo xtask gates` checks what the firmware must not contain. The simulator's program
//! `stiction-cost` checks the image. Here the linker proves that the control path has no panic.

use std::fs;
use std::process::Command;

use crate::cost;
use crate::firmware::{self, PROFILE};
use crate::job::Job;
use crate::toolchain::{MICROCONTROLLER, TARGET, Toolchain};

const PROGRAM: &str = "no-panic";
/// The function that the proof's panic handler calls, and which is not defined.
const MISSING: &str = "the_control_path_can_panic";
/// The core's tick, the link's parser and the fits of an identification, as both of Rust's
/// manglings spell `stiction::servo::control`, `stiction::link::request::numbered` and
/// `stiction::link::session::go_on`.
const KEPT: [&[u8]; 3] = [
    b"8stiction5servo7control",
    b"8stiction4link7request8numbered",
    b"8stiction4link7session5go_on",
];

/// Runs every gate.
pub fn pass(features: [&str; 3]) -> Result<(), String> {
    let image = firmware::build()?;
    no_panic(&Toolchain::ready(&MICROCONTROLLER)?)?;
    let arguments = ["gates".into(), "--image".into(), image.into()];
    cost::run("Looking through the image", features, &arguments)
}

/// Links the control path and the link with a panic handler that cannot be linked. A second link
/// with a planted panic must fail.
fn no_panic(toolchain: &Toolchain) -> Result<(), String> {
    let link = |more: &[&str]| -> Command {
        let mut arguments =
            vec!["build", "--profile", PROFILE, "--package", PROGRAM, "--target", TARGET];
        arguments.extend(more);
        toolchain.cargo(&arguments)
    };
    let what = "Linking the control path without a panic handler";
    Job::new(what).run(&mut link(&[])).map_err(|why| {
        format!("{why}: if the linker misses `{MISSING}`, something in the control path can panic")
    })?;
    let built = firmware::built(PROGRAM);
    let program =
        fs::read(&built).map_err(|error| format!("cannot read {}: {error}", built.display()))?;
    if !KEPT.iter().all(|name| program.windows(name.len()).any(|window| window == *name)) {
        return Err(format!(
            "{}: the linker has dropped the control path or the link, so this shows nothing",
            built.display()
        ));
    }
    // A gate that never fails would prove nothing.
    Job::new("Linking it with a deliberate panic, which must fail").announce();
    let output = link(&["--features", "deliberate-panic"]).output();
    let output = output.map_err(|error| format!("cannot start cargo: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() || !said.contains(MISSING) {
        return Err(format!("a panic in the control path does not stop the linker:\n{said}"));
    }
    Ok(())
}
