//! Builds the flash images, and the parameters that go beside them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::job::{Job, root, target_dir};
use crate::simulator::Simulator;
use crate::toolchain::{MICROCONTROLLER, TARGET, Toolchain};

/// The profile of the images, and of everything measured or proved beside it.
pub const PROFILE: &str = "firmware";

/// The name of the microcontroller for probe-rs.
const CHIP: &str = "STM32F405RGTx";
/// The binary's name.
const BINARY: &str = "stiction-firmware";

/// A flash image. All are built from the same sources.
#[derive(Clone, Copy, Debug)]
pub enum Image {
    /// For a joint with one encoder.
    OneEncoder,
    /// For a joint with an encoder on the motor and one on the load.
    TwoEncoders,
}

impl Image {
    /// Every image.
    pub const ALL: [Self; 2] = [Self::OneEncoder, Self::TwoEncoders];

    /// The features of the core, with commas between.
    const fn features(self) -> &'static str {
        match self {
            Self::OneEncoder => "board",
            Self::TwoEncoders => "board,two-encoders",
        }
    }

    /// The name of its files in target/firmware, without extension.
    const fn stem(self) -> &'static str {
        match self {
            Self::OneEncoder => "stiction-firmware",
            Self::TwoEncoders => "stiction-two-encoders",
        }
    }

    /// Announcement of the build.
    const fn builds(self) -> &'static str {
        match self {
            Self::OneEncoder => "Building the firmware for one encoder",
            Self::TwoEncoders => "Building the firmware for two encoders",
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct FlashJobArguments {
    /// Write the image for an encoder on the motor and one on the load
    #[arg(long)]
    two_encoders: bool,
}

#[derive(Debug, clap::Args)]
pub struct ParamsJobArguments {
    /// A machine's file, or the name of a built-in experiment
    file: String,
    /// Output file [default: target/firmware/NAME.params]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Set a key of the file, table.key=value; can be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// The arguments that cargo gets for an image. Without the package's name, the features of the
/// host's programs would be unified with those of the image.
pub fn arguments(command: &str, image: Image) -> [&str; 11] {
    let [profile, package, bin, features, target] =
        ["--profile", "--package", "--bin", "--features", "--target"];
    let on = image.features();
    [command, profile, PROFILE, package, "stiction", bin, BINARY, features, on, target, TARGET]
}

/// The path at which cargo puts a program for the microcontroller.
pub fn built(program: &str) -> PathBuf {
    target_dir().join(TARGET).join(PROFILE).join(program)
}

/// The compiler's arguments for the image's own crate, which count for the optimisation across all
/// crates at the link, too.
///
/// The control path has been put together within the core's crate by then, so it stays as fast as
/// it is. Other functions are no longer copied into each caller unless they are small, even those
/// that are marked to be inlined (as in serde and postcard). `tests/evidence/cost.md` has the
/// effect, and the alternatives that were tried.
const SMALL: [&str; 2] = ["-C", "llvm-args=-inline-threshold=25 -inlinehint-threshold=75"];

/// Builds every image, and returns the paths of the ELF files.
pub fn build_all() -> Result<Vec<PathBuf>, String> {
    Image::ALL.into_iter().map(build).collect()
}

/// Builds an image, copies it to target/firmware, and returns the ELF file's path. Cargo puts every
/// image at the same path, so only the copy is certain to be the requested one.
pub fn build(image: Image) -> Result<PathBuf, String> {
    let toolchain = Toolchain::ready(&MICROCONTROLLER)?;
    println!("   compiler: {}", toolchain.describe());
    let mut build = toolchain.cargo(&arguments("rustc", image));
    // The user's settings must not change the image: incremental code is slower than the
    // interrupt's budget.
    build.arg("--").args(SMALL).env("CARGO_INCREMENTAL", "0");
    Job::new(image.builds()).run(&mut build)?;
    let built = built(BINARY);
    let elf =
        fs::read(&built).map_err(|error| format!("cannot read {}: {error}", built.display()))?;
    let directory = target_dir().join("firmware");
    fs::create_dir_all(&directory)
        .map_err(|error| format!("cannot make {}: {error}", directory.display()))?;
    let flash = crate::elf::flash_contents(&elf)?;
    let path = |extension| directory.join(image.stem()).with_extension(extension);
    for (path, bytes) in [(path("elf"), &elf), (path("bin"), &flash)] {
        fs::write(&path, bytes)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        println!("{} ({} bytes)", path.display(), bytes.len());
    }
    Ok(path("elf"))
}

/// Writes an image to a board and shows its log. The file is the one that the emulator runs and
/// the gates check.
pub fn flash(arguments: &FlashJobArguments) -> Result<(), String> {
    let image = build(if arguments.two_encoders { Image::TwoEncoders } else { Image::OneEncoder })?;
    Job::new("Flashing the firmware (needs probe-rs: cargo install probe-rs-tools --locked)")
        .run(Command::new("probe-rs").args(["run", "--chip", CHIP]).arg(image))
}

/// Returns the path of a record that has no path of its own, in a directory that is made for it:
/// `stiction params` makes none.
fn usual_record(target: &Path, machine: &str) -> Result<PathBuf, String> {
    let directory = target.join("firmware");
    fs::create_dir_all(&directory)
        .map_err(|error| format!("cannot make {}: {error}", directory.display()))?;
    let stem = Path::new(machine).file_stem().unwrap_or_default();
    Ok(directory.join(stem).with_extension("params"))
}

/// Encodes a machine's file. The simulator does the work, since it reads these files.
pub fn params(arguments: &ParamsJobArguments) -> Result<(), String> {
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None => usual_record(&target_dir(), &arguments.file)?,
    };
    let here = std::env::current_dir()
        .map_err(|error| format!("there is no current directory: {error}"))?;
    let file = here.join(&arguments.file);
    let file = if file.is_file() { file.into_os_string() } else { arguments.file.clone().into() };
    let mut command = Simulator::Host.command(&["params"]);
    command.current_dir(root()).arg(file).arg("--out").arg(here.join(out));
    for assignment in &arguments.set {
        command.args(["--set", assignment]);
    }
    Simulator::Host.build()?;
    Job::new("Encoding the parameters").run(&mut command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_without_a_path_has_a_directory_also_before_the_first_image() {
        let target = std::env::temp_dir().join(format!("stiction-xtask-{}", std::process::id()));
        let record = usual_record(&target, "machines/joint.toml").unwrap();
        assert_eq!(record, target.join("firmware/joint.params"));
        assert!(target.join("firmware").is_dir());
        fs::remove_dir_all(&target).unwrap();
    }
}
