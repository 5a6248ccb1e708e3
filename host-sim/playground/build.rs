//! Links the playground as a library with repeated calls (a WASI reactor). Without that file of the
//! C library the linker treats each call as a whole program, which starts and ends.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = std::env::var("TARGET").unwrap_or_default();
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "wasi") {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let sysroot = Command::new(rustc).args(["--print", "sysroot"]).output();
        let sysroot = sysroot.map_or(String::new(), |output| {
            String::from_utf8_lossy(&output.stdout).trim().to_owned()
        });
        let library = Path::new(&sysroot).join("lib/rustlib").join(target);
        let start = library.join("lib/self-contained/crt1-reactor.o");
        println!("cargo:rustc-cdylib-link-arg={}", start.display());
        println!("cargo:rustc-cdylib-link-arg=--export=_initialize");
    }
}
