//! `cargo xtask test`: everything that must pass before a change lands.

use crate::job::{Job, cargo};
use crate::simulator::EMULATOR;
use crate::toolchain::Toolchain;
use crate::{cost, firmware, gates};

const STRICT: [&str; 3] = ["--", "--deny", "warnings"];

pub fn test() -> Result<(), String> {
    Job::new("Format").run(&mut cargo(&["fmt", "--all", "--check"]))?;
    let clippy = ["clippy", "--workspace", "--all-targets"];
    Job::new("Lints").run(cargo(&clippy).args(STRICT))?;
    Job::new("Lints, with the emulator").run(cargo(&clippy).args(EMULATOR).args(STRICT))?;
    let toolchain = Toolchain::ready()?;
    Job::new("Lints of the firmware").run(toolchain.cargo(&firmware::arguments("clippy")).args(STRICT))?;
    let image = firmware::build()?;
    Job::new("Tests, the image in the loop among them")
        .run(cargo(&["test", "--workspace"]).args(EMULATOR).env("STICTION_IMAGE", image))?;
    // What only a program without the emulator says.
    Job::new("Tests of the command line without the emulator").run(&mut cargo(&[
        "test",
        "--package",
        "host-sim",
        "--test",
        "bad_input",
    ]))?;
    gates::pass()?;
    cost::measure(&cost::Arguments::default())?;
    Job::new("Documentation").run(
        cargo(&["doc", "--workspace", "--no-deps", "--quiet"])
            .args(EMULATOR)
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )
}
