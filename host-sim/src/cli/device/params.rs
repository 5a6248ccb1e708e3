//! `stiction device params`.

use std::path::{Path, PathBuf};

use stiction::Parameters;

use super::edit;
use super::first_run;
use crate::device::client::Client;
use crate::device::machine_file;
use crate::device::parameters;
use crate::device::wire::Wire;
use crate::error::Error;
use crate::experiment::Document;
use crate::output::OutputFile;

#[derive(Debug, clap::Subcommand)]
pub enum Params {
    /// What is in use
    Show,
    /// Change what is in use in $VISUAL or $EDITOR, as a machine's file
    Edit {
        /// Keep them across a reset, too
        #[arg(long)]
        save: bool,
    },
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
    /// Write what is in use to a file: a machine's TOML, or, if its name does not end in .toml, the
    /// record of the parameter sector
    Pull {
        /// Where to; - for the TOML on the standard output
        file: PathBuf,
        /// Write over a machine's file
        #[arg(long)]
        force: bool,
    },
    /// Keep what is in use across a reset
    Save,
}

/// Carries out the command. A pulled file has the joint of `machine`.
pub fn params<W: Wire>(
    action: &Params,
    client: &mut Client<W>,
    machine: &str,
    output: Option<&OutputFile>,
) -> Result<String, Error> {
    match action {
        Params::Show => machine_file::tables(&client.parameters()?),
        Params::Edit { save } => edit::edit(client, machine, *save),
        Params::Push { machine, controller, save } => {
            let plan = first_run(machine, controller.as_deref())?;
            client.set_parameters(&parameters(&plan)?)?;
            let law = plan.controller.as_deref().unwrap_or("no controller");
            Ok(format!("{machine}, {law}: {}", keep(client, *save)?))
        }
        Params::Pull { file, .. } => {
            let found = client.parameters()?;
            let is_text = output.is_some_and(OutputFile::is_standard_output) || is_toml(file);
            let bytes = if is_text {
                pulled(client, &found, machine)?.into_bytes()
            } else {
                let mut room = [0; stiction::parameters::ROOM];
                found.encode(1, &mut room).unwrap_or_default().to_vec()
            };
            let Some(output) = output else { return Ok(String::new()) };
            output.write(&bytes)?;
            Ok(format!("{output}: {} bytes\n", bytes.len()))
        }
        Params::Save => {
            client.save()?;
            Ok("saved\n".into())
        }
    }
}

/// Saves what is in use if that is wanted, and says how long it lasts.
pub fn keep<W: Wire>(client: &mut Client<W>, save: bool) -> Result<&'static str, Error> {
    if save {
        client.save()?;
        return Ok("in use now, and saved for the next reset\n");
    }
    Ok("in use now, not saved: `params save` keeps them across a reset\n")
}

/// Writes parameters of the device as a machine's file with the joint of `machine`. If the device
/// is no board, the file begins with what it is.
pub fn pulled<W: Wire>(
    client: &Client<W>,
    found: &Parameters,
    machine: &str,
) -> Result<String, Error> {
    let joint = Document::open(machine)?.machine()?.joint;
    let warning = client.warning().map_or(String::new(), |warning| format!("# {warning}\n"));
    Ok(warning + &machine_file::render(found, &joint, machine)?)
}

fn is_toml(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}
