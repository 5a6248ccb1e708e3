//! `stiction plot`.

use std::path::PathBuf;

use super::print;
use crate::error::Error;
use crate::figure::{NamedFigure, logged, prepare_figures, write_figures};
use crate::output::series;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Files of `stiction run --csv` or of `stiction device ... log`; up to three runs or logs are
    /// drawn over each other
    #[arg(value_name = "FILE.csv", required = true)]
    files: Vec<PathBuf>,
    /// Where the figure is written, as SVG and PNG
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// A title for the figure
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

pub fn plot(arguments: &Arguments) -> Result<(), Error> {
    let mut all = Vec::new();
    for file in &arguments.files {
        all.extend(series::read(file)?);
    }
    if all.len() > logged::MOST {
        return Err(Error::Input(format!(
            "plot: {} runs; at most {} are told apart in one figure: write fewer with `run \
             --controller` and `--set`, or \
             draw the files one by one",
            all.len(),
            logged::MOST
        )));
    }
    prepare_figures(&arguments.out)?;
    let stems =
        arguments.files.iter().map(|file| file.file_stem().unwrap_or_default().to_string_lossy());
    let stem = stems.collect::<Vec<_>>().join("-and-");
    let mut figure = logged::figure(&all);
    if let Some(title) = &arguments.title {
        figure.title.clone_from(title);
    }
    write_figures(&arguments.out, &[NamedFigure { stem: stem.clone(), figure }])?;
    let path = arguments.out.join(stem);
    print(&format!("{}.svg and .png\n", path.display()))
}
