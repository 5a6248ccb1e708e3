//! Replaces `stiction studio` in a program that is built without it.

use files::error::Error;

#[derive(Debug, clap::Args)]
pub struct StudioArguments {
    /// All options of the command; ignored
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<String>,
}

/// Refuses the command.
///
/// # Errors
/// Always returns an error, with the command that builds the studio.
pub fn studio(_: &StudioArguments) -> Result<(), Error> {
    let command = "cargo xtask studio";
    Err(Error::Input(format!(
        "studio: this program was built without the page; `{command}` builds and starts it (it \
         needs npm)"
    )))
}
