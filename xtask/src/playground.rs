//! `cargo xtask studio --playground` builds the page with the simulator inside, as static files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::job::{Job, target_dir};
use crate::studio_page::{self, BROWSERS};
use crate::toolchain::{PAGE, Toolchain};

/// The profile of the program in the page.
const PROFILE: &str = "wasm";

/// Builds the files, and prints their directory.
pub fn build() -> Result<PathBuf, String> {
    Toolchain::agree(&PAGE)?;
    studio_page::page()?;
    let toolchain = Toolchain::ready(&PAGE)?;
    println!("   compiler: {}", toolchain.describe());
    let arguments =
        ["build", "--package", "playground", "--profile", PROFILE, "--target", PAGE.name];
    Job::new("Building the studio for the page").run(&mut toolchain.cargo(&arguments))?;
    let simulator = target_dir().join(PAGE.name).join(PROFILE).join("playground.wasm");
    let directory = target_dir().join("playground");
    let mut build = Command::new("node");
    build
        .arg("playground.mjs")
        .args([&simulator, &directory])
        .current_dir(studio_page::directory());
    Job::new("Building the playground").run(&mut build)?;
    println!("\n{}: {} KB", directory.display(), kilobytes(&directory)?);
    println!(
        "Open index.html in a browser, as a file or from any server of static files, such as\n    \
         python3 -m http.server --directory {}",
        directory.display()
    );
    Ok(directory)
}

/// Returns the size of a directory's files, in KB of 1000 bytes.
fn kilobytes(directory: &Path) -> Result<u64, String> {
    let cannot = |error: std::io::Error| format!("cannot read {}: {error}", directory.display());
    let mut bytes = 0;
    for file in fs::read_dir(directory).map_err(cannot)? {
        bytes += file.and_then(|file| file.metadata()).map_err(cannot)?.len();
    }
    Ok(bytes.div_ceil(1000))
}

/// Tests the files in a browser, beside the program.
pub fn test(directory: &Path) -> Result<(), String> {
    let Some(browser) = studio_page::browser() else {
        return Err(format!("the test needs one of {}", BROWSERS.join(", ")));
    };
    studio_page::build(false)?;
    let job = Job::new("Test of the playground in a browser");
    job.run(studio_page::script("playground.mjs", browser).arg(directory))
}
