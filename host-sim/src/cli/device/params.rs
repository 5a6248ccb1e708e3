//! `stiction device params`.

use std::path::{Path, PathBuf};

use super::pulled_file::{keep, pulled};
use super::{edit, first_run};
use files::error::Error;
use simulator::device::client::Client;
use simulator::device::wire::Wire;
use simulator::device::{annotated, parameters};
use simulator::output::OutputFile;

#[derive(Debug, clap::Subcommand)]
pub enum ParamsAction {
    /// Show the parameters in use
    Show,
    /// Edit the parameters in use in $VISUAL or $EDITOR, as a machine's file
    Edit {
        /// Save them for the next reset, too
        #[arg(long)]
        save: bool,
    },
    /// Send those of a machine's file: the device validates all of them before it uses any
    Push {
        /// A name from `stiction list`, or a machine's own TOML file
        machine: String,
        /// Controller of that file
        #[arg(long, value_name = "NAME")]
        controller: Option<String>,
        /// Save them for the next reset, too
        #[arg(long)]
        save: bool,
    },
    /// Write the parameters in use to a file: a machine's TOML, or, if its name does not end in
    /// .toml, the record of the parameter sector
    Pull {
        /// Output file; - for the TOML on the standard output
        file: PathBuf,
        /// Write over a machine's file
        #[arg(long)]
        force: bool,
    },
    /// Save the parameters in use for the next reset
    Save,
}

/// Executes the command. A pulled file has the joint of `machine`.
pub fn params<W: Wire>(
    action: &ParamsAction,
    client: &mut Client<W>,
    machine: &str,
    output: Option<&OutputFile>,
) -> Result<String, Error> {
    match action {
        ParamsAction::Show => annotated::tables(&client.parameters()?),
        ParamsAction::Edit { save } => edit::edit(client, machine, *save),
        ParamsAction::Push { machine, controller, save } => {
            let plan = first_run(machine, controller.as_deref())?;
            client.set_parameters(&parameters(&plan)?)?;
            let law = plan.controller.as_deref().unwrap_or("no controller");
            Ok(format!("{machine}, {law}: {}", keep(client, *save)?))
        }
        ParamsAction::Pull { file, .. } => {
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
        ParamsAction::Save => {
            client.save()?;
            Ok("saved\n".into())
        }
    }
}

fn is_toml(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}
