//! Charts of ramps and sines: the error of each law over speed or frequency, a chart a family.

use super::follow::{BAND_COUNTS, FollowSummary};
use super::follow_sine::SinesSummary;
use super::statistics::SortedValues;
use figure::chart::{Chart, ChartContent, Layer, LayeredPanel, LogAxis, Mark};

/// Errors of a law on the motions of a family; each motion has a place on the horizontal axis.
struct Curve<'a> {
    family: &'a str,
    law: &'a str,
    motions: Vec<(f64, &'a SortedValues)>,
}

/// Returns a chart of the largest errors of ramps for each family.
pub fn follow_charts(summaries: &[FollowSummary]) -> Vec<Chart> {
    let curves = summaries.iter().map(|FollowSummary { family, law, ramps }| {
        let motions = ramps.iter().map(|ramp| (ramp.counts_per_s, &ramp.peak_counts)).collect();
        Curve { family, law, motions }
    });
    let speed = axis("speed of the set point (counts/s)", [0, 3], 0.0, "");
    let error = axis("largest error (counts)", [-1, 4], BAND_COUNTS, "trips");
    charts(&curves.collect::<Vec<_>>(), "ramps", &[speed, error], "no steps below")
}

/// Returns a chart of the rms errors of sines for each family.
pub fn sine_charts(summaries: &[SinesSummary]) -> Vec<Chart> {
    let curves = summaries.iter().map(|SinesSummary { family, law, sines }| {
        let motions = sines.iter().map(|sine| (sine.hz, &sine.rms_mrad)).collect();
        Curve { family, law, motions }
    });
    let frequency = axis("frequency of the set point (Hz)", [-1, 1], 0.0, "");
    let error = axis("rms error (mrad)", [-2, 3], 0.0, "trips");
    charts(&curves.collect::<Vec<_>>(), "sines", &[frequency, error], "")
}

fn axis(label: &str, decades: [i32; 2], bound: f64, beyond: &str) -> LogAxis {
    LogAxis { label: label.into(), decades, bound, beyond: beyond.into() }
}

fn charts(curves: &[Curve], motions: &str, axes: &[LogAxis; 2], bounds: &str) -> Vec<Chart> {
    let chart = |of_family: &[Curve]| {
        let family = of_family.first()?.family;
        Some(Chart {
            stem: format!("{motions}-{family}"),
            title: format!("How closely {family} joints follow {motions}"),
            subtitle: "simulated; on the upper edge a monitor ends the motion".into(),
            shown: ChartContent::Layers {
                axes: axes.clone(),
                bounds: bounds.into(),
                panels: of_family.iter().map(panel).collect(),
            },
        })
    };
    curves.chunk_by(|a, b| a.family == b.family).filter_map(chart).collect()
}

fn panel(curve: &Curve) -> LayeredPanel {
    let layer = |name: &str, mark: Mark, share: f64| Layer {
        name: name.into(),
        mark,
        points: curve
            .motions
            .iter()
            .filter_map(|(at, errors)| Some([*at, errors.quantile(share)?]))
            .collect(),
    };
    LayeredPanel {
        name: curve.law.into(),
        layers: vec![
            layer("median joint", Mark::Diamond, 0.5),
            layer("9 of 10 joints", Mark::Square, 0.9),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::super::follow::{FollowedRamp, RAMPS, follow_summaries};
    use super::*;

    /// Two families under two laws; the second joint trips.
    #[test]
    fn a_family_has_a_chart_a_law_a_panel_and_each_ramp_a_point() {
        let row = |family: &str, law: &str, case: u64, counts_per_s: f64| FollowedRamp {
            family: family.into(),
            law: law.into(),
            case,
            counts_per_s,
            rms_counts: None,
            peak_counts: (case == 0).then_some(2.0 * counts_per_s),
            stops: 0,
            fault: None,
        };
        let mut rows = Vec::new();
        for (family, law) in [("rigid", "pd"), ("rigid", "pid"), ("lugre", "pd")] {
            rows.extend((0..2).flat_map(|case| RAMPS.map(|speed| row(family, law, case, speed))));
        }
        let charts = follow_charts(&follow_summaries(&rows));
        let stems: Vec<&str> = charts.iter().map(|chart| &*chart.stem).collect();
        assert_eq!(stems, ["ramps-rigid", "ramps-lugre"]);
        let ChartContent::Layers { panels, axes, .. } = &charts[0].shown else { panic!() };
        let names: Vec<&str> = panels.iter().map(|panel| &*panel.name).collect();
        assert_eq!(names, ["pd", "pid"]);
        let [median, most] = &panels[1].layers[..] else { panic!("two layers") };
        assert_eq!(median.points, RAMPS.map(|speed| [speed, 2.0 * speed]));
        assert_eq!(most.points, RAMPS.map(|speed| [speed, f64::INFINITY]));
        assert_eq!(axes[1].bound, 2.5);
    }
}
