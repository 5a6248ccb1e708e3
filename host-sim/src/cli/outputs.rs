//! Texts beside the files that a command writes: their stream, and their paths.

use std::io::{Write, stderr};

use super::print;
use files::error::Error;
use simulator::output::{OutputDirectory, OutputFile};

/// Refuses two outputs that would mix on the standard output.
pub fn check_standard_output(json: bool, file: Option<&OutputFile>) -> Result<(), Error> {
    match file.filter(|file| json && file.is_standard_output()) {
        None => Ok(()),
        Some(file) => Err(Error::Input(format!(
            "--json and {} - both write to the standard output; name a file",
            file.option()
        ))),
    }
}

/// Prints a text for the user: on the standard output, or on the standard error if the file goes to
/// the standard output.
pub fn print_beside(file: Option<&OutputFile>, text: &str) -> Result<(), Error> {
    if !file.is_some_and(OutputFile::is_standard_output) {
        return print(text);
    }
    stderr().write_all(text.as_bytes())?;
    Ok(())
}

/// Reports a written file on the standard error, since scripts read the standard output. A file on
/// the standard output is not reported.
pub fn wrote(file: &OutputFile) -> Result<(), Error> {
    if !file.is_standard_output() {
        writeln!(stderr(), "wrote {}", file.path().display())?;
    }
    Ok(())
}

/// Reports the number of written figures, and their directory.
pub fn drew(figures: usize, directory: &OutputDirectory) -> Result<(), Error> {
    let figures = if figures == 1 { "1 figure".into() } else { format!("{figures} figures") };
    writeln!(stderr(), "wrote {figures} as SVG and PNG into {}", directory.path().display())?;
    Ok(())
}
