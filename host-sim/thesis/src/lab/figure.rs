//! The figure of a friction run: what the thesis shows of each, under each other.

use std::path::Path;

use super::run::LabResult;
use figure::{Figure, NamedFigure, Panel, PlotCurve, Style};
use files::setup::{LabFigureSource, Setup};

/// Roles of the bodies' curves.
const BODIES: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// One figure a run; one that diverged has none, since its last values fit no axis.
pub fn figures(experiment: &str, setup: &Setup, results: &[LabResult]) -> Vec<NamedFigure> {
    let prefix = Path::new(experiment).file_stem().unwrap_or_default().to_string_lossy();
    let shown = results.iter().filter(|result| result.diverged_at_s.is_none());
    shown
        .map(|result| NamedFigure {
            stem: format!("{prefix}-{}", result.plan.label.replace('/', "-")),
            figure: figure(result, setup),
        })
        .collect()
}

fn figure(result: &LabResult, setup: &Setup) -> Figure {
    let turns = setup.mechanism.kind.turns();
    let (length, force) = if turns { ("rad", "N m") } else { ("m", "N") };
    let several = result.plan.bodies() > 1;
    let panel = |label: String, of: fn(&super::LabSample) -> &Vec<f64>| {
        let curves = (0..result.plan.bodies()).zip(BODIES).map(|(i, style)| {
            let name = match (several, turns) {
                (false, _) => String::new(),
                (true, true) => format!("joint {}", i + 1),
                (true, false) => format!("block {}", i + 1),
            };
            let points = result.rows.iter().map(|row| (row.time_s, of(row)[i])).collect();
            PlotCurve::new(name, style, points)
        });
        Panel::new(label, curves.collect())
    };
    let panels = vec![
        panel(format!("position ({length})"), |row| &row.position),
        panel(format!("input ({force})"), |row| &row.input),
        panel(format!("acceleration ({length}/s\u{b2})"), |row| &row.acceleration),
        panel(format!("velocity ({length}/s)"), |row| &row.velocity),
        panel(format!("friction ({force})"), |row| &row.friction),
    ];
    let source = setup.figures.iter().find(|source| source.of == result.plan.model);
    let subtitle = match source {
        Some(LabFigureSource { thesis, .. }) => format!(
            "simulated; to compare with {thesis} of the \
            thesis"
        ),
        None => "simulated".into(),
    };
    let title = format!("{}: {}", setup.title, result.plan.label);
    Figure { title, subtitle, x_label: "time (s)".into(), panels }
}
