//! Figs. 5 to 20, 61 and 62: runs of the friction lab, with curves that are declared as data.

use crate::lab::{LabResult, LabSample};
use crate::report::content::{LabDrawing, PanelText, Quantity, drawings};
use crate::report::evidence::ReportEvidence;
use figure::{Figure, NamedFigure, Panel, PlotCurve, Style};
use files::error::Error;

const STYLES: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// Draws all figures whose runs exist.
///
/// # Errors
/// Returns an error if the built-in text is invalid.
pub fn figures(evidence: &ReportEvidence) -> Result<Vec<NamedFigure>, Error> {
    Ok(drawings()?.into_iter().filter_map(|drawing| figure(drawing, evidence)).collect())
}

/// Returns a drawing, or `None` if a run is missing.
fn figure(drawing: LabDrawing, evidence: &ReportEvidence) -> Option<NamedFigure> {
    let panels = drawing.panels.iter().map(|text| panel(text, evidence)).collect::<Option<_>>()?;
    let subtitle = format!("simulated; to compare with {} of the thesis", drawing.thesis);
    let figure = Figure { title: drawing.title, subtitle, x_label: "time (s)".into(), panels };
    Some(NamedFigure { stem: drawing.stem, figure })
}

fn panel(text: &PanelText, evidence: &ReportEvidence) -> Option<Panel> {
    let curves = text.curves.iter().zip(STYLES);
    let lines = curves.map(|((name, run, body, quantity), style)| {
        let points = points(evidence.lab(run)?, body.checked_sub(1)?, *quantity)?;
        Some(PlotCurve::new(name, style, points))
    });
    Some(Panel { height: text.height, ..Panel::new(&text.label, lines.collect::<Option<_>>()?) })
}

fn points(result: &LabResult, body: usize, quantity: Quantity) -> Option<Vec<(f64, f64)>> {
    let speed = || result.plan.setup.mechanism.pull.as_ref().map(|pull| pull.speed_m_per_s);
    let value = |row: &LabSample| match quantity {
        Quantity::Position => row.position.get(body).copied(),
        Quantity::FarEnd => speed().map(|speed| speed * row.time_s),
        Quantity::Velocity => row.velocity.get(body).copied(),
        Quantity::Acceleration => row.acceleration.get(body).copied(),
        Quantity::Input => row.input.get(body).copied(),
        Quantity::Friction => row.friction.get(body).copied(),
        Quantity::Deflection => row.deflection.get(body).map(|p| 1e6 * p),
        Quantity::DeflectionRate => {
            let sticks = *row.stuck.get(body)?;
            if sticks { row.velocity.get(body).map(|v| 1e3 * v) } else { Some(0.0) }
        }
    };
    result.rows.iter().map(|row| Some((row.time_s, value(row)?))).collect()
}
