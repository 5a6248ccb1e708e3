//! `cargo xtask simplefoc DIR` compiles SimpleFOC's unmodified sources into two laws, and compares
//! them with the built-in ones: SimpleFOC's own cascade, tuned here, and `robust` within SimpleFOC
//! by its hook for custom motion control. It writes tests/evidence/simplefoc.md.
//!
//! The cascade has four constants, from which a joint's inertia makes its gains
//! (`host-sim/shared-law/simplefoc/simplefoc_law.cpp`). They are tuned on the seeds of tuning only,
//! as the constants of the rule book are: first 40 points of a Halton sequence (J. Halton,
//! Numerische Mathematik 2 (1960), 84), then three rounds of one constant at a time.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::job::{Job, cargo, root, target_dir};
use crate::simulator::Simulator;

#[derive(Debug, clap::Args)]
pub struct SimplefocJobArguments {
    /// Directory with SimpleFOC's sources (Arduino-FOC), a clone by git
    directory: PathBuf,
}

const PAGE: &str = "tests/evidence/simplefoc.md";
const BEGIN: &str = "<!-- written by `cargo xtask simplefoc` -->\n";
const END: &str = "<!-- end -->";

/// Families of the comparison.
const FAMILIES: &str = "rigid,loaded,gravity,lugre";
/// Joints and seed of the tuning; joints of its second half.
const TUNING: [&str; 2] = ["15", "1000000"];
const REFINED: &str = "40";
/// Joints and seed of the report: those of README.md's table.
const REPORT: [&str; 2] = ["500", "2028"];

/// Name of the cascade in rows.
const CASCADE: &str = "simplefoc-cascade";

/// Constants of the cascade: bandwidth of the velocity loop, Hz; that of the position loop, and
/// rate of the integral, as parts of it; time constant of the velocity's filter, s. Ranges of the
/// search.
type Constants = [f64; 4];
const RANGES: [[f64; 2]; 4] = [[5.0, 150.0], [0.05, 1.0], [0.02, 2.0], [0.0003, 0.02]];
const BASES: [u32; 4] = [2, 3, 5, 7];
const POINTS: u32 = 40;
/// Factors of a constant in the three rounds.
const FACTORS: [f64; 3] = [1.5, 1.28, 1.16];

/// Compiles, tunes, compares and writes the page.
pub fn run(arguments: &SimplefocJobArguments) -> Result<(), String> {
    let sources = arguments.directory.join("src");
    if !sources.join("BLDCMotor.cpp").is_file() {
        return Err(format!(
            "{} has no src/BLDCMotor.cpp; it must be a clone of Arduino-FOC",
            arguments.directory.display()
        ));
    }
    let commit = commit(&arguments.directory)?;
    Simulator::Host.build()?;
    Job::new("Building the library for C").run(&mut cargo(&[
        "build",
        "--quiet",
        "--package",
        "stiction-c",
    ]))?;
    let directory = target_dir().join("simplefoc");
    fs::create_dir_all(&directory)
        .map_err(|error| format!("cannot make {}: {error}", directory.display()))?;
    let cascade = compiled(&sources, &commit, &directory.join("cascade.so"), &[])?;
    let archive = target_dir().join("debug/libstiction_c.a").display().to_string();
    let custom =
        compiled(&sources, &commit, &directory.join("custom.so"), &["-DWITH_STICTION", &archive])?;
    let rows = directory.join("rows.csv");
    Job::new("Tuning SimpleFOC's cascade (some minutes)").announce();
    let search = Search { law: &cascade, rows: &rows };
    let constants = search.best()?;
    Job::new("Comparing it (a minute)").announce();
    let tables = search.stiction(&constants, REPORT, &["pd,pid,robust"], &[&custom])?;
    let text = page(&commit, &constants, &tables);
    let path = root().join(PAGE);
    let old = fs::read_to_string(&path)
        .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let (before, rest) = old.split_once(BEGIN).ok_or(format!("{PAGE} has no line {BEGIN}"))?;
    let (_, after) = rest.split_once(END).ok_or(format!("{PAGE} has no line {END}"))?;
    fs::write(&path, format!("{before}{BEGIN}{text}{END}{after}"))
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    println!("{text}written to {}", path.display());
    Ok(())
}

fn commit(directory: &Path) -> Result<String, String> {
    let mut git = Command::new("git");
    let made = git.args(["describe", "--tags", "--always", "--dirty", "--abbrev=10"]);
    let made = made.current_dir(directory).output();
    let made = made.map_err(|error| format!("cannot start git: {error}"))?;
    let commit = String::from_utf8_lossy(&made.stdout).trim().to_owned();
    if commit.is_empty() {
        Err("git does not know the commit of SimpleFOC".into())
    } else {
        Ok(commit)
    }
}

