//! Error for an option that needs a part which is not built into the program.

use crate::error::Error;

/// Returns an error that names the option, the part, and the command that builds the part in.
pub fn not_built(option: &str, part: &str, feature: &str) -> Error {
    let more = if feature == "emulator" { " --ignore-rust-version" } else { "" };
    let command = format!("cargo install --path host-sim --locked --features {feature}{more}");
    Error::Input(format!(
        "{option}: {part} not built into this program; in the project's directory, `{command}` \
         builds it in"
    ))
}
