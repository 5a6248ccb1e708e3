//! `cargo xtask studio` builds the page of `stiction studio` by npm, and the program around it.

use crate::job::{Job, cargo, root};
use crate::playground;
use crate::studio_page::{build, needed, options, page, script};

#[derive(Debug, clap::Args)]
pub struct StudioJobArguments {
    /// Build the program with the emulator, for `stiction studio --emulator`
    #[arg(long)]
    with_emulator: bool,
    /// Build the page and the program, and start nothing
    #[arg(long)]
    build: bool,
    /// Make the pictures of docs/ in a browser, and start nothing else
    #[arg(long)]
    picture: bool,
    /// Minutes for which the load of server and page is measured; fails if it is too high; on
    /// Linux
    #[arg(
        long,
        value_name = "MINUTES",
        num_args = 0..=1,
        default_missing_value = "10",
        value_parser = clap::value_parser!(u32).range(2..),
        conflicts_with_all = ["with_emulator", "build", "picture", "arguments"]
    )]
    throughput: Option<u32>,
    /// Build the page with the simulator in it, as static files in target/playground, and start
    /// nothing
    #[arg(
        long,
        conflicts_with_all = ["with_emulator", "build", "picture", "throughput", "arguments"]
    )]
    playground: bool,
    /// Test the playground in a browser as well
    #[arg(long, requires = "playground")]
    test: bool,
    /// Arguments of `stiction studio`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Builds the page and the program, and starts it.
pub fn studio(arguments: &StudioJobArguments) -> Result<(), String> {
    if arguments.playground {
        let directory = playground::build()?;
        return if arguments.test { playground::test(&directory) } else { Ok(()) };
    }
    page()?;
    build(arguments.with_emulator)?;
    if arguments.build {
        return Ok(());
    }
    if arguments.picture {
        let job = Job::new("Making the pictures of docs/");
        let browser = needed("making the pictures")?;
        return job.run(script("pictures.mjs", browser).arg(root().join("docs/pictures")));
    }
    if let Some(minutes) = arguments.throughput {
        let job = Job::new("Measuring the load of the studio");
        let browser = needed("measuring")?;
        return job.run(script("throughput.mjs", browser).arg(minutes.to_string()));
    }
    let mut run = cargo(&["run", "--quiet", "--bin", "stiction"]);
    options(&mut run, arguments.with_emulator);
    Job::new("stiction studio").run(run.args(["--", "studio"]).args(&arguments.arguments))
}
