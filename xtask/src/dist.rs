//! `cargo xtask dist` packs what a release has: a program for Linux that needs no other file, the
//! wheel, the libraries for C, the images, licences and checksums.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use crate::job::{Job, cargo, root, target_dir};
use crate::simulator::EVERYTHING;
use crate::{firmware, library, licences, python, studio_page};

/// The target of the program. The C library is linked into it.
const TARGET: &str = "x86_64-unknown-linux-gnu";
const STATIC: &str = "-C target-feature=+crt-static -C strip=symbols";

/// Beside the images.
const OF_THE_IMAGES: &str = "\
The images are for the STM32F405 of docs/reference/wiring.md. None has run on real hardware. Both
were run on an emulated STM32F427, a superset, bit for bit like the core on a computer. Read
docs/tutorial/first-board.md and docs/explanation/safety.md before you connect a motor.

stiction-firmware      a joint with one encoder
stiction-two-encoders  a joint with an encoder on the motor and one on the load

    probe-rs download --chip STM32F405RGTx stiction-firmware.elf
";

/// Beside the program.
const TO_START: &str = "\
stiction: positions a geared joint in spite of stick-slip friction, in simulation. Nothing in here
has run on real hardware. In the first minute:

    ./stiction new arm.toml --typical harmonic    # your joint by data sheets
    ./stiction benchmark arm.toml                 # ranks the controllers on it
    ./stiction studio arm.toml                    # moves it in the browser

