//! Finds the compiler for a target: an installed one, else rustup's, else Debian's.
//!
//! The user's default tool chain is never updated and never replaced. Debian's compiler has no
//! library for the target, so it is built once from Debian's own sources and put beside the host's;
//! rustup then has the two as the tool chain `stiction`. A stamp with the compiler's version shows
//! whether it is current.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::job::{Job, cargo, root, target_dir};
use crate::packages;

/// The target of the firmware: a Cortex-M4 with a single-precision unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// A target other than this machine.
#[derive(Debug)]
pub struct BuildTarget {
    /// Its name.
    pub name: &'static str,
    /// The crates of the standard library that are built for it.
    library: &'static str,
    /// Announcement of their build.
    builds: &'static str,
    /// Announcement of the installation by rustup.
    adds: &'static str,
    /// Debian's package of its C library, and the directory of that.
    c_library: Option<(&'static str, &'static str)>,
}

/// The microcontroller.
pub const MICROCONTROLLER: BuildTarget = BuildTarget {
    name: TARGET,
    library: "core,alloc,compiler_builtins",
    builds: "Building the core library for thumbv7em-none-eabihf (once, less than a minute)",
    adds: "Adding the target thumbv7em-none-eabihf by rustup",
    c_library: None,
};

/// Cores of other boards, for which the library is built: Cortex-M0 and M0+, Cortex-M33 with a
/// single-precision unit, and RISC-V without one.
pub const LIBRARY_TARGETS: [BuildTarget; 3] = [
    BuildTarget {
        name: "thumbv6m-none-eabi",
        library: "core,compiler_builtins",
        builds: "Building the core library for thumbv6m-none-eabi (once, less than a minute)",
        adds: "Adding the target thumbv6m-none-eabi by rustup",
        c_library: None,
    },
    BuildTarget {
        name: "thumbv8m.main-none-eabihf",
        library: "core,compiler_builtins",
        builds: "Building the core library for thumbv8m.main-none-eabihf (once, half a minute)",
        adds: "Adding the target thumbv8m.main-none-eabihf by rustup",
        c_library: None,
    },
    BuildTarget {
        name: "riscv32imc-unknown-none-elf",
        library: "core,compiler_builtins",
        builds: "Building the core library for riscv32imc-unknown-none-elf (once, half a minute)",
        adds: "Adding the target riscv32imc-unknown-none-elf by rustup",
        c_library: None,
    },
];

/// A page in a browser: WebAssembly with files and a clock.
pub const PAGE: BuildTarget = BuildTarget {
    name: "wasm32-wasip1",
    library: "std,panic_abort",
    builds: "Building the standard library for wasm32-wasip1 (once, about a minute)",
    adds: "Adding the target wasm32-wasip1 by rustup",
    c_library: Some(("wasi-libc", "/usr/lib/wasm32-wasi")),
};

impl BuildTarget {
    /// Debian's packages for it.
    fn packages(&self) -> Vec<&'static str> {
        PACKAGES.into_iter().chain(self.c_library.map(|(package, _)| package)).collect()
    }

    /// Directory in which Debian's compiler looks for its libraries.
    fn directory(&self) -> PathBuf {
        Path::new(RUSTLIB).join(self.name)
    }

    fn stamp_file(&self) -> PathBuf {
        self.directory().join("stiction.stamp")
    }
}

/// The name of Debian's compiler in rustup.
const LINKED: &str = "stiction";

/// Debian's packages of the compiler, its sources, its linker and lints.
const PACKAGES: [&str; 7] = [
    "rustc-web",
    "cargo-web",
    "rust-web-src",
    "rust-web-clippy",
    "rustfmt-web",
    "rust-web-llvm",
    "lld-22",
];

/// The directory in which Debian keeps the libraries of each target.
const RUSTLIB: &str = "/usr/lib/rustlib";

/// A tool chain that can build for a [`BuildTarget`].
pub enum Toolchain {
    /// The default tool chain of cargo.
    Default,
    /// The tool chain of Debian.
    Debian,
}

impl Toolchain {
    /// Prints the system packages that [`Self::ready`] would install, and asks on a terminal. A job
    /// that needs the compiler late calls this at its start. Returns whether the user agrees; if
    /// nothing is to be installed, it prints nothing and returns true.
    ///
    /// # Errors
    /// Returns an error if the packages are missing and this machine cannot install them.
    pub fn agreed(target: &BuildTarget) -> Result<bool, String> {
        // The packages of rustup are not system packages.
        if default_has(target) || debian_is_built(target) || rustup_may_install() {
            return Ok(true);
        }
        can_install(target)?;
        let missing = missing_packages(target);
        if !missing.is_empty() {
            println!("== The compiler for {}", target.name);
        }
        packages::agreed(&missing)
    }

