//! `cargo xtask cost` builds the images; the simulator's program `stiction-cost` measures the cost
//! of a tick.

use std::ffi::OsString;
use std::fs;

use crate::firmware::{self, Image, PROFILE};
use crate::job::{Job, cargo, root};
use crate::toolchain::{MICROCONTROLLER, TARGET, Toolchain};

/// The page with the golden table.
const PAGE: &str = "tests/evidence/cost.md";
const YARDSTICK: &str = "yardstick";

#[derive(Debug, Default, clap::Args)]
pub struct CostJobArguments {
    /// Write the figures into tests/evidence/cost.md instead of comparing them with it
    #[arg(long)]
    bless: bool,
}

/// Builds the images, measures them in the emulator, and compares.
pub fn measure(arguments: &CostJobArguments, features: [&str; 3]) -> Result<(), String> {
    let image = firmware::build(Image::OneEncoder)?;
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    let build = ["build", "--profile", PROFILE, "--package", YARDSTICK, "--target", TARGET];
    Job::new("Building the yardsticks").run(&mut toolchain.cargo(&build))?;
    let built = firmware::built(YARDSTICK);
    let yardstick = image.with_file_name(YARDSTICK).with_extension("elf");
    fs::copy(&built, &yardstick).map_err(|error| {
        format!("cannot copy {} to {}: {error}", built.display(), yardstick.display())
    })?;
    let compiler = toolchain.version().ok_or("the compiler does not say its version")?;
    let mut measuring: Vec<OsString> = vec!["cost".into()];
    for (option, value) in [
        ("--image", image.into()),
        ("--yardstick", yardstick.into()),
        ("--compiler", compiler.into()),
        ("--golden", root().join(PAGE).into()),
    ] {
        measuring.extend([option.into(), value]);
    }
    measuring.extend(arguments.bless.then(|| "--bless".into()));
    let what = "Counting instructions and cycles in the emulator (a minute on two cores)";
    run(what, features, &measuring)
}

/// Runs `stiction-cost`, built with features that include the emulator. An existing build with the
/// same features is reused.
pub fn run(what: &'static str, features: [&str; 3], arguments: &[OsString]) -> Result<(), String> {
    let mut command = cargo(&["run", "--bin", "stiction-cost"]);
    command.args(features).arg("--");
    Job::new(what).run(command.args(arguments))
}
