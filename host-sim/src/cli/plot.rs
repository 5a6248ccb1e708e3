//! `stiction plot`.

use std::path::PathBuf;

use super::print;
use figure::{NamedFigure, figure_directory, logged, write_figures};
use files::error::Error;
use simulator::output::{OverwriteGuard, series};

#[derive(Debug, clap::Args)]
pub struct PlotArguments {
    /// Files of `stiction run --csv` or of `stiction device ... log`; up to three runs or logs are
    /// drawn over each other
    #[arg(value_name = "FILE.csv", required = true)]
    files: Vec<PathBuf>,
    /// Output directory of the figure (SVG and PNG)
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    force: bool,
    /// A title for the figure
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

pub fn plot(arguments: &PlotArguments) -> Result<(), Error> {
    let stems =
        arguments.files.iter().map(|file| file.file_stem().unwrap_or_default().to_string_lossy());
    let stem = stems.collect::<Vec<_>>().join("-and-");
    let guard = OverwriteGuard::new(arguments.force);
    let guard = arguments.files.iter().fold(guard, OverwriteGuard::reads);
    let out = figure_directory(&guard, "--out", &arguments.out)?;
    ["svg", "png"].iter().try_for_each(|kind| out.check(&format!("{stem}.{kind}")))?;
    let mut all = Vec::new();
    for file in &arguments.files {
        all.extend(series::read(file)?);
    }
    if all.len() > logged::MOST {
        return Err(Error::Input(format!(
            "plot: {} runs; at most {} runs fit in one figure: write fewer with `run --controller` \
             and `--set`, or draw the files one by one",
            all.len(),
            logged::MOST
        )));
    }
    let mut figure = logged::figure(&all);
    if let Some(title) = &arguments.title {
        figure.title.clone_from(title);
    }
    write_figures(&out, &[NamedFigure { stem: stem.clone(), figure }])?;
    let path = arguments.out.join(stem);
    print(&format!("{}.svg and .png\n", path.display()))
}
