//! `cargo xtask library` builds the library for C, and packs it. The tests run a program in C with
//! it on emulated microcontrollers, and compare each tick with the same program on this machine.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::firmware::PROFILE;
use crate::job::{Job, cargo, root, target_dir};
use crate::packages;
use crate::toolchain::{BuildTarget, LIBRARY_TARGETS, MICROCONTROLLER, Toolchain};

/// The package, and the archive that cargo makes of it.
const PACKAGE: &str = "stiction-c";
const ARCHIVE: &str = "libstiction_c.a";

/// Ticks that the program prints, a line each.
const TICKS: usize = 4000;

/// Arguments of every C compiler. A product and a sum rounded at once would make other bits.
const STRICT: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off"];

/// Arguments for a program without a system below it.
const BARE: [&str; 4] = ["-ffreestanding", "-nostdlib", "-Wl,--gc-sections", "-Wl,-z,noexecstack"];

/// An emulated microcontroller.
struct Core {
    /// Its name in what is printed and packed.
    name: &'static str,
    /// Start-up and linker script in `c/program`.
    start: [&'static str; 2],
    /// The compiler of C and its arguments.
    compiler: &'static str,
    options: &'static [&'static str],
    /// The emulator and its arguments.
    emulator: &'static str,
    machine: &'static [&'static str],
    /// Debian's packages of both.
    packages: [&'static str; 2],
}

const ARM: Core = Core {
    name: "cortex-m4f",
    start: ["cortex_m.c", "cortex_m.ld"],
    compiler: "arm-none-eabi-gcc",
    // The board is one with an STM32F405.
    options: &[
        "-mcpu=cortex-m4",
        "-mthumb",
        "-mfloat-abi=hard",
        "-mfpu=fpv4-sp-d16",
        "-Wl,--defsym,FLASH_AT=0x08000000",
        "-Wl,--defsym,RAM_AT=0x20000000",
    ],
    emulator: "qemu-system-arm",
    machine: &["-machine", "netduinoplus2"],
    packages: ["gcc-arm-none-eabi", "qemu-system-arm"],
};

/// The cores of [`LIBRARY_TARGETS`], in its order.
const OTHERS: [Core; 3] = [
    Core {
        name: "cortex-m0",
        options: &[
            "-mcpu=cortex-m0",
            "-mthumb",
            "-Wl,--defsym,FLASH_AT=0",
            "-Wl,--defsym,RAM_AT=0x20000000",
        ],
        machine: &["-machine", "microbit"],
        ..ARM
    },
    Core {
        name: "cortex-m33f",
        options: &[
            "-mcpu=cortex-m33",
            "-mthumb",
            "-mfloat-abi=hard",
            "-mfpu=fpv5-sp-d16",
            "-Wl,--defsym,FLASH_AT=0x10000000",
            "-Wl,--defsym,RAM_AT=0x38000000",
        ],
        machine: &["-machine", "mps2-an505"],
        ..ARM
    },
    Core {
        name: "rv32imc",
        start: ["riscv.c", "riscv.ld"],
        compiler: "riscv64-unknown-elf-gcc",
        options: &["-march=rv32imc", "-mabi=ilp32", "-Wl,--no-warn-rwx-segments"],
        emulator: "qemu-system-riscv32",
        machine: &["-machine", "virt", "-bios", "none"],
        packages: ["gcc-riscv64-unknown-elf", "qemu-system-misc"],
    },
];

#[derive(Debug, clap::Args)]
pub struct LibraryJobArguments {
    /// Instead, run a program in C with the library on this machine and on four emulated cores, and
    /// compare each tick
    #[arg(long)]
    test: bool,
}

/// Packs the library, or tests it.
pub fn run(arguments: &LibraryJobArguments) -> Result<(), String> {
    if arguments.test {
        agree(true)?;
        test(true)
    } else {
        pack().map(|_| ())
    }
}

/// Returns the cores that a test runs, with their targets.
fn cores(all: bool) -> impl Iterator<Item = (&'static Core, &'static BuildTarget)> {
    let others = OTHERS.iter().zip(&LIBRARY_TARGETS).filter(move |_| all);
    [(&ARM, &MICROCONTROLLER)].into_iter().chain(others)
}

