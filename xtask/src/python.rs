//! `cargo xtask python` builds the wheel of the package for Python. Its tests compare the package
//! with the command line; `--all` also installs the wheel, checks the types and executes the
//! notebook.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use crate::job::{Job, cargo, root, target_dir};

/// The package of the native module, and its library without prefix and suffix.
const PACKAGE: &str = "stiction-python";
const LIBRARY: &str = "stiction_python";

/// Largest size of a wheel, bytes.
const LARGEST: u64 = 3_000_000;

/// What a test needs: an interpreter of version 3.11 or newer that makes environments.
const IS_USABLE: &str = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";

#[derive(Debug, clap::Args)]
pub struct PythonJobArguments {
    /// Instead, test the package, its wheel, its types and its notebook
    #[arg(long)]
    test: bool,
}

/// Builds the wheel, or tests it.
pub fn run(arguments: &PythonJobArguments) -> Result<(), String> {
    if arguments.test {
        return test(true, &[]);
    }
    println!("{}", build()?.display());
    Ok(())
}

/// Builds the wheel, and returns its path.
///
/// # Errors
/// Returns an error with what is missing, or what failed.
pub fn build() -> Result<PathBuf, String> {
    if !is_usable() {
        return Err(NEEDED.into());
    }
    wheel(&Environment::ready("python-build", "requirements-all.txt")?)
}

const NEEDED: &str = "the package for Python needs python3 of version 3.11 or newer with venv \
                      (`apt install python3-venv`)";

fn is_usable() -> bool {
    let python = Command::new("python3").args(["-c", IS_USABLE]).output();
    python.is_ok_and(|made| made.status.success())
}

/// An environment of Python below target/.
struct Environment(PathBuf);

impl Environment {
    /// Makes an environment, or takes the one that exists, with the packages of a list.
    fn ready(name: &str, list: &str) -> Result<Self, String> {
        let environment = Self::new(name)?;
        environment.install(&["--requirement", list])?;
        Ok(environment)
    }

    fn new(name: &str) -> Result<Self, String> {
        let directory = target_dir().join(name);
        if !directory.join("bin/python").exists() {
            let mut make = Command::new("python3");
            make.args(["-m", "venv"]).arg(&directory);
            Job::new("Making an environment of Python").run(&mut make)?;
        }
        Ok(Self(directory))
    }

    fn install(&self, what: &[&str]) -> Result<(), String> {
        let mut install = self.python();
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        Job::new("Fetching the packages of Python's tests").run(install.args(what))
    }

    /// Returns a call of the interpreter in the folder of the package.
    fn python(&self) -> Command {
        let mut python = Command::new(self.0.join("bin/python"));
        python.current_dir(root().join("python")).env_remove("PYTHONPATH");
        python
    }

    /// Returns a call of the tests, which compare with the command line.
    fn tests(&self) -> Command {
        let mut tests = self.python();
        tests.args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"]);
        // In the folder of the package its sources would hide the built one.
        tests.current_dir(root().join("python/tests"));
        tests.env("STICTION", target_dir().join("debug/stiction"));
        tests.env("PYTHONDONTWRITEBYTECODE", "1");
        tests
    }
}

/// Tests the package; the build has `options`.
///
/// # Errors
/// Returns an error if a test fails, or the wheel is too large.
pub fn test(all: bool, options: &[&str]) -> Result<(), String> {
    if !is_usable() {
        println!("== NOT RUN: the tests of the package for Python; {NEEDED}");
        return Ok(());
    }
    let mut build = cargo(&["build", "--package", PACKAGE, "--package", "host-sim"]);
    Job::new("Building the package for Python").run(build.args(options))?;
    let package = beside()?;
    let environment = Environment::ready("python-test", "requirements.txt")?;
    Job::new("Tests of the package for Python")
        .run(environment.tests().env("PYTHONPATH", package))?;
    if all { of_the_wheel() } else { Ok(()) }
}

/// Copies the package of Python's sources and the native module into one folder, and returns the
/// folder above.
fn beside() -> Result<PathBuf, String> {
    let above = target_dir().join("python-package");
    let package = above.join("stiction");
    let failed = |error: std::io::Error| format!("cannot make {}: {error}", package.display());
    if package.exists() {
        fs::remove_dir_all(&package).map_err(failed)?;
    }
    fs::create_dir_all(&package).map_err(failed)?;
    for source in fs::read_dir(root().join("python/stiction")).map_err(failed)? {
        let source = source.map_err(failed)?;
        if source.file_type().map_err(failed)?.is_file() {
            fs::copy(source.path(), package.join(source.file_name())).map_err(failed)?;
        }
    }
    let library = format!("debug/{DLL_PREFIX}{LIBRARY}{DLL_SUFFIX}");
    fs::copy(target_dir().join(library), package.join("_native.abi3.so")).map_err(failed)?;
    Ok(above)
}

/// Builds the wheel in an environment, and returns its path.
fn wheel(environment: &Environment) -> Result<PathBuf, String> {
    let wheels = target_dir().join("wheels");
    let begin = Instant::now();
    let mut build = environment.python();
    build.args(["-m", "maturin", "build", "--release", "--quiet", "--out"]).arg(&wheels);
    build.env("CARGO_TARGET_DIR", target_dir());
    Job::new("Building the wheel").run(&mut build)?;
    println!("   it took {:.0} s", begin.elapsed().as_secs_f64());
    let newest = fs::read_dir(&wheels)
        .map_err(|error| format!("cannot read {}: {error}", wheels.display()))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "whl"))
        .max_by_key(|path| fs::metadata(path).and_then(|found| found.modified()).ok());
    newest.ok_or_else(|| format!("there is no wheel in {}", wheels.display()))
}

/// Installs the wheel into an environment of its own, tests it there, checks the types and
/// executes the notebook.
fn of_the_wheel() -> Result<(), String> {
    let build = Environment::ready("python-build", "requirements-all.txt")?;
    let wheel = wheel(&build)?;
    let size = fs::metadata(&wheel).map_err(|error| error.to_string())?.len();
    println!("   {} has {size} bytes", wheel.display());
    if size > LARGEST {
        return Err(format!(
            "the wheel (Python package) has {size} bytes; must be at most {LARGEST}"
        ));
    }
    let path = wheel.to_string_lossy();
    build.install(&["--force-reinstall", "--no-deps", &path])?;
    Job::new("Tests of the wheel").run(&mut build.tests())?;
    let mut types = build.python();
    types.args(["-m", "mypy", "--strict", "--cache-dir"]).arg(target_dir().join("mypy"));
    Job::new("Types of the package").run(types.arg("stiction"))?;
    notebook(&build)
}

/// Executes the notebook; the executed copy and its pictures are below target/.
fn notebook(environment: &Environment) -> Result<(), String> {
    let executed = target_dir().join("notebook/your_joint.ipynb");
    let mut execute = environment.python();
    // Its own folder: that of the package would hide the wheel.
    execute.current_dir(root().join("python/notebook"));
    execute.args(["execute.py", "your_joint.ipynb"]).arg(&executed);
    Job::new("Execution of the notebook").run(&mut execute)?;
    println!("   {}", executed.display());
    Ok(())
}
