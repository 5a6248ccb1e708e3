//! `stiction show`.

use super::print;
use crate::error::Error;
use crate::experiment::find;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A name from `stiction list`
    name: String,
}

pub fn show(arguments: &Arguments) -> Result<(), Error> {
    print(find(&arguments.name)?.toml)
}
