//! The overwrite guard: the check that every output path passes before the work begins, and once
//! more when it is written.
//!
//! A path is refused if its directory does not exist, if it is a directory, if it cannot be
//! written, or if an existing file must not be replaced: a file that the same command reads, a
//! machine's or an experiment's file, or, for files that a user edits, any file. With `--force`,
//! all of these are replaced. The check neither creates nor truncates a file. A hard link or a
//! symbolic link counts as the file itself.

use std::ffi::OsStr;
use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::file::write_whole;
use files::document::{self, is_machine_file};
use files::error::Error;

/// Path of the standard output.
const STANDARD_OUTPUT: &str = "-";

/// Overwrite rules of one command: the files that it reads, and whether `--force` was given.
#[derive(Clone, Debug, Default)]
pub struct OverwriteGuard {
    force: bool,
    read: Vec<PathBuf>,
}

/// Existing files that an output can replace without `--force`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Replaces {
    /// Earlier results: every file but those that the command reads and those of a machine.
    Results,
    /// No existing file, since the user may have edited it.
    Nothing,
}

impl OverwriteGuard {
    /// Creates the guard of a command that reads no file so far.
    pub const fn new(force: bool) -> Self {
        Self { force, read: Vec::new() }
    }

    /// Adds a file that the command reads.
    #[must_use]
    pub fn reads(mut self, path: impl Into<PathBuf>) -> Self {
        self.read.push(path.into());
        self
    }

    /// Adds an experiment or a machine's file that the command opens by `name`. A built-in
    /// experiment is not a file.
    #[must_use]
    pub fn opens(self, name: &str) -> Self {
        if document::find(name).is_ok() { self } else { self.reads(name) }
    }

    /// Checks the path of a file of results, which replaces earlier results. `option` names the
    /// path in messages.
    ///
    /// # Errors
    /// Returns why the file cannot be written or must not be replaced.
    pub fn results(&self, option: &str, path: &Path) -> Result<OutputFile, Error> {
        self.file(option, path, Replaces::Results)
    }

    /// Checks the path of a file that a user edits, such as a machine's. It replaces nothing
    /// without `--force`.
    ///
    /// # Errors
    /// Returns why the file cannot be written or must not be replaced.
    pub fn new_file(&self, option: &str, path: &Path) -> Result<OutputFile, Error> {
        self.file(option, path, Replaces::Nothing)
    }

    fn file(&self, option: &str, path: &Path, replaces: Replaces) -> Result<OutputFile, Error> {
        let file = OutputFile {
            guard: self.clone(),
            option: option.to_owned(),
            path: path.to_owned(),
            replaces,
        };
        file.check()?;
        Ok(file)
    }

    /// Checks the path of a directory, in which results replace earlier results. A directory that
    /// does not exist is made when its first file is written.
    ///
    /// # Errors
    /// Returns why no file can be written into it.
    pub fn directory(&self, option: &str, path: &Path) -> Result<OutputDirectory, Error> {
        check_directory(path).map_err(|source| unwritable(path, source))?;
        Ok(OutputDirectory {
            guard: self.clone(),
            option: option.to_owned(),
            path: path.to_owned(),
        })
    }

    /// Refuses an existing file that must not be replaced.
    fn check_replaced(&self, option: &str, path: &Path, replaces: Replaces) -> Result<(), Error> {
        if self.force {
            return Ok(());
        }
        let why = if self.read.iter().any(|read| is_same_file(read, path)) {
            "this command reads the file and would overwrite it"
        } else if replaces == Replaces::Nothing && path.is_file() {
            "the file exists"
        } else if is_machine_file(path) {
            "the file describes a machine or an experiment and would be overwritten"
        } else {
            return Ok(());
        };
        Err(Error::Input(format!(
            "{option} {}: {why}; name another file, or add --force",
            path.display()
        )))
    }
}

/// An output file whose path has passed the guard, or the standard output.
#[derive(Clone, Debug)]
pub struct OutputFile {
    guard: OverwriteGuard,
    option: String,
    path: PathBuf,
    replaces: Replaces,
}

impl OutputFile {
    /// Returns whether the file is the standard output, written `-`.
    pub fn is_standard_output(&self) -> bool {
        self.path.as_os_str() == OsStr::new(STANDARD_OUTPUT)
    }

