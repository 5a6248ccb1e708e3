//! Gives link arguments for the microcontroller only: where the program begins and what else it
//! holds. It needs nothing more, since it is never run.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=--entry=control_path");
        println!("cargo:rustc-link-arg-bins=--undefined=link_path");
        println!("cargo:rustc-link-arg-bins=--gc-sections");
    }
}
