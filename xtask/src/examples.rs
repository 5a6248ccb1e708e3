//! `cargo xtask examples` builds the firmwares in `examples/`. Each is a project of its own, with
//! its own dependencies, as a user's firmware is.

use crate::job::{Job, cargo, root, target_dir};
use crate::toolchain::{MICROCONTROLLER, Toolchain};

/// The projects, and what is announced.
const EXAMPLES: [(&str, &str); 2] = [
    ("examples/rtic", "Building the example for RTIC"),
    ("examples/embassy", "Building the example for embassy"),
];

/// Builds each example with the versions that it has recorded.
pub fn build() -> Result<(), String> {
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    for (project, announcement) in EXAMPLES {
        let job = Job::new(announcement);
        job.announce();
        let project = root().join(project);
        job.finish(cargo(&["fmt", "--check"]).current_dir(&project))?;
        // The project has its own settings in .cargo: they hold from its directory on.
        let mut build = toolchain.cargo(&["build", "--release", "--locked", "--quiet"]);
        build.current_dir(&project).env("CARGO_TARGET_DIR", target_dir().join("examples"));
        job.finish(&mut build)?;
    }
    Ok(())
}
