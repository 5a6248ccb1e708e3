//! `cargo xtask cost` builds the images; the simulator's program `stiction-cost` measures the cost
//! of a tick.

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;

use crate::firmware::{self, Image, PROFILE};
use crate::job::{Job, cargo, root};
use crate::toolchain::{MICROCONTROLLER, TARGET, Toolchain};

/// The page with the golden table, and that of the image for two encoders.
const PAGE: &str = "tests/evidence/cost.md";
const PAGE_OF_TWO: &str = "tests/evidence/cost-two-encoders.md";
const YARDSTICK: &str = "yardstick";

#[derive(Debug, Default, clap::Args)]
pub struct CostJobArguments {
    /// Write the figures into tests/evidence/cost.md and cost-two-encoders.md instead of comparing
    /// them
    #[arg(long)]
    bless: bool,
}

/// Builds the images, measures them in the emulator, and compares.
pub fn measure(arguments: &CostJobArguments, features: [&str; 3]) -> Result<(), String> {
    let image = firmware::build(Image::OneEncoder)?;
    let of_two = firmware::build(Image::TwoEncoders)?;
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    let build = ["build", "--profile", PROFILE, "--package", YARDSTICK, "--target", TARGET];
    Job::new("Building the yardsticks").run(&mut toolchain.cargo(&build))?;
    let built = firmware::built(YARDSTICK);
    let yardstick = image.with_file_name(YARDSTICK).with_extension("elf");
    fs::copy(&built, &yardstick).map_err(|error| {
        format!("cannot copy {} to {}: {error}", built.display(), yardstick.display())
    })?;
    let compiler = toolchain.version().ok_or("the compiler does not say its version")?;
    let measuring = |image: PathBuf, page: &str, yardstick: Option<PathBuf>| {
        let mut measuring: Vec<OsString> = vec!["cost".into()];
        for (option, value) in [
            ("--image", Some(image.into())),
            ("--yardstick", yardstick.map(OsString::from)),
            ("--compiler", Some(compiler.clone().into())),
            ("--golden", Some(root().join(page).into())),
        ] {
            measuring.extend(value.into_iter().flat_map(|value| [option.into(), value]));
        }
        measuring.extend(arguments.bless.then(|| "--bless".into()));
        measuring
    };
    let what = "Counting instructions and cycles in the emulator (a minute on two cores)";
    run(what, features, &measuring(image, PAGE, Some(yardstick)))?;
    let what = "Counting those of the image for two encoders";
    run(what, features, &measuring(of_two, PAGE_OF_TWO, None))
}

/// Runs `stiction-cost`, built with features that include the emulator. An existing build with the
/// same features is reused.
pub fn run(what: &'static str, features: [&str; 3], arguments: &[OsString]) -> Result<(), String> {
    let mut command = cargo(&["run", "--bin", "stiction-cost"]);
    command.args(features).arg("--");
    Job::new(what).run(command.args(arguments))
}
