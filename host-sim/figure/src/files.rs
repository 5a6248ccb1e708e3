//! Figures as files: SVG and PNG.

use std::path::Path;

#[cfg(feature = "figures")]
use rayon::prelude::*;

use super::NamedFigure;
use super::chart::Chart;
use files::error::Error;
use simulator::output::{OutputDirectory, OverwriteGuard};

/// Checks the directory for figures before the runs, with the guard of the command.
///
/// # Errors
/// Returns an error that names the path, or the command that builds the drawing in.
pub fn figure_directory(
    guard: &OverwriteGuard,
    option: &str,
    path: &Path,
) -> Result<OutputDirectory, Error> {
    let directory = guard.directory(option, path)?;
    if !cfg!(feature = "figures") {
        write_figures(&directory, &[])?;
    }
    Ok(directory)
}

/// Replaces the drawing of figures in a program without the feature `figures`.
///
/// # Errors
/// Always returns an error, with the command that builds the drawing in.
#[cfg(not(feature = "figures"))]
pub fn write_figures(directory: &OutputDirectory, _: &[NamedFigure]) -> Result<(), Error> {
    let option = format!("figures in {}", directory.path().display());
    Err(files::missing_part::not_built(&option, "what draws them is", "figures"))
}

/// Replaces the drawing of charts in a program without the feature `figures`.
///
/// # Errors
/// Always returns an error, with the command that builds the drawing in.
#[cfg(not(feature = "figures"))]
pub fn write_charts(directory: &OutputDirectory, _: &[Chart]) -> Result<(), Error> {
    write_figures(directory, &[])
}

/// Draws a chart as an SVG document; `None` in a program without the feature `figures`.
pub fn chart_svg(chart: &Chart) -> Option<String> {
    #[cfg(feature = "figures")]
    return Some(super::marks::svg(chart));
    #[cfg(not(feature = "figures"))]
    {
        let _ = chart;
        None
    }
}

/// Pixels of the PNG for each unit of the SVG: 1800 pixels wide, 300 to the inch on a six inch
/// column.
#[cfg(feature = "figures")]
const SCALE: f32 = 2.0;

/// Writes each figure as SVG and PNG into a directory. All are drawn before the first is written.
///
/// # Errors
/// Returns an error that names the figure that could not be drawn, or the file that could not be
/// written.
#[cfg(feature = "figures")]
pub fn write_figures(directory: &OutputDirectory, figures: &[NamedFigure]) -> Result<(), Error> {
    let draw = |named: &NamedFigure| {
        let svg = named.figure.to_svg()?;
        let png = named.figure.to_png(SCALE)?;
        Ok((svg, png))
    };
    let drawn: Vec<(String, Vec<u8>)> = figures
        .par_iter()
        .map(|named| {
            draw(named).map_err(|error: super::FigureError| {
                Error::Figure(format!("`{}`: {error}", named.stem))
            })
        })
        .collect::<Result<_, _>>()?;
    for (named, (svg, png)) in figures.iter().zip(&drawn) {
        directory.write(&format!("{}.svg", named.stem), svg.as_bytes())?;
        directory.write(&format!("{}.png", named.stem), png)?;
    }
    Ok(())
}

/// Writes each chart as SVG and PNG into a directory.
///
/// # Errors
/// Returns an error that names the chart that could not be drawn, or the file that could not be
/// written.
#[cfg(feature = "figures")]
pub fn write_charts(directory: &OutputDirectory, charts: &[Chart]) -> Result<(), Error> {
    for chart in charts {
        let svg = super::marks::svg(chart);
        let png = super::raster::png(&svg, SCALE)
            .map_err(|error| Error::Figure(format!("`{}`: {error}", chart.stem)))?;
        directory.write(&format!("{}.svg", chart.stem), svg.as_bytes())?;
        directory.write(&format!("{}.png", chart.stem), &png)?;
    }
    Ok(())
}
