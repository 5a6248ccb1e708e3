//! A figure of time series that were written before: logs of a device, runs, or one beside the
//! other.

use super::{Figure, Line, Panel, Style};
use crate::output::series::{Sample, Series};

/// The roles of the curves that are compared in one panel; no more are told apart in print.
const COMPARED: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// So many series fit one figure.
pub const MOST: usize = COMPARED.len();

/// Displacement, error and effort of up to [`MOST`] series over each other; of a single one, the
/// parts of its effort as well.
pub fn figure(series: &[Series]) -> Figure {
    let curves = |of: fn(&Sample) -> Option<f64>| -> Vec<Line> {
        let shown = series.iter().zip(COMPARED);
        shown.map(|(one, style)| Line::new(one.name.clone(), style, points(one, of))).collect()
    };
    let mut displacements = curves(|sample| Some(sample.position_deg));
    for (i, one) in series.iter().take(MOST).enumerate() {
        let name = if i == 0 { "reference" } else { "" };
        displacements.push(Line::new(
            name,
            Style::Reference,
            points(one, |sample| sample.reference_deg),
        ));
    }
    let mut panels = vec![
        Panel::new("displacement (deg)", displacements),
        Panel::new("error (deg)", curves(|sample| sample.error_deg)),
    ];
    if let [one] = series {
        for (name, style, of) in PARTS {
            panels.push(effort(name, vec![Line::new(name, style, points(one, of)).held()]));
        }
    } else {
        let held = curves(|sample| Some(sample.v_v)).into_iter().map(Line::held).collect();
        panels.push(effort("v", held));
    }
    // A ramp has no reference and no controller.
    panels.retain(|panel| panel.lines.iter().any(|line| !line.points.is_empty()));
    Figure {
        title: series.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(" and "),
        subtitle: String::new(),
        x_label: "time (s)".into(),
        panels,
    }
}

type Part = (&'static str, Style, fn(&Sample) -> Option<f64>);

/// Of the effort: signals that chatter would hide each other in one panel.
const PARTS: [Part; 3] = [
    ("v_PD", Style::Primary, |sample| sample.v_pd_v),
    ("v_c", Style::Compensation, |sample| sample.v_c_v),
    ("v", Style::Total, |sample| Some(sample.v_v)),
];

fn effort(name: &str, lines: Vec<Line>) -> Panel {
    Panel { height: 0.62, ..Panel::new(format!("{name} (V)"), lines) }
}

fn points(series: &Series, of: fn(&Sample) -> Option<f64>) -> Vec<(f64, f64)> {
    series.samples.iter().filter_map(|sample| Some((sample.time_s, of(sample)?))).collect()
}
