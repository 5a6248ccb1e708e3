//! `stiction show`.

use super::print;
use files::data_sheet::overview::{DerivedNumber, rows};
use files::error::Error;
use simulator::experiment::{Document, find};

#[derive(Debug, clap::Args)]
pub struct ShowArguments {
    /// A name from `stiction list`; with --units also a machine's own TOML file
    name: String,
    /// Print the joint in both systems of units, with the derivation of each number
    #[arg(long)]
    units: bool,
}

pub fn show(arguments: &ShowArguments) -> Result<(), Error> {
    if arguments.units {
        return print(&units(&Document::open(&arguments.name)?)?);
    }
    print(find(&arguments.name)?.toml)
}

fn units(document: &Document) -> Result<String, Error> {
    let origin = &document.origin;
    let Some((sheet, mapping)) = document.mapping()? else {
        return Err(Error::Input(format!(
            "show --units: {origin} has no data sheet (a table `[motor]`); docs/reference/units.md explains \
             it"
        )));
    };
    let mut text = format!("{:26}{:>24}{:>22}\n", "", "SI", "core");
    for DerivedNumber { what, si, core, how } in rows(&sheet, &mapping) {
        text += &format!("{what:26}{si:>24}{core:>22}\n    {how}\n");
    }
    let doubts: String =
        document.doubts()?.iter().map(|doubt| format!("warning: {doubt}\n")).collect();
    Ok(text + &doubts)
}
