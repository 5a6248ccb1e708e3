//! Finds the page of `stiction studio`, which is built into the program.

use std::path::Path;

/// Directory of the page that `cargo xtask studio` builds.
const BUILT: &str = "studio-page/dist";

/// Directory of its replacement, so that the server can be compiled and tested without npm.
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
