//! `stiction completions`.

use clap::CommandFactory;
use clap_complete::Shell;

use super::print;
use files::error::Error;

#[derive(Debug, clap::Args)]
#[command(after_help = "\
For bash, until the shell ends:  source <(stiction completions bash)
For good:                        stiction completions bash > \
                          ~/.local/share/bash-completion/completions/stiction")]
pub struct CompletionsArguments {
    /// The shell that completes commands
    shell: Shell,
}

pub fn completions(arguments: &CompletionsArguments) -> Result<(), Error> {
    let mut script = Vec::new();
    let mut command = super::Arguments::command();
    clap_complete::generate(arguments.shell, &mut command, "stiction", &mut script);
    print(&String::from_utf8_lossy(&script))
}