impl Core {
    fn is_ready(&self) -> bool {
        [self.compiler, self.emulator].into_iter().all(|program| {
            Command::new(program).arg("--version").output().is_ok_and(|made| made.status.success())
        })
    }
}

/// Prints the packages of the compilers and emulators that are missing, and asks on a terminal. A
/// machine that cannot install them skips what needs them.
///
/// # Errors
/// Returns an error if apt does not know a package.
pub fn agree(all: bool) -> Result<(), String> {
    let mut missing: Vec<_> = cores(all)
        .filter(|(core, _)| !core.is_ready())
        .flat_map(|(core, _)| core.packages)
        .collect();
    missing.sort_unstable();
    missing.dedup();
    if !missing.is_empty() && packages::can_install() && packages::agreed(&missing)? {
        packages::install(&missing)?;
    }
    Ok(())
}

/// Builds the archive for a target, and returns its path.
fn archive(target: &BuildTarget, more: &[&str]) -> Result<PathBuf, String> {
    let toolchain = Toolchain::ready(target)?;
    let build = ["build", "--quiet", "--profile", PROFILE, "--package", PACKAGE];
    let mut build = toolchain.cargo(&build);
    build.args(["--target", target.name]).args(more);
    Job::new("Building the library for C").finish(&mut build)?;
    Ok(target_dir().join(target.name).join(PROFILE).join(ARCHIVE))
}

fn programs() -> PathBuf {
    root().join("c/program")
}

/// Returns a call of a C compiler that makes the program.
fn compile(compiler: &str, start: &str, archive: &Path, program: &Path) -> Command {
    let mut compile = Command::new(compiler);
    compile.args(STRICT).arg("-I../include").args(["positions.c", start]).arg(archive);
    compile.arg("-o").arg(program).current_dir(programs());
    compile
}

/// Runs the program, and returns the lines that it prints.
fn lines(run: &mut Command, on: &str) -> Result<Vec<String>, String> {
    let made = run.output().map_err(|error| {
        format!("cannot start the program in C on {on}, or the emulator that runs it: {error}")
    })?;
    // The emulators print semihosting on standard error.
    let text = String::from_utf8_lossy(&[made.stdout, made.stderr].concat()).into_owned();
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if !made.status.success() || lines.len() != TICKS {
        let last = lines.last().map_or("nothing", String::as_str);
        return Err(format!(
            "the program in C on {on} failed ({}) after {} of {TICKS} ticks; it printed last: \
             {last}",
            made.status,
            lines.len()
        ));
    }
    Ok(lines)
}

/// Runs the program on this machine.
fn here(directory: &Path) -> Result<Vec<String>, String> {
    Job::new("Building the library for C, and a program with it, for this machine")
        .run(&mut cargo(&["build", "--quiet", "--package", PACKAGE]))?;
    let archive = target_dir().join("debug").join(ARCHIVE);
    let program = directory.join("positions");
    let mut link = compile("cc", "computer.c", &archive, &program);
    Job::new("Compiling a program in C").finish(link.args(["-lm", "-lpthread", "-ldl"]))?;
    lines(&mut Command::new(program), "this machine")
}

/// Compiles the header alone as C++11, the oldest that Arduino's cores use.
fn header_in_cpp() -> Result<(), String> {
    let mut compile = Command::new("c++");
    if Command::new("c++").arg("--version").output().is_err() {
        println!("== NOT RUN: the header as C++11; it needs c++");
        return Ok(());
    }
    compile.args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++"]);
    Job::new("Compiling the header as C++11").run(compile.arg(root().join("c/include/stiction.h")))
}

/// Compiles and links the program for a core.
fn link(core: &Core, archive: &Path, program: &Path) -> Result<(), String> {
    let [start, script] = core.start;
    let mut link = compile(core.compiler, start, archive, program);
    link.args(BARE).args(core.options).args(["-T", script, "-lgcc"]);
    Job::new("Compiling a program in C").finish(&mut link)
}

