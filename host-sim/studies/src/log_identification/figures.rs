//! Figures of an identification: fit and residual over time, and friction over velocity.

use super::IdentifiedMachine;
use super::model::RegressionSample;
use figure::{Figure, NamedFigure, Panel, PlotCurve, Style};

/// Largest number of points of a curve.
const DRAWN: usize = 6_000;

/// Number of cells of the velocity, each way.
const CELLS: usize = 24;

/// Least number of rows in a cell.
const FEWEST: usize = 12;

/// Returns the figures; `log` is the name of the log.
pub fn figures(log: &str, identified: &IdentifiedMachine) -> Vec<NamedFigure> {
    vec![
        NamedFigure { stem: format!("{log}-fit"), figure: over_time(log, identified) },
        NamedFigure { stem: format!("{log}-friction"), figure: over_velocity(log, identified) },
    ]
}

fn subtitle(identified: &IdentifiedMachine) -> String {
    let parameters: Vec<String> = identified
        .parameters
        .iter()
        .map(|(name, found)| {
            let unit = identified.scale.unit_of(name);
            format!("{} {} {unit}", name.replace('_', " "), super::output::short(found.value))
        })
        .collect();
    parameters.join(", ")
}

/// Figure of effort and model, residual, position and free run over time.
fn over_time(log: &str, identified: &IdentifiedMachine) -> Figure {
    let (effort, position) = (identified.scale.effort_unit(), identified.scale.position_unit());
    let moments = &identified.moments;
    let apart = apart(moments);
    let stride = moments.len().div_ceil(DRAWN).max(1);
    let series = |of: &dyn Fn(&RegressionSample) -> f64| -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for at in moments.iter().step_by(stride) {
            let ends = points.last().is_some_and(|(t, _)| at.time_s - t > apart * stride as f64);
            if ends {
                points.push((at.time_s, f64::NAN));
            }
            points.push((at.time_s, of(at)));
        }
        points
    };
    let model =
        |at: &RegressionSample| identified.fitted.fit.predict(&identified.fitted.model.columns(at));
    let kept = &identified.free_run.kept;
    let stride = kept.len().div_ceil(DRAWN).max(1);
    let runs = |place: usize| -> Vec<(f64, f64)> {
        let points = kept.iter().enumerate();
        let drawn = points.filter(|(i, point)| i % stride == 0 || point[1].is_nan());
        drawn.map(|(_, point)| (point[0], point[place])).collect()
    };
    Figure {
        title: format!("{log}: logged and identified"),
        subtitle: subtitle(identified),
        x_label: "time (s)".into(),
        panels: vec![
            Panel::new(
                format!("effort ({effort})"),
                vec![
                    PlotCurve::new("logged, in motion", Style::Primary, series(&|at| at.effort)),
                    PlotCurve::new("identified", Style::Second, series(&model)),
                ],
            ),
            Panel {
                height: 0.62,
                ..Panel::new(
                    format!("residual ({effort})"),
                    vec![PlotCurve::new("", Style::Total, series(&|at| at.effort - model(at)))],
                )
            },
            Panel {
                y_range: around(kept),
                ..Panel::new(
                    format!("position ({position})"),
                    vec![
                        PlotCurve::new("logged", Style::Primary, runs(1)),
                        PlotCurve::new(
                            "identified, driven by the logged effort",
                            Style::Second,
                            runs(2),
                        ),
                    ],
                )
            },
        ],
    }
}

/// Returns the range of the logged position, extended by half of it on either side, if the free run
/// leaves the extended range; `None` otherwise.
fn around(kept: &[[f64; 3]]) -> Option<(f64, f64)> {
    let finite = kept.iter().filter(|point| !point[1].is_nan());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| {
        (low.min(point[1]), high.max(point[1]))
    });
    let half = 0.5 * (high - low);
    let shown = (low - half, high + half);
    let leaves = kept.iter().any(|point| point[2] < shown.0 || point[2] > shown.1);
    (leaves && half > 0.0).then_some(shown)
}

/// Returns the largest time between neighbouring rows, s: four times the median. Between rows that
/// are farther apart, samples were left out.
fn apart(moments: &[RegressionSample]) -> f64 {
    let mut steps: Vec<f64> = moments.windows(2).map(|two| two[1].time_s - two[0].time_s).collect();
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    4.0 * *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Figure of the effort without inertia and gravity over the velocity: its median, its 10 to 90 %
/// band, and the identified friction.
fn over_velocity(log: &str, identified: &IdentifiedMachine) -> Figure {
    let (effort, position) = (identified.scale.effort_unit(), identified.scale.position_unit());
    let fitted = &identified.fitted;
    let friction = |at: &RegressionSample| {
        at.effort - fitted.inertia() * at.acceleration - fitted.gravity(at.position)
    };
    let fast = identified.moments.iter().map(|at| at.velocity.abs()).fold(0.0, f64::max);
    let mut lines: [Vec<(f64, f64)>; 3] = Default::default();
    for way in [-1.0, 1.0] {
        let mut cells: Vec<Vec<[f64; 2]>> = vec![Vec::new(); CELLS];
        for at in identified.moments.iter().filter(|at| at.velocity * way > 0.0) {
            let cell = (at.velocity.abs() / fast * CELLS as f64) as usize;
            cells[cell.min(CELLS - 1)].push([at.velocity, friction(at)]);
        }
        if way < 0.0 {
            cells.reverse();
        }
        for cell in cells.iter_mut().filter(|cell| cell.len() >= FEWEST) {
            let velocity = cell.iter().map(|[v, _]| v).sum::<f64>() / cell.len() as f64;
            cell.sort_by(|a, b| a[1].total_cmp(&b[1]));
            for (line, part) in lines.iter_mut().zip([0.1, 0.5, 0.9]) {
                line.push((velocity, cell[(part * cell.len() as f64) as usize][1]));
            }
        }
        // No curve through standstill.
        lines.iter_mut().for_each(|line| line.push((0.0, f64::NAN)));
    }
    let [low, median, high] = lines;
    let side = |way: f64| (0..=100).map(move |i| way * fast * (0.002 + 0.00998 * f64::from(i)));
    let curve = side(-1.0).map(|v| (v, fitted.friction(v)));
    let mut model: Vec<(f64, f64)> = curve.collect();
    model.reverse();
    model.push((0.0, f64::NAN));
    model.extend(side(1.0).map(|v| (v, fitted.friction(v))));
    Figure {
        title: format!("{log}: friction over velocity"),
        subtitle: subtitle(identified),
        x_label: format!("velocity ({position}/s)"),
        panels: vec![Panel {
            height: 1.6,
            ..Panel::new(
                format!("effort without inertia ({effort})"),
                vec![
                    PlotCurve::new("logged, 10 to 90 %", Style::Total, low),
                    PlotCurve::new("", Style::Total, high),
                    PlotCurve::new("logged, median", Style::Primary, median),
                    PlotCurve::new("identified", Style::Second, model),
                ],
            )
        }],
    }
}
