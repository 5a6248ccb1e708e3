//! Writes files completely or not at all.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use files::error::Error;

/// Writes a temporary file, and renames it when it is complete. A pipe or a device is written
/// directly.
///
/// # Errors
/// Returns an error with the path. A closed pipe is reported as an error of the standard output.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let special = fs::metadata(path).is_ok_and(|found| !found.is_file());
    let written =
        if special { fs::write(path, bytes) } else { write_beside_and_rename(path, bytes) };
    written.map_err(|source| match source.kind() {
        ErrorKind::BrokenPipe => Error::Output(source),
        _ => Error::File { action: "write", path: path.to_owned(), source },
    })
}

fn write_beside_and_rename(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // A link such as /dev/stdout stays, and its target is replaced.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    // A temporary file is private; the result must have the usual permissions of the user's umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut beside = builder.tempfile_in(parent.unwrap_or_else(|| Path::new(".")))?;
    beside.write_all(bytes)?;
    beside.persist(path).map(|_| ()).map_err(|error| error.error)
}