    /// Returns the option or command that named the file.
    pub fn option(&self) -> &str {
        &self.option
    }

    /// Returns the path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file whole or not at all, after another check: the file may have been created
    /// while the command worked.
    ///
    /// # Errors
    /// Returns why the file cannot be written or must not be replaced.
    pub fn write(&self, bytes: &[u8]) -> Result<(), Error> {
        if self.is_standard_output() {
            let mut out = io::stdout().lock();
            out.write_all(bytes)?;
            return Ok(out.flush()?);
        }
        self.check()?;
        write_whole(&self.path, bytes)
    }

    fn check(&self) -> Result<(), Error> {
        if self.is_standard_output() {
            return Ok(());
        }
        self.guard.check_replaced(&self.option, &self.path, self.replaces)?;
        check_file(&self.path).map_err(|source| unwritable(&self.path, source))
    }
}

impl fmt::Display for OutputFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_standard_output() {
            return f.write_str("standard output");
        }
        self.path.display().fmt(f)
    }
}

/// An output directory whose path has passed the guard.
#[derive(Clone, Debug)]
pub struct OutputDirectory {
    guard: OverwriteGuard,
    option: String,
    path: PathBuf,
}

impl OutputDirectory {
    /// Returns the path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks a file of the directory before the work, if its name is already known.
    ///
    /// # Errors
    /// Returns why the file cannot be written or must not be replaced.
    pub fn check(&self, name: &str) -> Result<(), Error> {
        let path = self.path.join(name);
        self.guard.check_replaced(&self.option, &path, Replaces::Results)?;
        // The directory has been checked, and may not exist yet.
        let exists = fs::symlink_metadata(&path).is_ok();
        let checked = if exists { check_file(&path) } else { Ok(()) };
        checked.map_err(|source| unwritable(&path, source))
    }

    /// Writes a file of the directory whole or not at all, and makes the directory if necessary.
    /// Returns the path of the file.
    ///
    /// # Errors
    /// Returns why the file cannot be written or must not be replaced.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, Error> {
        fs::create_dir_all(&self.path).map_err(|source| unwritable(&self.path, source))?;
        self.check(name)?;
        let path = self.path.join(name);
        write_whole(&path, bytes)?;
        Ok(path)
    }
}

fn unwritable(path: &Path, source: io::Error) -> Error {
    Error::File { action: "write", path: path.to_owned(), source }
}

/// Returns whether two paths refer to the same file. Only regular files are opened: a pipe would
/// block, and a serial port would change its control lines.
fn is_same_file(one: &Path, other: &Path) -> bool {
    let canonical = [one, other].map(|path| fs::canonicalize(path).ok());
    // For files that do not exist yet, only the paths can be compared.
    let [Some(one), Some(other)] = canonical else { return one == other };
    one == other
        || [&one, &other].iter().all(|path| path.is_file())
            && same_file::is_same_file(&one, &other).unwrap_or(false)
}

/// Checks whether a file can be written, without creating or truncating it. A pipe or a device is
/// not opened, since that has side effects.
fn check_file(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => return Ok(()),
        Ok(found) if found.permissions().readonly() => {
            return Err(io::Error::other("the file is read-only"));
        }
        Ok(_) => drop(OpenOptions::new().write(true).open(path)?),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    // The file is written next to the target of a link, and renamed.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let directory = directory_of(&target);
    match fs::metadata(directory) {
        Ok(found) if found.is_dir() => tempfile::tempfile_in(directory).map(|_| ()),
        Ok(_) => Err(ErrorKind::NotADirectory.into()),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let directory = directory.display();
            Err(io::Error::other(format!("the directory {directory} does not exist")))
        }
        Err(error) => Err(error),
    }
}

/// Checks whether files can be written into a directory, or into the nearest existing parent, in
/// which it would be created.
fn check_directory(path: &Path) -> io::Result<()> {
    let existing = path.ancestors().find(|path| fs::symlink_metadata(path).is_ok());
    let existing = existing.unwrap_or_else(|| Path::new("."));
    if !fs::metadata(existing)?.is_dir() {
        return Err(ErrorKind::NotADirectory.into());
    }
    tempfile::tempfile_in(existing).map(|_| ())
}

/// Returns the directory that holds a path.
fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}
