//! The thesis as one page: its figures and tables beside ours, its misprints, and its claims judged
//! by measurements that are made with the page.
//!
//! `runs` lists the runs, `evidence` runs them, `claims` measures and judges, `figures` draws,
//! `tables` looks up the values used, `beyond` ranks laws that the thesis does not have; the texts
//! are data in `host-sim/thesis/page/`, and `page` fills in the template.

mod beyond;
mod claims;
mod content;
mod evidence;
mod figures;
mod page;
mod runs;
mod tables;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use self::evidence::ReportPlans;
use self::figures::ReportDrawing;
pub use self::page::Tally;
use files::error::Error;
use simulator::output::OutputDirectory;

/// Pixels of a PNG for each unit of its SVG, as of `run --plot`.
const SCALE: f32 = 2.0;

/// Summary of a report that was written.
#[derive(Debug)]
pub struct ReportSummary {
    /// The page.
    pub page: PathBuf,
    /// Number of figures drawn, each as SVG and PNG beside the page.
    pub drawings: usize,
    /// Number of claims by their verdicts.
    pub claims: Tally,
    /// Time that the report took.
    pub wall: Duration,
}

/// File name of the page.
const PAGE: &str = "index.html";

/// Makes the report in a directory: `index.html`, which is self-contained, and its figures as
/// files.
///
/// # Errors
/// Reports what could not be written, or names a drawing or a table's row without a value.
pub fn make(directory: &OutputDirectory) -> Result<ReportSummary, Error> {
    let begin = Instant::now();
    directory.check(PAGE)?;
    let (plans, texts) = (ReportPlans::new()?, content::figures()?);
    // One more drawing is beyond the thesis.
    let drawings = texts.iter().map(|text| text.drawings.len()).sum::<usize>() + 1;
    let bar = bar(plans.len() + drawings);
    let done = rendered(plans, &texts, &bar);
    bar.finish_and_clear();
    let rendered = done?;
    let page = write(directory, &rendered)?;
    Ok(ReportSummary {
        page,
        drawings: rendered.files.len(),
        claims: rendered.claims,
        wall: begin.elapsed(),
    })
}

/// Writes the page last, so that its presence means that all files are there.
fn write(directory: &OutputDirectory, rendered: &Rendered) -> Result<PathBuf, Error> {
    for (stem, svg, png) in &rendered.files {
        directory.write(&format!("{stem}.svg"), svg.as_bytes())?;
        directory.write(&format!("{stem}.png"), png)?;
    }
    directory.write(PAGE, rendered.page.as_bytes())
}

/// The report before it is written.
struct Rendered {
    page: String,
    /// Stem, SVG and PNG of each drawing.
    files: Vec<(String, String, Vec<u8>)>,
    claims: Tally,
}

fn rendered(
    plans: ReportPlans,
    texts: &[content::FigureText],
    bar: &ProgressBar,
) -> Result<Rendered, Error> {
    let begin = Instant::now();
    let evidence = plans.run(bar)?;
    let runs_s = begin.elapsed().as_secs_f64();
    let drawings = figures::drawings(&evidence, texts)?;
    let drawn: Vec<Drawn> = drawings
        .par_iter()
        .flatten()
        .map(|drawing| draw(drawing, bar))
        .collect::<Result<_, _>>()?;
    let mut drawn = drawn.into_iter();
    let (mut inline, mut files) = (Vec::new(), Vec::new());
    for (figure, text) in drawings.iter().zip(texts) {
        let mut of_figure = Vec::new();
        for (i, drawn) in drawn.by_ref().take(figure.len()).enumerate() {
            let title = text.parts.get(i).cloned().unwrap_or_default();
            of_figure.push(figure::page::DrawingView { title, svg: drawn.inline });
            files.push((drawn.stem, drawn.svg, drawn.png));
        }
        inline.push(of_figure);
    }
    let untuned = draw(&beyond::drawing(&evidence)?, bar)?;
    let beyond = beyond::ranked()?;
    let (page, claims) = page::page(&page::PageParts {
        evidence: &evidence,
        figures: texts,
        drawings: &inline,
        tables: &tables::tables(&content::tables()?, &evidence)?,
        misprints: &content::misprints()?,
        beyond: &beyond,
        untuned: &untuned.inline,
        runs_s,
    })?;
    files.push((untuned.stem, untuned.svg, untuned.png));
    Ok(Rendered { page, files, claims })
}

struct Drawn {
    stem: String,
    inline: String,
    svg: String,
    png: Vec<u8>,
}

fn draw(drawing: &ReportDrawing, bar: &ProgressBar) -> Result<Drawn, Error> {
    let named = |error: figure::FigureError| Error::Figure(format!("`{}`: {error}", drawing.stem));
    let figure = &drawing.figure;
    let drawn = Drawn {
        stem: drawing.stem.clone(),
        inline: figure.to_inline_svg(&drawing.stem).map_err(named)?,
        svg: figure.to_svg().map_err(named)?,
        png: figure.to_png(SCALE).map_err(named)?,
    };
    bar.inc(1);
    Ok(drawn)
}

fn bar(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs and figures, {eta} left");
    let bar = ProgressBar::new(steps as u64);
    style.map_or_else(|_| ProgressBar::hidden(), |style| bar.with_style(style))
}
