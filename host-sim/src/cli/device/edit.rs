//! `stiction device params edit` writes the parameters in use as a text and opens an editor. The
//! device uses all of the edited parameters or none.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use stiction::link::StateCode;
use stiction::motion::jog::JogBounds;
use stiction::units::value::Table;
use stiction::{Limits, Parameters};

use super::pulled_file::{keep, pulled};
use files::error::Error;
use simulator::device::client::Client;
use simulator::device::machine_file;
use simulator::device::wire::Wire;
use simulator::experiment::Document;

/// Opens the parameters in an editor, and sends them to the device if they have changed.
///
/// # Errors
/// Reports what is wrong, whether anything was sent, and where the text is kept.
pub fn edit<W: Wire>(client: &mut Client<W>, machine: &str, save: bool) -> Result<String, Error> {
    let editor = editor()?;
    // Refused before the user edits anything.
    if client.status()?.state == StateCode::Armed {
        let why = "the motor is driven, and parameters change only while it is off; `stop` first";
        return Err(Error::Refused(format!(
            "params edit: {} is armed: {why}",
            client.wire().name()
        )));
    }
    let before = client.parameters()?;
    let text = pulled(client, &before, machine)?;
    let file = write(&text)?;
    let ran = run(&editor, &file);
    let edited = read(&file);
    if edited.as_ref().is_ok_and(|edited| *edited == text) {
        // The temporary file holds the parameters that the device has, so a failure does no harm.
        let _ = fs::remove_file(&file);
        return ran.map(|()| "nothing was changed, and nothing sent\n".into());
    }
    let kept = |error: &Error, sent: &str| {
        Error::Device(format!("{error}; {sent}, and the text is kept in {}", file.display()))
    };
    let unsent = |error| kept(&error, "nothing was sent");
    let edited = ran.and(edited).map_err(unsent)?;
    let after = understood(&file.display().to_string(), &edited).map_err(unsent)?;
    let changes = machine_file::changes(&before, &after).map_err(unsent)?;
    if changes.is_empty() {
        let _ = fs::remove_file(&file);
        return Ok("no parameter of the device was changed, and nothing sent\n".into());
    }
    client.set_parameters(&after).map_err(|error| match error {
        Error::Refused(_) => kept(&error, "the old parameters are in use"),
        _ => kept(
            &error,
            "it is unknown whether the device uses the new parameters (see `params show`)",
        ),
    })?;
    let _ = fs::remove_file(&file);
    Ok(changes.join("\n") + "\n" + keep(client, save)?)
}

/// Reads the parameters from the text. Every limit and every bound of the jog must be in it: a
/// missing one would be derived from the friction of another machine's joint.
fn understood(name: &str, text: &str) -> Result<Parameters, Error> {
    let parameters = machine_file::read(name, text)?;
    let document = Document::parse(name, text)?;
    let stated = Limits::ABOUT.iter().chain(JogBounds::ABOUT);
    let mut stated = stated.map(|about| format!("{}.{}", about.table, about.name));
    if let Some(key) = stated.find(|key| document.get(key).is_none()) {
        let why = "its default depends on the joint, which a device does not store";
        return Err(Error::Input(format!("{name}: `{key}` is missing, and must be set: {why}")));
    }
    Ok(parameters)
}

fn editor() -> Result<String, Error> {
    let of = |name| std::env::var(name).ok().filter(|editor| !editor.trim().is_empty());
    let none =
        || Error::Input("params edit: set VISUAL or EDITOR to an editor, as in EDITOR=nano".into());
    of("VISUAL").or_else(|| of("EDITOR")).ok_or_else(none)
}

fn write(text: &str) -> Result<PathBuf, Error> {
    let failed = |source| Error::File { action: "write", path: std::env::temp_dir(), source };
    let named =
        tempfile::Builder::new().prefix("stiction-").suffix(".toml").tempfile().map_err(failed)?;
    named.as_file().write_all(text.as_bytes()).map_err(failed)?;
    let (_, path) = named.keep().map_err(|error| failed(error.error))?;
    Ok(path)
}

fn read(file: &Path) -> Result<String, Error> {
    fs::read_to_string(file).map_err(|source| Error::File {
        action: "read",
        path: file.to_owned(),
        source,
    })
}

/// Runs the editor. `editor` is a command with its options, as in `code --wait`; the shell splits
/// it.
fn run(editor: &str, file: &Path) -> Result<(), Error> {
    let mut command = if cfg!(unix) {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(format!("{editor} \"$1\"")).arg("sh");
        shell
    } else {
        let mut words = editor.split_whitespace();
        let mut command = Command::new(words.next().unwrap_or_default());
        command.args(words);
        command
    };
    let status = command.arg(file).status();
    let status = status
        .map_err(|error| Error::Input(format!("params edit: cannot run `{editor}`: {error}")))?;
    if status.success() {
        return Ok(());
    }
    Err(Error::Input(format!("params edit: the editor `{editor}` ended with {status}")))
}
