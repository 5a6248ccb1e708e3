//! `stiction device params`.

use std::path::PathBuf;

use super::first_run;
use crate::device::client::Client;
use crate::device::wire::Wire;
use crate::device::{parameters, words};
use crate::error::Error;
use crate::output::write_whole;

#[derive(Debug, clap::Subcommand)]
pub enum Params {
    /// What is in use
    Show,
    /// Take those of a machine's file: the device validates all of them before it takes any
    Push {
        /// A name from `stiction list`, or a machine's own TOML file
        machine: String,
        /// Which of its controllers
        #[arg(long, value_name = "NAME")]
        controller: Option<String>,
        /// Keep them across a reset, too
        #[arg(long)]
        save: bool,
    },
    /// Write what is in use to a file, as a record of the parameter sector
    Pull {
        /// Where to
        file: PathBuf,
    },
    /// Keep what is in use across a reset
    Save,
}

pub fn params<W: Wire>(action: &Params, client: &mut Client<W>) -> Result<String, Error> {
    match action {
        Params::Show => {
            let found = client.parameters()?;
            Ok(words::parameters(&found))
        }
        Params::Push { machine, controller, save } => {
            let plan = first_run(machine, controller.as_deref())?;
            client.set_parameters(&parameters(&plan)?)?;
            if *save {
                client.save()?;
            }
            let kept = if *save { "in use and saved" } else { "in use until the next reset; `params save`" };
            Ok(format!("{}: {kept}\n", plan.label))
        }
        Params::Pull { file } => {
            let found = client.parameters()?;
            let mut room = [0; stiction::parameters::ROOM];
            let record = found.encode(1, &mut room).unwrap_or_default();
            write_whole(file, record)?;
            Ok(format!("{}: {} bytes\n", file.display(), record.len()))
        }
        Params::Save => {
            client.save()?;
            Ok("saved\n".into())
        }
    }
}
