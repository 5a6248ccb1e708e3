//! Charts of the tried gains. Each law has a panel with all sets of gains, their Pareto front, the
//! file's gains and the kept gains.
//!
//! All points of a panel are figures on the joints of the search, at the encoder. An axis spans the
//! decades of its values. A panel with a figure that is zero for all gains is left out, and so is a
//! chart without panels.

use super::{TuningFigures, TuningResult};
use figure::chart::{Chart, ChartContent, Layer, LayeredPanel, LogAxis, Mark, Point};
use files::goal::PositionGoal;

/// Default limit on the settling time of a success, s.
const WITHIN_S: f64 = 5.0;

/// Quantity on an axis: label, bound (0: none) and value.
type Quantity = (&'static str, f64, fn(&TuningFigures) -> f64);

/// Plane of a chart: name of its file, and quantities across and up.
type Plane = (&'static str, [Quantity; 2]);

/// Returns the charts of the tried gains in three planes: settling and tracking, settling and
/// chatter, rest error and held effort. One count of the encoder is `count_deg`, deg.
pub fn charts(
    file: &str,
    tuned: &[TuningResult],
    goal: &PositionGoal,
    count_deg: f64,
) -> Vec<Chart> {
    let within_s = goal.settle_s.unwrap_or(WITHIN_S);
    let tolerance = goal.tolerance_counts(count_deg);
    let settling: Quantity = ("settling (s)", within_s, |of| of.at_encoder.settling_s);
    let rest: Quantity = ("rest error (counts)", tolerance, |of| of.at_encoder.rest_counts);
    let tracking: Quantity =
        ("tracking error (counts)", 0.0, |of| of.at_encoder.tracking_counts.unwrap_or(f64::NAN));
    let chatter: Quantity = ("chatter (V/s)", 0.0, |of| of.chatter_v_per_s);
    let held: Quantity = ("held effort (V)", 0.0, |of| of.held_v);
    let planes: [Plane; 3] = [
        ("tuning", [settling, tracking]),
        ("tuning-chatter", [settling, chatter]),
        ("tuning-heat", [rest, held]),
    ];
    planes.iter().filter_map(|plane| chart(file, tuned, plane)).collect()
}

fn chart(file: &str, tuned: &[TuningResult], (stem, quantities): &Plane) -> Option<Chart> {
    let [across, up] = quantities.map(|(.., of)| of);
    let point = |figures: &TuningFigures| [across(figures), up(figures)];
    let panels: Vec<LayeredPanel> = tuned.iter().filter_map(|one| panel(one, point)).collect();
    let all: Vec<Point> = panels
        .iter()
        .flat_map(|panel| &panel.layers)
        .flat_map(|layer| layer.points.iter().copied())
        .collect();
    let axis = |place: usize| {
        let (label, bound, _) = quantities[place];
        let decades = decades(all.iter().map(|point| point[place]), bound)?;
        let label = label.to_owned();
        Some(LogAxis { label, decades, bound, beyond: String::new() })
    };
    let axes = [axis(0)?, axis(1)?];
    let is_bounded = quantities.iter().any(|(_, bound, _)| *bound > 0.0);
    Some(Chart {
        stem: (*stem).into(),
        title: format!("Gains tried on {file}"),
        subtitle:
            "simulated; a point is a set of gains on the joints of the search, at the encoder"
                .into(),
        shown: ChartContent::Layers {
            axes,
            bounds: if is_bounded { "limit of success".into() } else { String::new() },
            panels,
        },
    })
}

/// Returns the panel of a law; `None` if a value is zero or missing for all gains.
fn panel(one: &TuningResult, point: impl Fn(&TuningFigures) -> Point) -> Option<LayeredPanel> {
    let tried: Vec<Point> = one.tried.iter().map(point).collect();
    let is_shown = |place: usize| tried.iter().any(|point| point[place] > 0.0);
    if !(is_shown(0) && is_shown(1)) {
        return None;
    }
    let layer = |name: &str, mark, points| Layer { name: name.into(), mark, points };
    let at = |place: usize| tried.get(place).copied().into_iter().collect::<Vec<_>>();
    // The file's gains are kept if no others are better.
    let (suffix, kept) = match (one.better, one.is_refused()) {
        (true, _) => ("", at(one.kept)),
        (false, false) => (" (the file's gains stay)", at(0)),
        (false, true) => (" (refused)", Vec::new()),
    };
    let layers = vec![
        layer("Pareto front", Mark::Steps, front(&tried)),
        layer("tried", Mark::Dot, tried.clone()),
        layer("the file's", Mark::Square, at(0)),
        layer("kept", Mark::Diamond, kept),
    ];
    Some(LayeredPanel { name: format!("{}{suffix}", one.controller), layers })
}

/// Returns the powers of ten around all values above zero and around a bound; `None` without such a
/// value.
fn decades(values: impl Iterator<Item = f64>, bound: f64) -> Option<[i32; 2]> {
    let shown = |value: &f64| *value > 0.0 && value.is_finite();
    let found: Vec<f64> = values.filter(shown).collect();
    found.first()?;
    let with_bound = found.into_iter().chain((bound > 0.0).then_some(bound));
    let [low, high] = with_bound.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], value| {
        [low.min(value), high.max(value)]
    });
    // The axis reaches down to a millionth of the largest value; smaller values are on its edge.
    let low = low.max(1e-6 * high);
    let [low, high] = [low.log10().floor() as i32, high.log10().ceil() as i32];
    Some([low, high.max(low + 1)])
}