    /// Does the same for a job that cannot run without the compiler.
    ///
    /// # Errors
    /// Also returns an error if the user refuses.
    pub fn agree(target: &BuildTarget) -> Result<(), String> {
        if Self::agreed(target)? { Ok(()) } else { Err("nothing is installed".into()) }
    }

    /// Finds a tool chain, or installs one, and prints what it does.
    ///
    /// # Errors
    /// Returns an error that names the command that the user has to run.
    pub fn ready(target: &BuildTarget) -> Result<Self, String> {
        if default_has(target) {
            return Ok(Self::Default);
        }
        if debian_is_built(target) {
            // This needs no root: another user of this machine may have installed the packages.
            link()?;
            return Ok(Self::Debian);
        }
        if rustup_may_install() {
            let mut add = Command::new("rustup");
            let added = Job::new(target.adds).run(add.args(["target", "add", target.name]));
            match added {
                Ok(()) if default_has(target) => return Ok(Self::Default),
                _ => println!("   rustup could not; trying Debian's packages"),
            }
        }
        install_debian(target)?;
        link()?;
        Ok(Self::Debian)
    }

    /// Returns a line that names the tool chain.
    pub const fn describe(&self) -> &'static str {
        match self {
            Self::Default => "the default tool chain",
            Self::Debian => "Debian's compiler, which rustup knows as `stiction`",
        }
    }

    /// Returns the compiler's own version line, as in `rustc 1.96.0 (ac68faa20 2026-05-28)`.
    pub fn version(&self) -> Option<String> {
        let text = match self {
            Self::Default => {
                output(Command::new(default_rustc()).arg("--version").current_dir(root()))
            }
            Self::Debian => output(Command::new("/usr/bin/rustc").arg("--version")),
        };
        text.map(|text| text.trim().to_owned())
    }

    /// Returns a call of this tool chain's cargo, in the root of the workspace.
    pub fn cargo(&self, arguments: &[&str]) -> Command {
        match self {
            Self::Default => cargo(arguments),
            Self::Debian => {
                // Cargo is called by its name: `$CARGO` is the default tool chain's.
                let mut command =
                    Command::new(if has_rustup() { "cargo" } else { "/usr/bin/cargo" });
                command.args(arguments).current_dir(root());
                command.env("RUSTUP_TOOLCHAIN", LINKED).env_remove("CARGO").env_remove("RUSTC");
                command
            }
        }
    }
}

fn default_rustc() -> OsString {
    std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())
}

fn default_has(target: &BuildTarget) -> bool {
    let mut rustc = Command::new(default_rustc());
    let sysroot = output(rustc.args(["--print", "sysroot"]).current_dir(root()));
    sysroot.is_some_and(|sysroot| {
        has_core(&Path::new(sysroot.trim()).join("lib/rustlib").join(target.name))
    })
}

fn has_core(target: &Path) -> bool {
    let Ok(files) = fs::read_dir(target.join("lib")) else { return false };
    files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
}

fn has_rustup() -> bool {
    output(Command::new("rustup").arg("--version")).is_some()
}

/// Returns whether rustup may install something. `RUSTUP_AUTO_INSTALL` = 0 forbids it.
fn rustup_may_install() -> bool {
    has_rustup() && std::env::var_os("RUSTUP_AUTO_INSTALL").is_none_or(|value| value != "0")
}

fn debian_version() -> Option<String> {
    output(Command::new("/usr/bin/rustc").arg("-vV"))
}

fn debian_is_built(target: &BuildTarget) -> bool {
    let built_for = fs::read_to_string(target.stamp_file()).ok();
    let same_compiler = built_for.is_some() && built_for == debian_version();
    same_compiler && has_core(&target.directory())
}

fn is_linked() -> bool {
    if !has_rustup() {
        return true;
    }
    let names = output(Command::new("rustup").args(["toolchain", "list"])).unwrap_or_default();
    names.lines().any(|line| line.split_whitespace().next() == Some(LINKED))
}

/// Registers Debian's compiler in this user's rustup, if there is one.
fn link() -> Result<(), String> {
    if is_linked() {
        return Ok(());
    }
    Job::new("Making Debian's compiler known to rustup as `stiction`")
        .run(Command::new("rustup").args(["toolchain", "link", LINKED, "/usr"]))
}

/// Returns an error that names a remedy, unless packages can be installed here.
fn can_install(target: &BuildTarget) -> Result<(), String> {
    if packages::can_install() {
        return Ok(());
    }
    Err(format!(
        "no compiler here builds for {name}; run\n    rustup target add {name}\nor, on Debian 12, \
         the same command as root: it installs {}",
        target.packages().join(" "),
        name = target.name,
    ))
}

