//! The page of `stiction studio`: its build by npm, the program around it, and its browser.

use std::path::PathBuf;
use std::process::Command;

use crate::job::{Job, cargo, root, target_dir};
use crate::simulator::{EMULATOR, EVERYTHING};

/// The options of a build with the studio.
const STUDIO: [&str; 4] = ["--package", "host-sim", "--features", "studio"];

/// Names of browsers that the tests can drive.
pub const BROWSERS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

pub fn options(command: &mut Command, with_emulator: bool) {
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
pub fn needed(by: &str) -> Result<&'static str, String> {
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
