//! `cargo xtask test` runs everything that must pass before a change lands.

use crate::job::{Job, cargo};
use crate::simulator::{EMULATOR, EVERYTHING};
use crate::toolchain::{MICROCONTROLLER, Toolchain};
use crate::{cost, firmware, gates, studio, words};

const STRICT: [&str; 3] = ["--", "--deny", "warnings"];

/// The test that judges an edit of the core within a minute.
const FIRST_LOOK: &str = "first_look";

#[derive(Debug, clap::Args)]
pub struct ImageArguments {
    /// Which tests of tests/image/ are run, by parts of their names; bit_for_bit runs all motions
    /// of the thesis [default: first_look]
    tests: Vec<String>,
}

/// Builds the image, and runs some of its tests. Nothing is compiled for them that is not in a
/// loop, and of our own crates only what an edit has changed. Other jobs compile these whole: the
/// closed loop is faster so. Here the time goes to the emulator, which is not ours.
pub fn image(arguments: &ImageArguments) -> Result<(), String> {
    let image = firmware::build()?;
    let mut test = cargo(&["test", "--package", "loop-tests", "--test", "image"]);
    test.args(EMULATOR).arg("--").env("STICTION_IMAGE", image).env("CARGO_INCREMENTAL", "1");
    match &arguments.tests[..] {
        [] => test.arg(FIRST_LOOK),
        some => test.args(some),
    };
    Job::new("Tests of the image").run(&mut test)
}

pub fn test() -> Result<(), String> {
    Toolchain::agree(&MICROCONTROLLER)?;
    Job::new("Format").run(&mut cargo(&["fmt", "--all", "--check"]))?;
    words::check(&words::Arguments::default())?;
    // The page is there before the program that has it built in.
    let browser = studio::ready()?;
    // All that can be built in is built in. What stands for a part that is left out is compiled
    // with `bad_input` below.
    Job::new("Lints")
        .run(cargo(&["clippy", "--workspace", "--all-targets"]).args(EVERYTHING).args(STRICT))?;
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    Job::new("Lints of the firmware")
        .run(toolchain.cargo(&firmware::arguments("clippy")).args(STRICT))?;
    let image = firmware::build()?;
    // To the end: one failure shall not hide another.
    Job::new("Tests, the image in the loop among them").run(
        cargo(&["test", "--workspace", "--no-fail-fast"])
            .args(EVERYTHING)
            .env("STICTION_IMAGE", image),
    )?;
    // These are the sentences that only a program without those parts says.
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
    studio::test(browser)?;
    gates::pass(EVERYTHING)?;
    cost::measure(&cost::Arguments::default(), EVERYTHING)?;
    Job::new("Documentation").run(
        cargo(&["doc", "--workspace", "--no-deps"])
            .args(EVERYTHING)
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )
}
