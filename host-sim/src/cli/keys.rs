//! `stiction keys`.

use super::print;
use files::error::Error;
use files::keys;

#[derive(Debug, clap::Args)]
pub struct KeysArguments {
    /// Only this table, as in `limits` or `controller.srnf`
    table: Option<String>,
    /// Print a JSON schema, by which an editor completes and checks a file
    #[arg(long, conflicts_with_all = ["table", "markdown"])]
    schema: bool,
    /// Print the page docs/reference/parameters.md
    #[arg(long, conflicts_with = "table")]
    markdown: bool,
    /// Print the table of docs/reference/faults.md
    #[arg(long, conflicts_with_all = ["table", "markdown", "schema"])]
    faults: bool,
}

/// Prints the keys, or the selected page.
pub fn keys(arguments: &KeysArguments) -> Result<(), Error> {
    if arguments.schema {
        let text = serde_json::to_string_pretty(&keys::schema());
        return print(&(text.map_err(|error| Error::Input(error.to_string()))? + "\n"));
    }
    if arguments.faults {
        return print(&keys::faults());
    }
    if arguments.markdown {
        return print(&keys::markdown());
    }
    print(&keys::list(arguments.table.as_deref())?)
}
