//! Figures as files.

use std::path::Path;

use rayon::prelude::*;

use super::write_whole;
use crate::error::Error;
use crate::figure::NamedFigure;

/// Pixels of the PNG for each unit of the SVG: 1800 pixels wide, 300 to the inch on a six inch column.
const SCALE: f32 = 2.0;

/// Writes each figure as SVG and PNG into a directory. All are drawn before the first is written.
///
/// # Errors
/// Names the figure that could not be drawn, or the file that could not be written.
pub fn write_figures(directory: &Path, figures: &[NamedFigure]) -> Result<(), Error> {
    let draw = |named: &NamedFigure| {
        let svg = named.figure.to_svg()?;
        let png = named.figure.to_png(SCALE)?;
        Ok((svg, png))
    };
    let drawn: Vec<(String, Vec<u8>)> = figures
        .par_iter()
        .map(|named| {
            draw(named)
                .map_err(|error: crate::figure::Error| Error::Figure(format!("`{}`: {error}", named.stem)))
        })
        .collect::<Result<_, _>>()?;
    for (named, (svg, png)) in figures.iter().zip(&drawn) {
        write_whole(&directory.join(format!("{}.svg", named.stem)), svg.as_bytes())?;
        write_whole(&directory.join(format!("{}.png", named.stem)), png)?;
    }
    Ok(())
}
