//! `stiction list`.

use serde::Serialize;

use super::print;
use files::error::Error;
use simulator::experiment::{Document, builtins};

#[derive(Debug, clap::Args)]
pub struct ListArguments {
    /// One JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Entry {
    name: &'static str,
    source: String,
    title: String,
}

#[derive(Serialize)]
struct Listing {
    schema: u32,
    experiments: Vec<Entry>,
}

pub fn list(arguments: &ListArguments) -> Result<(), Error> {
    let mut experiments = Vec::new();
    for builtin in builtins() {
        let document = Document::parse(builtin.name, builtin.toml)?;
        let (source, title) = if document.is_lab() {
            let setup = document.setup()?;
            (setup.source, setup.title)
        } else {
            let machine = document.machine()?;
            (machine.source, machine.title)
        };
        experiments.push(Entry { name: builtin.name, source, title });
    }
    if arguments.json {
        let text = serde_json::to_string_pretty(&Listing { schema: 1, experiments });
        return print(&(text.map_err(|error| Error::Input(error.to_string()))? + "\n"));
    }
    let mut text = String::new();
    for Entry { name, source, title } in experiments {
        text += &format!("{name:25}{source}\n    {title}\n");
    }
    print(&text)
}
