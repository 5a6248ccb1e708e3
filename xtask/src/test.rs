//! `cargo xtask test` runs everything that must pass before a change lands.

use std::path::Path;

use crate::firmware::Image;
use crate::job::{Job, cargo};
use crate::simulator::{EMULATOR, EVERYTHING};
use crate::toolchain::{MICROCONTROLLER, Toolchain};
use crate::{cost, examples, firmware, gates, library, python, studio_page, words};

const STRICT: [&str; 3] = ["--", "--deny", "warnings"];

/// The test that judges an edit of the core within a minute.
const FIRST_LOOK: &str = "first_look";

/// Random messages of the long run: ten times those of each run.
const MESSAGES: &str = "1000000";

#[derive(Debug, clap::Args)]
pub struct TestArguments {
    /// Run the long tests too, which each run leaves out: slow motion against its bars,
    /// identification of every family in the image, gains before and after tuning, a million random
    /// messages, the program in C on three more cores, the wheel and the notebook of Python
    #[arg(long)]
    all: bool,
}

#[derive(Debug, clap::Args)]
pub struct ImageTestArguments {
    /// Tests of tests/image/ to run, by parts of their names; bit_for_bit runs all motions of the
    /// thesis [default: first_look]
    tests: Vec<String>,
}

/// Builds the image, and runs some of its tests. Only crates in the loop are built for them, and of
/// our own crates only the parts that an edit has changed. Other jobs compile these as a whole,
/// which makes the closed loop faster. Here most of the time goes to the emulator, a dependency.
pub fn image(arguments: &ImageTestArguments) -> Result<(), String> {
    let image = firmware::build(Image::OneEncoder)?;
    let mut test = cargo(&["test", "--package", "loop-tests", "--test", "image"]);
    test.args(EMULATOR).arg("--").env("STICTION_IMAGE", image).env("CARGO_INCREMENTAL", "1");
    match &arguments.tests[..] {
        [] => test.arg(FIRST_LOOK),
        some => test.args(some),
    };
    Job::new("Tests of the image").run(&mut test)
}

pub fn test(arguments: &TestArguments) -> Result<(), String> {
    Toolchain::agree(&MICROCONTROLLER)?;
    library::agree(arguments.all)?;
    Job::new("Format").run(&mut cargo(&["fmt", "--all", "--check"]))?;
    words::check(&words::WordsJobArguments::default())?;
    // The page must exist before the program that includes it.
    let browser = studio_page::ready()?;
    // This build has every feature. The replacements of missing features are compiled with
    // `bad_input` below.
    Job::new("Lints")
        .run(cargo(&["clippy", "--workspace", "--all-targets"]).args(EVERYTHING).args(STRICT))?;
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    let lints = Job::new("Lints of the firmware for one encoder and for two");
    lints.announce();
    for image in Image::ALL {
        lints.finish(toolchain.cargo(&firmware::arguments("clippy", image)).args(STRICT))?;
    }
    let image = firmware::build(Image::OneEncoder)?;
    firmware::build(Image::TwoEncoders)?;
    // All tests run: one failure must not hide another.
    Job::new("Tests, the image in the loop among them").run(
        cargo(&["test", "--workspace", "--no-fail-fast"])
            .args(EVERYTHING)
            .env("STICTION_IMAGE", &image),
    )?;
    // Only a program without these features prints these sentences.
    Job::new("Tests of the command line without emulator, live view, figures and report").run(
        &mut cargo(&[
            "test",
            "--package",
            "host-sim",
            "--no-default-features",
            "--test",
            "bad_input",
        ]),
    )?;
    studio_page::test(browser)?;
    gates::pass(EVERYTHING)?;
    examples::build()?;
    library::test(arguments.all)?;
    python::test(arguments.all, &EVERYTHING)?;
    cost::measure(&cost::CostJobArguments::default(), EVERYTHING)?;
    Job::new("Documentation").run(
        cargo(&["doc", "--workspace", "--no-deps"])
            .args(EVERYTHING)
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;
    if arguments.all { long(&image) } else { Ok(()) }
}

/// Runs the tests that are ignored elsewhere because they take long, and more random messages.
fn long(image: &Path) -> Result<(), String> {
    Job::new("Random messages, a million").run(
        cargo(&["test", "--package", "loop-tests", "--test", "device"])
            .args(EMULATOR)
            .args(["--", "random_messages", "--nocapture"])
            .env("STICTION_FUZZ", MESSAGES),
    )?;
    Job::new("Slow motion: ramps, sines and conditions against their bars").run(&mut cargo(&[
        "test",
        "--package",
        "studies",
        "--",
        "--ignored",
        "--nocapture",
    ]))?;
    Job::new("Identification of every family in the image, and gains before and after tuning").run(
        cargo(&["test", "--package", "host-sim", "--test", "commissioned"])
            .args(EVERYTHING)
            .args(["--", "--ignored", "--nocapture"])
            .env("STICTION_IMAGE", image),
    )
}