/// Returns whether a linked program holds a part of Rust's panics, by the names of its symbols.
fn can_panic(program: &Path) -> Result<bool, String> {
    let image =
        fs::read(program).map_err(|error| format!("cannot read {}: {error}", program.display()))?;
    Ok(image.windows(9).any(|window| window == b"panicking"))
}

/// Runs the program in C on this machine and on emulated microcontrollers.
///
/// # Errors
/// Returns an error if one tick differs, or the linked program can panic.
pub fn test(all: bool) -> Result<(), String> {
    let directory = directory()?;
    header_in_cpp()?;
    let expected = here(&directory)?;
    for (core, target) in cores(all) {
        let name = core.name;
        if !core.is_ready() {
            println!(
                "== NOT RUN: the program in C on {name}; it needs {} and {}",
                core.compiler, core.emulator
            );
            continue;
        }
        println!("== The program in C on an emulated {name}");
        let program = directory.join(name).with_extension("elf");
        link(core, &archive(target, &[])?, &program)?;
        if can_panic(&program)? {
            return Err(format!(
                "the program in C for {name} contains Rust's panic code, so the library can panic; \
                 find the call in c/ or src/ that can panic, and replace it"
            ));
        }
        let mut run = Command::new(core.emulator);
        run.args(core.machine).arg("-kernel").arg(&program).args([
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none",
            "-semihosting-config",
            "enable=on,target=native",
        ]);
        let found = lines(&mut run, name)?;
        let differ = expected.iter().zip(&found).filter(|(one, other)| one != other).count();
        println!("   {differ} of {TICKS} ticks differ from this machine");
        if differ > 0 {
            return Err(format!("{differ} of {TICKS} ticks on {name} differ from this machine"));
        }
    }
    if ARM.is_ready() {
        println!("== The same with a panic in the library, which must be found");
        let program = directory.join("panics.elf");
        let planted = archive(&MICROCONTROLLER, &["--features", "deliberate-panic"])?;
        link(&ARM, &planted, &program)?;
        if !can_panic(&program)? {
            return Err(
                "the search for panics does not work: it has missed one that was put in".into()
            );
        }
    }
    Ok(())
}

/// Directory of what is made here.
fn directory() -> Result<PathBuf, String> {
    let directory = target_dir().join("library");
    fs::create_dir_all(&directory)
        .map_err(|error| format!("cannot make {}: {error}", directory.display()))?;
    Ok(directory)
}

/// Builds and packs the archives of all cores, and returns their paths:
/// target/library/stiction-CORE.tar.gz, beside SHA256SUMS.
pub fn pack() -> Result<Vec<PathBuf>, String> {
    let directory = directory()?;
    let mut packed = Vec::new();
    for (core, target) in cores(true) {
        println!("== The library for {} ({})", core.name, target.name);
        let name = format!("stiction-{}", core.name);
        let content = directory.join(&name);
        fs::create_dir_all(&content)
            .map_err(|error| format!("cannot make {}: {error}", content.display()))?;
        let archive = archive(target, &[])?;
        for (from, to) in [
            (archive, "libstiction.a"),
            (root().join("c/include/stiction.h"), "stiction.h"),
            (root().join("LICENSE-MIT"), "LICENSE-MIT"),
            (root().join("LICENSE-APACHE"), "LICENSE-APACHE"),
        ] {
            fs::copy(&from, content.join(to))
                .map_err(|error| format!("cannot copy {}: {error}", from.display()))?;
        }
        let file = format!("{name}.tar.gz");
        let mut tar = Command::new("tar");
        tar.args(["--create", "--gzip", "--file", &file, &name]).current_dir(&directory);
        Job::new("Packing the library").finish(&mut tar)?;
        println!("{}", directory.join(&file).display());
        packed.push(file);
    }
    let sums = Command::new("sha256sum").args(&packed).current_dir(&directory).output();
    let sums = sums.map_err(|error| format!("cannot start sha256sum: {error}"))?;
    let file = directory.join("SHA256SUMS");
    fs::write(&file, sums.stdout)
        .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    println!("{}", file.display());
    Ok(packed.iter().map(|name| directory.join(name)).collect())
}
