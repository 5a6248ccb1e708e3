//! Figs. 5 to 20, 61 and 62: runs of the friction lab. What is in them is data.

use serde::Deserialize;

use crate::error::Error;
use crate::figure::{Figure, NamedFigure, Panel, PlotCurve, Style};
use crate::lab::{LabResult, LabSample};
use crate::report::content::{Drawing, PanelText, drawings};
use crate::report::evidence::Evidence;

/// What a curve shows of a body.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Its position.
    Position,
    /// Of the spring's far end, which moves at constant speed.
    FarEnd,
    /// Its velocity.
    Velocity,
    /// Its acceleration.
    Acceleration,
    /// The force that friction and inertia balance.
    Input,
    /// Its friction.
    Friction,
    /// p of the Reset Integrator, µm.
    Deflection,
    /// Its rate, mm/s: that of the body while it sticks, else zero (eq. 2).
    DeflectionRate,
}

const STYLES: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// All that the runs allow.
///
/// # Errors
/// If the built-in text is broken.
pub fn figures(evidence: &Evidence) -> Result<Vec<NamedFigure>, Error> {
    Ok(drawings()?.into_iter().filter_map(|drawing| figure(drawing, evidence)).collect())
}

/// Nothing if a run is missing.
fn figure(drawing: Drawing, evidence: &Evidence) -> Option<NamedFigure> {
    let panels = drawing.panels.iter().map(|text| panel(text, evidence)).collect::<Option<_>>()?;
    let subtitle = format!("simulated; to compare with {} of the thesis", drawing.thesis);
    let figure = Figure { title: drawing.title, subtitle, x_label: "time (s)".into(), panels };
    Some(NamedFigure { stem: drawing.stem, figure })
}

fn panel(text: &PanelText, evidence: &Evidence) -> Option<Panel> {
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