/// Compiles SimpleFOC's motor as a law, and returns the library.
fn compiled(sources: &Path, commit: &str, library: &Path, more: &[&str]) -> Result<String, String> {
    let ours = root().join("host-sim/shared-law");
    let mut files = vec![ours.join("simplefoc/simplefoc_law.cpp"), sources.join("BLDCMotor.cpp")];
    for directory in ["common", "common/base_classes"] {
        let directory = sources.join(directory);
        let found = fs::read_dir(&directory)
            .map_err(|error| format!("cannot read {}: {error}", directory.display()))?;
        let mut found: Vec<_> = found.flatten().map(|entry| entry.path()).collect();
        found.retain(|path| path.extension().is_some_and(|end| end == "cpp"));
        found.sort();
        files.extend(found);
    }
    let mut compile = Command::new("c++");
    // Their warnings are not ours to fix.
    compile.args(["-std=gnu++17", "-O2", "-w", "-ffp-contract=off", "-shared", "-fPIC"]);
    compile.arg("-DSIMPLEFOC_DISABLE_DEBUG").arg(format!("-DSIMPLEFOC_COMMIT=\"{commit}\""));
    for headers in [&ours.join("simplefoc"), &ours, &root().join("c/include"), sources] {
        compile.arg("-I").arg(headers);
    }
    compile.arg("-I").arg(root().join("examples/simplefoc"));
    // An archive comes after what uses it.
    compile.args(files).args(more).arg("-o").arg(library);
    Job::new("Compiling SimpleFOC's motor as a law").run(&mut compile)?;
    Ok(library.display().to_string())
}

/// Search of the cascade's constants.
struct Search<'a> {
    law: &'a str,
    rows: &'a Path,
}

impl Search<'_> {
    /// Runs an ensemble with the cascade, and returns what it prints.
    fn stiction(
        &self,
        constants: &Constants,
        [cases, seed]: [&str; 2],
        controllers: &[&str],
        laws: &[&str],
    ) -> Result<String, String> {
        let rows = self.rows.display().to_string();
        let mut arguments = vec!["ensemble", "--plant", FAMILIES, "--markdown", "--force"];
        arguments.extend(["--cases", cases, "--seed", seed, "--csv", &rows, "--controller"]);
        arguments.extend(controllers);
        for law in [&self.law].into_iter().chain(laws) {
            arguments.extend(["--law", law]);
        }
        let mut run = Simulator::Host.command(&arguments);
        let constants = constants.map(|one| one.to_string()).join(",");
        run.env("SIMPLEFOC_CONSTANTS", constants).stderr(Stdio::null());
        let made = run.output().map_err(|error| format!("cannot start stiction: {error}"))?;
        if !made.status.success() {
            return Err(format!("stiction {} failed", arguments.join(" ")));
        }
        Ok(String::from_utf8_lossy(&made.stdout).into_owned())
    }

    /// Returns the cost of constants: the share of joints without success, and a hundredth of the
    /// mean decades of rest, which orders constants of the same success.
    fn cost(&self, constants: &Constants, cases: &str) -> Result<f64, String> {
        self.stiction(constants, [cases, TUNING[1]], &["pd"], &[])?;
        let text = fs::read_to_string(self.rows)
            .map_err(|error| format!("cannot read {}: {error}", self.rows.display()))?;
        let mut lines = text.lines().skip(1);
        let titles: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let column = |name: &str| {
            let place = titles.iter().position(|title| *title == name);
            place.ok_or(format!("the rows have no column `{name}`"))
        };
        let [law, success, rest] =
            [column("law")?, column("success_at_encoder")?, column("rest_counts")?];
        let (mut joints, mut cost) = (0.0, 0.0);
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let cell = |place: usize| cells.get(place).copied().unwrap_or_default();
            if cell(law) != CASCADE {
                continue;
            }
            let rest: f64 = cell(rest).parse().unwrap_or(f64::INFINITY);
            joints += 1.0;
            cost += 0.01 * (1.0 + rest.min(1e4)).log10();
            cost += if cell(success) == "true" { 0.0 } else { 1.0 };
        }
        if joints == 0.0 {
            Err("the rows have no joint under the cascade".into())
        } else {
            Ok(cost / joints)
        }
    }

    /// Returns the best constants.
    fn best(&self) -> Result<Constants, String> {
        let mut best = (f64::INFINITY, [0.0; 4]);
        for number in 1..=POINTS {
            let mut point = [0.0; 4];
            for ((value, [low, high]), base) in point.iter_mut().zip(RANGES).zip(BASES) {
                *value = low * (high / low).powf(halton(number, base));
            }
            let cost = self.cost(&point, TUNING[0])?;
            if cost < best.0 {
                best = (cost, point);
            }
        }
        best.0 = self.cost(&best.1, REFINED)?;
        for factor in FACTORS {
            for place in 0..best.1.len() {
                for factor in [factor, 1.0 / factor] {
                    let mut point = best.1;
                    point.iter_mut().skip(place).take(1).for_each(|value| *value *= factor);
                    let cost = self.cost(&point, REFINED)?;
                    if cost < best.0 {
                        best = (cost, point);
                    }
                }
            }
        }
        Ok(best.1)
    }
}

/// Returns the number with the digits of `number` to a base behind the point, in reverse order.
fn halton(mut number: u32, base: u32) -> f64 {
    let (mut place, mut sum) = (1.0, 0.0);
    while number > 0 {
        place /= f64::from(base);
        sum += place * f64::from(number % base);
        number /= base;
    }
    sum
}

fn page(commit: &str, [f, rp, ri, tf]: &Constants, tables: &str) -> String {
    let mut text = format!(
        "SimpleFOC {commit}; {} joints of each family, seed {}.\n\n\
         Constants of the tuned cascade:\n\n\
         - bandwidth of the velocity loop f = {f:.1} Hz\n\
         - bandwidth of the position loop rp = {rp:.2} f\n\
         - rate of the velocity's integral ri = {ri:.3} f\n\
         - time constant of the velocity's filter Tf = {:.1} ms\n\n",
        REPORT[0],
        REPORT[1],
        1e3 * tf
    );
    for line in tables.lines().take_while(|line| line.is_empty() || line.starts_with('|')) {
        let _ = writeln!(text, "{line}");
    }
    text.trim_end().to_owned() + "\n\n"
}
