//! What was tried as charts: sets of gains in planes of two figures each, with their Pareto front.

use super::{Figures, Tuned};
use crate::figure::chart::{Chart, Cloud, LogAxis, Point, Shown};

/// Quantities of a chart: its stem, and of each axis label, decades, a bound and value.
type Plane = (&'static str, [(&'static str, [i32; 2], f64, fn(&Figures) -> f64); 2]);

/// Charts what was tried in three planes: what a step needs, what a motion needs, what both cost.
pub fn charts(file: &str, tuned: &[Tuned]) -> Vec<Chart> {
    let settling: (_, _, _, fn(&Figures) -> f64) =
        ("settling (s)", [-2, 1], 5.0, |of| of.settling_s);
    let rest: (_, _, _, fn(&Figures) -> f64) =
        ("rest error (counts)", [-1, 4], 2.0, |of| of.rest_counts);
    let planes: [Plane; 3] = [
        (
            "tuning",
            [
                settling,
                ("tracking error (counts)", [-1, 4], 2.0, |of| {
                    of.tracking_counts.unwrap_or(f64::NAN)
                }),
            ],
        ),
        ("tuning-chatter", [settling, ("chatter (V/s)", [-2, 3], 1e3, |of| of.chatter_v_per_s)]),
        ("tuning-heat", [rest, ("held effort (V)", [-4, 1], 10.0, |of| of.held_v)]),
    ];
    let has_motion = tuned.iter().any(|one| one.before.tracking_counts.is_some());
    let shown = planes.into_iter().filter(|(stem, _)| has_motion || *stem != "tuning");
    shown
        .map(|(stem, axes)| {
            let [across, up] = axes.map(|(.., of)| of);
            let point = |figures: &Figures| [across(figures), up(figures)];
            let clouds = tuned.iter().flat_map(|one| {
                let of = |what: &str, points| Cloud {
                    name: format!("{}: {what}", one.controller),
                    points,
                };
                let tried: Vec<Point> = one.tried.iter().map(point).collect();
                [
                    of("Pareto front", front(&tried)),
                    of("tried", tried),
                    of("the file's", vec![point(&one.before)]),
                    of("kept", vec![point(&one.after)]),
                ]
            });
            Chart {
                stem: stem.into(),
                title: format!("Gains tried on {file}"),
                subtitle: "simulated; a point is a set of gains, its means over the joints".into(),
                shown: Shown::Clouds {
                    axes: axes.map(|(label, decades, bound, _)| LogAxis {
                        label: label.into(),
                        decades,
                        bound,
                        beyond: String::new(),
                    }),
                    clouds: clouds.collect(),
                },
            }
        })
        .collect()
}

/// The points of which no other is better in one value and as good in the other (Pareto's front).
fn front(points: &[Point]) -> Vec<Point> {
    let beats = |a: &Point, b: &Point| a[0] <= b[0] && a[1] <= b[1] && a != b;
    points.iter().filter(|b| !points.iter().any(|a| beats(a, b))).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_what_nothing_beats_in_both_values() {
        let points = [[1.0, 4.0], [2.0, 2.0], [2.0, 3.0], [4.0, 1.0], [4.0, 4.0]];
        assert_eq!(front(&points), [[1.0, 4.0], [2.0, 2.0], [4.0, 1.0]]);
    }
}
