//! Stands for `stiction studio` in a program that is built without it.

use crate::error::Error;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// What is asked for
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<String>,
}

/// Says how to get it.
///
/// # Errors
/// Always, with the command that builds it.
pub fn studio(_: &Arguments) -> Result<(), Error> {
    let command = "cargo xtask studio";
    Err(Error::Input(format!(
        "studio: the page is not built into this program; `{command}` builds and starts it (it \
         needs npm)"
    )))
}
