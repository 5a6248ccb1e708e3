//! `cargo xtask studio` builds the page of `stiction studio` by npm, and the program around it.

use std::path::PathBuf;
use std::process::Command;

use crate::job::{Job, cargo, root, target_dir};
use crate::playground;
use crate::simulator::{EMULATOR, EVERYTHING};

#[derive(Debug, clap::Args)]
pub struct StudioJobArguments {
    /// Build it with the emulator, for `--emulator`
    #[arg(long)]
    with_emulator: bool,
    /// Build it, and start nothing
    #[arg(long)]
    build: bool,
    /// Make the pictures of docs/ in a browser, and start nothing else
    #[arg(long)]
    picture: bool,
    /// Minutes for which the load of server and page is measured; fails if it is too high; on
    /// Linux
    #[arg(
        long,
        value_name = "MINUTES",
        num_args = 0..=1,
        default_missing_value = "10",
        value_parser = clap::value_parser!(u32).range(2..),
        conflicts_with_all = ["with_emulator", "build", "picture", "arguments"]
    )]
    throughput: Option<u32>,
    /// Build the page with the simulator in it, as static files in target/playground, and start
    /// nothing
    #[arg(
        long,
        conflicts_with_all = ["with_emulator", "build", "picture", "throughput", "arguments"]
    )]
    playground: bool,
    /// Test the playground in a browser as well
    #[arg(long, requires = "playground")]
    test: bool,
    /// StudioJobArguments of `stiction studio`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// The options of a build with the studio.
const STUDIO: [&str; 4] = ["--package", "host-sim", "--features", "studio"];

/// Names of browsers that the tests can drive.
pub const BROWSERS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Builds the page and the program, and starts it.
pub fn studio(arguments: &StudioJobArguments) -> Result<(), String> {
    if arguments.playground {
        let directory = playground::build()?;
        return if arguments.test { playground::test(&directory) } else { Ok(()) };
    }
    page()?;
    build(arguments.with_emulator)?;
    if arguments.build {
        return Ok(());
    }
    if arguments.picture {
        let job = Job::new("Making the pictures of docs/");
        let browser = needed("making the pictures")?;
        return job.run(script("pictures.mjs", browser).arg(root().join("docs")));
    }
    if let Some(minutes) = arguments.throughput {
        let job = Job::new("Measuring the load of the studio");
        let browser = needed("measuring")?;
        return job.run(script("throughput.mjs", browser).arg(minutes.to_string()));
    }
    let mut run = cargo(&["run", "--quiet", "--bin", "stiction"]);
    options(&mut run, arguments.with_emulator);
    Job::new("stiction studio").run(run.args(["--", "studio"]).args(&arguments.arguments))
}

fn options(command: &mut Command, with_emulator: bool) {
    command.args(STUDIO);
    if with_emulator {
        command.args(EMULATOR);
    }
}

/// Builds the program with the page in it.
pub fn build(with_emulator: bool) -> Result<(), String> {
    let mut build = cargo(&["build", "--bin", "stiction"]);
    options(&mut build, with_emulator);
    Job::new("Building the simulator with the studio").run(&mut build)
}

/// Directory of the page's sources.
pub fn directory() -> PathBuf {
    root().join("host-sim/studio-page")
}

fn npm(arguments: &[&str]) -> Command {
    // It is a script on Windows.
    let mut npm = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    npm.args(arguments).current_dir(directory());
    npm
}

/// Returns whether a program is installed.
fn runs(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

/// Builds the page into `host-sim/studio-page/dist`, with the packages of `package-lock.json`.
pub fn page() -> Result<(), String> {
    if !runs(&mut npm(&["--version"])) {
        return Err(
            "the page of the studio is built by npm, which comes with Node.js 20 or newer \
                    (https://nodejs.org, or `apt install npm`); nothing else of the project needs \
                    it"
            .into(),
        );
    }
    Job::new("Fetching the packages of the page by its lock file").run(&mut npm(&[
        "ci",
        "--no-audit",
        "--no-fund",
    ]))?;
    Job::new("Checking the types of the page").run(&mut npm(&["run", "check"]))?;
    Job::new("Building the page").run(&mut npm(&["run", "build"]))
}

/// Builds the page for a test in a browser, and returns the browser, or `None` without it or npm.
pub fn ready() -> Result<Option<&'static str>, String> {
    let browser = browser().filter(|_| runs(&mut npm(&["--version"])));
    if browser.is_some() {
        page()?;
    }
    Ok(browser)
}

/// Tests the page in a browser, on the program with everything built in.
pub fn test(browser: Option<&str>) -> Result<(), String> {
    let Some(browser) = browser else {
        println!(
            "== NOT RUN: the test of the studio's page in a browser; it needs npm and one of {}",
            BROWSERS.join(", ")
        );
        return Ok(());
    };
    let mut build = cargo(&["build", "--bin", "stiction"]);
    Job::new("Building the simulator with the studio").run(build.args(EVERYTHING))?;
    let job = Job::new("Test of the studio's page in a browser");
    let mut test = script("browser.mjs", browser);
    // Without an image the test reports what it has not run.
    let image = target_dir().join("firmware").join("stiction-firmware.elf");
    if image.exists() {
        test.arg("--image").arg(image);
    }
    job.run(&mut test)
}

/// Returns a browser for a job that needs one.
fn needed(by: &str) -> Result<&'static str, String> {
    browser().ok_or_else(|| format!("{by} needs one of {}", BROWSERS.join(", ")))
}

/// Returns an installed browser.
pub fn browser() -> Option<&'static str> {
    BROWSERS.into_iter().find(|name| runs(Command::new(name).arg("--version")))
}

/// Runs a script that drives the page of the built program in a browser.
pub fn script(name: &str, browser: &str) -> Command {
    let mut node = Command::new("node");
    node.arg(format!("test/{name}")).arg(target_dir().join("debug/stiction")).arg(browser);
    node.current_dir(directory());
    node
}
