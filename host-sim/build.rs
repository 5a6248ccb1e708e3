//! Finds the page of `stiction studio` for the program that has it built in.

use std::path::Path;

/// What `cargo xtask studio` makes.
const BUILT: &str = "studio-page/dist";

/// What stands for it otherwise, so that the server can be compiled and tested without npm.
const INSTEAD: &str = "studio-page/not-built";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_STUDIO").is_none() {
        return;
    }
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let is_built = Path::new(&here).join(BUILT).join("main.js").exists();
    let (page, looked_at) = if is_built { (BUILT, BUILT) } else { (INSTEAD, "studio-page") };
    println!("cargo:rerun-if-changed={looked_at}");
    println!("cargo:rustc-env=STUDIO_PAGE={here}/{page}");
}
