//! Drawings of the thesis's figures.

mod chapter2;

use std::collections::BTreeMap;

use super::content::FigureText;
use super::evidence::ReportEvidence;
use figure::{Figure, NamedFigure, figures};
use files::error::Error;

/// Experiments of the axis whose figures are drawn.
const AXIS: [&str; 5] = [
    "step-response",
    "trajectory",
    "step-added-friction",
    "srnf-robustness",
    "srnf-added-friction",
];

/// One drawing of a figure.
pub struct ReportDrawing {
    /// Name of its files, without an ending: `figure-26-46`, and `figure-26-46-b` for a second
    /// drawing.
    pub stem: String,
    /// The figure.
    pub figure: Figure,
}

/// Returns the drawings of each figure, in the order of `texts`.
///
/// # Errors
/// Returns an error that names a drawing without a run.
pub fn drawings(
    evidence: &ReportEvidence,
    texts: &[FigureText],
) -> Result<Vec<Vec<ReportDrawing>>, Error> {
    let mut all: BTreeMap<String, Figure> = BTreeMap::new();
    let mut add = |more: Vec<NamedFigure>| {
        all.extend(more.into_iter().map(|named| (named.stem, named.figure)))
    };
    for experiment in AXIS.into_iter().chain(["high-gain"]) {
        add(figures(experiment, evidence.axis(experiment), &ReportEvidence::sources(experiment)?));
    }
    add(chapter2::figures(evidence)?);
    let of = |text: &FigureText| {
        text.drawings
            .iter()
            .enumerate()
            .map(|(i, name)| {
                let figure = all.get(name).ok_or_else(|| {
                    let why = evidence.trouble_of_any().unwrap_or("no run makes it");
                    Error::Figure(format!("`{name}`: {why}"))
                })?;
                Ok(ReportDrawing { stem: stem(text, i), figure: figure.clone() })
            })
            .collect::<Result<Vec<_>, Error>>()
    };
    texts.iter().map(of).collect()
}

fn stem(text: &FigureText, i: usize) -> String {
    let numbers: Vec<String> = text.numbers.iter().map(|number| format!("{number:02}")).collect();
    let part = ["", "-b", "-c"].get(i).copied().unwrap_or("-d");
    format!("figure-{}{part}", numbers.join("-"))
}
