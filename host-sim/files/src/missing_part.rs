//! What a program says of an option that needs a part which is not built in.

use crate::error::Error;

/// Names the option, the part, and the command that builds it in.
pub fn not_built(option: &str, part: &str, feature: &str) -> Error {
    let more = if feature == "emulator" { " --ignore-rust-version" } else { "" };
    let command = format!("cargo install --path host-sim --locked --features {feature}{more}");
    Error::Input(format!(
        "{option}: {part} not built into this program; in the project's directory, `{command}` \
         builds it in"
    ))
}