/// Returns the Pareto front, in the order of the first value. A point is on it if no other point is
/// better in one value and at least as good in the other.
fn front(points: &[Point]) -> Vec<Point> {
    let beats = |a: &Point, b: &Point| a[0] <= b[0] && a[1] <= b[1] && a != b;
    let is_first = |b: &&Point| !points.iter().any(|a| beats(a, b));
    let mut front: Vec<Point> = points.iter().filter(is_first).copied().collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    front.dedup();
    front
}

#[cfg(test)]
mod tests {
    use super::super::SideFigures;
    use super::*;

    #[test]
    fn the_front_has_what_nothing_beats_in_both_values() {
        let points = [[1.0, 4.0], [2.0, 2.0], [2.0, 3.0], [4.0, 1.0], [4.0, 4.0]];
        assert_eq!(front(&points), [[1.0, 4.0], [2.0, 2.0], [4.0, 1.0]]);
        // In order, and each once.
        let points = [[4.0, 1.0], [1.0, 4.0], [1.0, 4.0]];
        assert_eq!(front(&points), [[1.0, 4.0], [4.0, 1.0]]);
    }

    fn figures(settling_s: f64, rest_counts: f64, held_v: f64) -> TuningFigures {
        let side = SideFigures { successes: 1, settling_s, tracking_counts: None, rest_counts };
        TuningFigures { cases: 1, at_encoder: side, at_load: side, chatter_v_per_s: 2.0, held_v }
    }

    fn law(controller: &str, held_v: f64) -> TuningResult {
        let [file, other] = [figures(1.0, 4.0, held_v), figures(0.5, 2.0, held_v)];
        TuningResult {
            controller: controller.into(),
            gains: vec![],
            better: true,
            refusal: None,
            before: file,
            after: other,
            tried: vec![file, other],
            kept: 1,
            margins: [1.0, 1.0],
            worst: None,
        }
    }

    fn layered(chart: &Chart) -> (&[LogAxis; 2], &[LayeredPanel]) {
        let ChartContent::Layers { axes, panels, .. } = &chart.shown else { panic!("{chart:?}") };
        (axes, panels)
    }

    #[test]
    fn a_law_has_one_panel_with_all_its_layers_and_a_figure_that_is_always_zero_has_none() {
        let goal = PositionGoal::default();
        let drawn = charts("a.toml", &[law("srnf", 0.1), law("pd", 0.0)], &goal, 0.01);
        // No trajectory: no chart of tracking.
        let stems: Vec<&str> = drawn.iter().map(|chart| &*chart.stem).collect();
        assert_eq!(stems, ["tuning-chatter", "tuning-heat"]);
        let (axes, panels) = layered(&drawn[0]);
        assert_eq!(axes[0].decades, [-1, 1]);
        assert_eq!(panels.iter().map(|panel| &*panel.name).collect::<Vec<_>>(), ["srnf", "pd"]);
        let layers: Vec<(&str, usize)> =
            panels[0].layers.iter().map(|layer| (&*layer.name, layer.points.len())).collect();
        assert_eq!(layers, [("Pareto front", 1), ("tried", 2), ("the file's", 1), ("kept", 1)]);
        assert_eq!(panels[0].layers[3].points, [[0.5, 2.0]]);
        // PD holds nothing.
        let (_, panels) = layered(&drawn[1]);
        assert_eq!(panels.iter().map(|panel| &*panel.name).collect::<Vec<_>>(), ["srnf"]);
        assert!(charts("a.toml", &[law("pd", 0.0)], &goal, 0.01).len() == 1);
    }

    #[test]
    fn the_bound_of_a_rest_error_is_the_goal_in_counts_and_refused_gains_are_not_kept() {
        let goal = PositionGoal { tolerance_deg: Some(0.5), ..PositionGoal::default() };
        let mut refused = TuningResult { better: false, kept: 0, ..law("srnf", 0.1) };
        refused.before.at_load.successes = 0;
        let drawn = charts("a.toml", &[refused], &goal, 0.01);
        let (axes, panels) = layered(&drawn[1]);
        assert!((axes[0].bound - 50.0).abs() < 1e-9, "{axes:?}");
        assert_eq!(axes[0].decades, [0, 2]);
        assert_eq!(panels[0].name, "srnf (refused)");
        assert!(panels[0].layers[3].points.is_empty());
    }

    #[test]
    fn the_file_s_gains_are_the_kept_ones_if_no_others_are_better() {
        let mut kept = TuningResult { better: false, kept: 0, ..law("srnf", 0.1) };
        kept.before.at_load.successes = 1;
        let drawn = charts("a.toml", &[kept], &PositionGoal::default(), 0.01);
        let (_, panels) = layered(&drawn[0]);
        assert_eq!(panels[0].name, "srnf (the file's gains stay)");
        let points = |place: usize| &panels[0].layers[place].points;
        assert!(points(3).len() == 1 && points(3) == points(2), "{:?}", points(3));
    }
}