fn install_debian(target: &BuildTarget) -> Result<(), String> {
    can_install(target)?;
    let missing = missing_packages(target);
    if !missing.is_empty() {
        packages::install(&missing)?;
    }
    let version =
        debian_version().ok_or("/usr/bin/rustc does not start, though its package is installed")?;
    build_library(target, &version)?;
    name_linker(&version)?;
    // The stamp comes last, so that an interrupted run starts again.
    write(&target.stamp_file(), &version)
}

fn missing_packages(target: &BuildTarget) -> Vec<&'static str> {
    target.packages().into_iter().filter(|package| !is_installed(package)).collect()
}

fn is_installed(package: &str) -> bool {
    let status =
        output(Command::new("dpkg-query").args(["--show", "--showformat=${Status}", package]));
    status.is_some_and(|status| status.ends_with("ok installed"))
}

/// Builds the library for the target in an empty crate, and puts it where the compiler looks for
/// it.
fn build_library(target: &BuildTarget, version: &str) -> Result<(), String> {
    let library = target.directory().join("lib");
    if has_core(&target.directory()) {
        // An existing library belongs to another compiler, or to an interrupted run.
        fs::remove_dir_all(&library).map_err(|error| cannot("remove", &library, &error))?;
    }
    let name = "stiction-empty";
    let empty = target_dir().join("toolchain");
    let manifest = format!("[package]\nname = \"{name}\"\nedition = \"2024\"\n\n[workspace]\n");
    make_dir(&empty.join("src"))?;
    write(&empty.join("Cargo.toml"), &manifest)?;
    write(&empty.join("src/lib.rs"), "#![no_std]\n")?;
    let target_dir = empty.join(release_of(version));
    let mut build = Command::new("/usr/bin/cargo");
    build
        .args(["build", "--quiet", "--release", "--target", target.name])
        .arg(format!("-Zbuild-std={}", target.library))
        .arg("--target-dir")
        .arg(&target_dir)
        .current_dir(&empty)
        .env("RUSTC", "/usr/bin/rustc")
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", "-Cembed-bitcode=yes -Zforce-unstable-if-unmarked")
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("CARGO_TARGET_DIR");
    Job::new(target.builds).run(&mut build)?;
    make_dir(&library)?;
    let built = target_dir.join(target.name).join("release/deps");
    let files = fs::read_dir(&built).map_err(|error| cannot("read", &built, &error))?;
    for file in files.flatten().map(|file| file.path()) {
        let is_library = file.extension() == Some(OsStr::new("rlib"));
        let file_name = file.file_name().unwrap_or_default();
        if is_library && !file_name.to_string_lossy().starts_with("libstiction") {
            fs::copy(&file, library.join(file_name))
                .map_err(|error| cannot("copy", &file, &error))?;
        }
    }
    let Some((_, from)) = target.c_library else { return Ok(()) };
    let beside = library.join("self-contained");
    make_dir(&beside)?;
    for file in ["libc.a", "crt1-command.o", "crt1-reactor.o"] {
        let from = Path::new(from).join(file);
        fs::copy(&from, beside.join(file)).map_err(|error| cannot("copy", &from, &error))?;
    }
    Ok(())
}

/// Returns the release in the output of `rustc -vV`, as in `1.96.0`.
fn release_of(version: &str) -> &str {
    version.lines().find_map(|line| line.strip_prefix("release: ")).unwrap_or("unknown")
}

/// Puts `rust-lld` beside the compiler: a proxy of the same name from `cargo-binutils` on the path
/// is not a linker.
fn name_linker(version: &str) -> Result<(), String> {
    let host = version
        .lines()
        .find_map(|line| line.strip_prefix("host: "))
        .ok_or("rustc names no host")?;
    let directory = Path::new(RUSTLIB).join(host).join("bin");
    let linker = directory.join("rust-lld");
    if linker.exists() {
        return Ok(());
    }
    make_dir(&directory)?;
    std::os::unix::fs::symlink("/usr/bin/lld-22", &linker)
        .map_err(|error| cannot("link", &linker, &error))
}

fn make_dir(path: &Path) -> Result<(), String> {
    fs::create_dir_all(path).map_err(|error| cannot("make", path, &error))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| cannot("write", path, &error))
}

fn cannot(action: &str, path: &Path, error: &std::io::Error) -> String {
    format!("cannot {action} {}: {error}", path.display())
}

/// Returns the output of a command, if it starts and succeeds.
fn output(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()
}
