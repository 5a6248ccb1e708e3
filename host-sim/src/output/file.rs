//! Files that are written whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::error::Error;

/// Writes a file under its name only once all of it has been written. What is not a regular file (a pipe, a device)
/// is written to directly.
///
/// # Errors
/// Names the path.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let special = fs::metadata(path).is_ok_and(|found| !found.is_file());
    let written = if special { fs::write(path, bytes) } else { write_beside_and_rename(path, bytes) };
    written.map_err(|source| Error::File { action: "write", path: path.to_owned(), source })
}

/// Makes a directory, and a file in it for a moment: a directory that cannot be written to is found out before
/// the work is done.
///
/// # Errors
/// Names the path.
pub fn prepare_directory(path: &Path) -> Result<(), Error> {
    fs::create_dir_all(path)
        .and_then(|()| tempfile::tempfile_in(path))
        .map(|_| ())
        .map_err(|source| Error::File { action: "write", path: path.to_owned(), source })
}

fn write_beside_and_rename(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let mut beside =
        tempfile::NamedTempFile::new_in(parent.map_or_else(|| PathBuf::from("."), Path::to_owned))?;
    beside.write_all(bytes)?;
    let readable_by_all = io_permissions(&beside);
    readable_by_all?;
    beside.persist(path).map(|_| ()).map_err(|error| error.error)
}

/// A temporary file is private; the result should be like any other file that the user makes.
#[cfg(unix)]
fn io_permissions(file: &tempfile::NamedTempFile) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file().set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn io_permissions(_file: &tempfile::NamedTempFile) -> io::Result<()> {
    Ok(())
}
