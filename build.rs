//! Link arguments and the commit, for the firmware only: builds for the host, and for the programs
//! of others on a microcontroller, stay as they are.

use std::path::Path;
use std::process::Command;

/// What the firmware is made of.
const SOURCES: [&str; 5] = ["src", "Cargo.toml", "Cargo.lock", "memory.x", "build.rs"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let is_board = std::env::var_os("CARGO_FEATURE_BOARD").is_some();
    if !is_board || std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    if std::env::var_os("CARGO_FEATURE_TWO_ENCODERS").is_some() {
        // memory.x then reserves more stack.
        println!("cargo:rustc-link-arg-bins=--defsym=two_encoders=1");
    }
    println!("cargo:rustc-env=STICTION_COMMIT={}", commit().unwrap_or_else(|| "unknown".into()));
}

/// The commit of the sources, if they are in a repository; `+` says that they were changed since.
fn commit() -> Option<String> {
    // Written at every commit and checkout.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join(log);
    println!("cargo:rerun-if-changed={}", log.display());
    for source in SOURCES {
        println!("cargo:rerun-if-changed={source}");
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let mut status = vec!["status", "--porcelain", "--"];
    status.extend(SOURCES);
    let changed = git(&status).is_none_or(|list| !list.is_empty());
    Some(if changed { commit + "+" } else { commit })
}

fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    let output = command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(text.trim().to_owned())
}
