//! Figure of recorded time series: logs of a device, runs, or a comparison of both.

use super::{Figure, InsetRange, Panel, PlotCurve, Style};
use simulator::output::series::{Series, SeriesSample};

/// The roles of the curves that are compared in one panel; no more can be distinguished in print.
const COMPARED: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

/// Largest number of series in a figure.
pub const MOST: usize = COMPARED.len();

/// Returns a figure of displacement, error and effort of up to [`MOST`] series; of a single one,
/// with the parts of its effort as well.
pub fn figure(series: &[Series]) -> Figure {
    let curves = |of: fn(&SeriesSample) -> Option<f64>| -> Vec<PlotCurve> {
        let shown = series.iter().zip(COMPARED);
        shown.map(|(one, style)| PlotCurve::new(one.name.clone(), style, points(one, of))).collect()
    };
    let mut displacements = curves(|sample| Some(sample.position_deg));
    for (i, one) in series.iter().take(MOST).enumerate() {
        let name = if i == 0 { "reference" } else { "" };
        displacements.push(PlotCurve::new(
            name,
            Style::Reference,
            points(one, |sample| sample.reference_deg),
        ));
    }
    let errors = curves(|sample| sample.error_deg);
    let inset = at_rest(&errors);
    let mut panels = vec![
        Panel::new("displacement (deg)", displacements),
        Panel { inset, ..Panel::new("error (deg)", errors) },
    ];
    if let [one] = series {
        for (name, style, of) in PARTS {
            panels.push(effort(name, vec![PlotCurve::new(name, style, points(one, of)).held()]));
        }
    } else {
        let held = curves(|sample| Some(sample.v_v)).into_iter().map(PlotCurve::held).collect();
        panels.push(effort("v", held));
    }
    // A ramp has no reference and no controller; PD alone has no v_c.
    panels.retain(|panel| panel.lines.iter().any(|line| !line.points.is_empty()));
    if !panels.iter().all(Panel::is_zero) {
        panels.retain(|panel| !panel.is_zero());
    }
    Figure {
        title: series.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(" and "),
        subtitle: String::new(),
        x_label: "time (s)".into(),
        panels,
    }
}

/// Smallest ratio of a panel's range to that of its inset; below it, there is no inset.
const LEAST_ZOOM: f64 = 4.0;

/// Returns the window of the errors at rest. It starts when all curves stay within 1.25 times the
/// largest error in the second half of the time. `None` if the whole panel shows these errors as
/// well.
fn at_rest(errors: &[PlotCurve]) -> Option<InsetRange> {
    let points = || errors.iter().flat_map(|line| line.points.iter().copied());
    let end_s = points().map(|(time_s, _)| time_s).reduce(f64::max)?;
    let largest = |from_s: f64| {
        let some = points().filter(|(time_s, _)| *time_s >= from_s);
        some.map(|(_, error)| error.abs()).fold(0.0, f64::max)
    };
    let half = 1.25 * largest(0.5 * end_s);
    let begin_s = points()
        .filter(|(_, error)| error.abs() > half)
        .map(|(time_s, _)| time_s)
        .fold(0.0, f64::max);
    (half > 0.0 && largest(0.0) > LEAST_ZOOM * half)
        .then_some(InsetRange { time: (begin_s, end_s), values: (-half, half) })
}

type Part = (&'static str, Style, fn(&SeriesSample) -> Option<f64>);

/// Parts of the effort, one per panel: in one panel, chattering signals would hide each other.
const PARTS: [Part; 3] = [
    ("v_PD", Style::Primary, |sample| sample.v_pd_v),
    ("v_c", Style::Compensation, |sample| sample.v_c_v),
    ("v", Style::Total, |sample| Some(sample.v_v)),
];

fn effort(name: &str, lines: Vec<PlotCurve>) -> Panel {
    Panel { height: 0.62, ..Panel::new(format!("{name} (V)"), lines) }
}

fn points(series: &Series, of: fn(&SeriesSample) -> Option<f64>) -> Vec<(f64, f64)> {
    series.samples.iter().filter_map(|sample| Some((sample.time_s, of(sample)?))).collect()
}