python/    a wheel for Python 3.11 and newer on Linux: pip install python/*.whl
c/         stiction.h and libstiction.a for four cores
firmware/  the images for an STM32F405; read their NOTE.txt first
";

#[derive(Debug, clap::Args)]
pub struct DistJobArguments {
    /// Unpack the release that was packed into an empty root directory, and rank the controllers of
    /// a joint there (needs root)
    #[arg(long)]
    test: bool,
}

/// Packs a release, or tests the one that was packed.
pub fn run(arguments: &DistJobArguments) -> Result<(), String> {
    if arguments.test { test() } else { pack() }
}

fn name() -> String {
    format!("stiction-{}", env!("CARGO_PKG_VERSION"))
}

fn packed() -> PathBuf {
    target_dir().join("dist").join(name()).with_added_extension("tar.gz")
}

/// Returns the commit of the sources, and whether they differ from it.
fn commit() -> Result<String, String> {
    let git = |arguments: &[&str]| {
        let made = Command::new("git").args(arguments).current_dir(root()).output();
        let made = made.map_err(|error| format!("cannot start git: {error}"))?;
        Ok::<_, String>(String::from_utf8_lossy(&made.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "HEAD"])?;
    let is_clean = git(&["status", "--porcelain"])?.is_empty();
    Ok(if is_clean { commit } else { format!("{commit}, changed") })
}

fn pack() -> Result<(), String> {
    let commit = commit()?;
    if commit.ends_with(", changed") {
        println!("== The sources are not committed, so this is no release: {commit}");
    }
    let directory = target_dir().join("dist").join(name());
    let failed = |error: std::io::Error| format!("cannot make {}: {error}", directory.display());
    if directory.exists() {
        fs::remove_dir_all(&directory).map_err(failed)?;
    }
    for folder in ["python", "c", "firmware"] {
        fs::create_dir_all(directory.join(folder)).map_err(failed)?;
    }
    let mut files = vec![(program(&commit)?, "stiction".to_owned())];
    let mut add = |from: PathBuf, folder: &str| {
        let file = from.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push((from, folder.to_owned() + &file));
    };
    for image in firmware::build_all()? {
        add(image.with_extension("bin"), "firmware/");
        add(image, "firmware/");
    }
    add(python::build()?, "python/");
    library::pack()?.into_iter().for_each(|archive| add(archive, "c/"));
    for text in ["LICENSE-MIT", "LICENSE-APACHE", "CHANGELOG.md"] {
        add(root().join(text), "");
    }
    for (from, to) in &files {
        fs::copy(from, directory.join(to))
            .map_err(|error| format!("cannot copy {}: {error}", from.display()))?;
    }
    for (text, to) in [
        (format!("{TO_START}\nCommit {commit}.\n"), "README.txt"),
        (OF_THE_IMAGES.to_owned(), "firmware/NOTE.txt"),
        (licences::all(TARGET)?, "THIRD-PARTY.txt"),
    ] {
        fs::write(directory.join(to), text).map_err(failed)?;
    }
    sums(&directory)?;
    let mut tar = Command::new("tar");
    tar.args(["--create", "--gzip", "--file"]).arg(packed()).arg(name());
    Job::new("Packing the release").run(tar.current_dir(target_dir().join("dist")))?;
    println!("{}", packed().display());
    Ok(())
}

/// Builds the program with everything in it, and the studio's page.
fn program(commit: &str) -> Result<PathBuf, String> {
    studio_page::page()?;
    let mut build = cargo(&["build", "--release", "--bin", "stiction", "--target", TARGET]);
    // All but `shared-law`: a static program opens no libraries.
    build.args(["--no-default-features", "--features", "figures,report,watch"]);
    build.args(EVERYTHING).env("RUSTFLAGS", STATIC).env("STICTION_COMMIT", commit);
    Job::new("Building the program for Linux").run(&mut build)?;
    Ok(target_dir().join(TARGET).join("release/stiction"))
}

/// Writes the checksum of each file.
fn sums(directory: &Path) -> Result<(), String> {
    let mut sums = Command::new("sh");
    let all = "find . -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs sha256sum > SHA256SUMS";
    Job::new("Checksums").run(sums.args(["-c", all]).current_dir(directory))
}

/// Unpacks the release into an empty root directory, where there is no other program, and runs the
/// program as its README says.
fn test() -> Result<(), String> {
    let packed = packed();
    if !packed.exists() {
        return Err(format!("there is no {}; run `cargo xtask dist` first", packed.display()));
    }
    let empty = target_dir().join("dist/empty");
    let failed = |error: std::io::Error| format!("cannot make {}: {error}", empty.display());
    if empty.exists() {
        fs::remove_dir_all(&empty).map_err(failed)?;
    }
    fs::create_dir_all(&empty).map_err(failed)?;
    let mut unpack = Command::new("tar");
    unpack.args(["--extract", "--strip-components=1", "--file"]).arg(&packed);
    Job::new("Unpacking the release into an empty root").run(unpack.arg("-C").arg(&empty))?;
    let mut check = Command::new("sha256sum");
    Job::new("Checksums")
        .run(check.args(["--check", "--quiet", "SHA256SUMS"]).current_dir(&empty))?;
    let begin = Instant::now();
    for call in [
        &["--version"][..],
        &["new", "arm.toml", "--typical", "harmonic"],
        &["benchmark", "arm.toml"],
    ] {
        let mut inside = Command::new("chroot");
        inside.arg(&empty).arg("/stiction").args(call);
        Job::new("The program in the empty root").run(&mut inside)?;
    }
    println!("   the first ranking took {:.1} s", begin.elapsed().as_secs_f64());
    Job::new("The studio in the empty root").announce();
    let mut studio = Command::new("chroot");
    studio.arg(&empty).args(["/stiction", "studio", "arm.toml", "--no-open"]);
    let studio = studio.stdout(Stdio::piped()).spawn();
    let mut studio = studio.map_err(|error| format!("cannot start the studio: {error}"))?;
    let opened = open(&mut studio);
    // It serves until it is ended.
    let ended = studio.kill().and_then(|()| studio.wait());
    ended.map_err(|error| format!("cannot end the studio: {error}"))?;
    opened
}

/// Loads the page of a studio and the script that it names. A build without npm has neither.
fn open(studio: &mut Child) -> Result<(), String> {
    let mut line = String::new();
    let output = studio.stdout.take().ok_or("the studio has no output")?;
    let read = BufReader::new(output).read_line(&mut line);
    read.map_err(|error| format!("cannot read the studio's output: {error}"))?;
    let address = line.trim().strip_prefix("http://").and_then(|rest| rest.split_once('/'));
    let (address, _) = address.ok_or(format!("the studio printed no address but: {line}"))?;
    for (path, has) in [("/", "<script"), ("/main.js", "WebSocket")] {
        let failed = |error: std::io::Error| format!("cannot load {path} of the studio: {error}");
        let mut connection = TcpStream::connect(address).map_err(failed)?;
        let request =
            format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
        connection.write_all(request.as_bytes()).map_err(failed)?;
        let mut answer = Vec::new();
        connection.read_to_end(&mut answer).map_err(failed)?;
        let answer = String::from_utf8_lossy(&answer);
        if !answer.starts_with("HTTP/1.1 200") || !answer.contains(has) {
            let first = answer.lines().next().unwrap_or_default();
            return Err(format!("{path} of the studio has no {has:?} (its answer: {first})"));
        }
        println!("   {path}: {} bytes", answer.len());
    }
    Ok(())
}
