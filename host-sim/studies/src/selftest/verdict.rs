//! Compares the measured figures with the predicted ranges.
//!
//! ```text
//! least = min - m, most = max + m,   m = max((max - min) / 4, s)
//! ```
//!
//! min and max are the least and largest figure of the N predicted joints: that of the file, and
//! those drawn around it. If the real joint is drawn like them, it is one of N + 1 equal draws. So
//! without the margin it is outside of a bound with a probability of 1 / (N + 1), which is 1 in 25
//! for N = 24. There are ten bounds: six figures have one, two have two. The margin m reduces this
//! probability, since the keys, and so the figures, have bounded ranges; by how much has not been
//! computed. `s` is the smallest margin: smaller differences do not matter, or are beyond the
//! accuracy of the simulation.
//!
//! Only the two efforts have a lower bound. A joint that rests nearer and settles sooner than
//! predicted is fine, but one that needs less effort is another joint.

use super::measures::SessionFigures;
use super::prediction::Prediction;

/// Margin as a share of the predicted range.
const MARGIN: f64 = 0.25;

/// Relative accuracy of a simulated effort: a sagging supply, a warm winding and losses of the
/// bridge are not simulated.
const EFFORT_SHARE: f64 = 0.05;

/// Check of a figure against its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfTestCheck {
    /// Name in JSON, with its unit.
    pub name: &'static str,
    /// Name in text.
    pub words: &'static str,
    /// Measured value; `None` if no move has it.
    pub measured: Option<f64>,
    /// Least, median and largest value of the predicted joints.
    pub predicted: [f64; 3],
    /// Lower bound, if any.
    pub least: Option<f64>,
    /// Upper bound.
    pub most: f64,
}

impl SelfTestCheck {
    /// Returns the number of decimals in text.
    pub fn digits(&self) -> usize {
        if self.name.ends_with("_v") || self.name.ends_with("_s") { 3 } else { 0 }
    }

    /// Returns whether the figure is within its bounds; false if it was not measured.
    pub fn passes(&self) -> bool {
        self.measured.is_some_and(|value| {
            value <= self.most && self.least.is_none_or(|least| value >= least)
        })
    }
}

/// A figure: names, value, smallest margin (absolute, and as a share of the median), and whether it
/// has a lower bound.
type VerdictRow = (&'static str, &'static str, fn(&SessionFigures) -> Option<f64>, [f64; 2], bool);

const ROWS: [VerdictRow; 8] = [
    ("missed_moves", "moves that did not settle", |of| Some(of.missed.into()), [0.0, 0.0], false),
    ("settling_s", "settling, mean (s)", |of| of.settled_s, [0.1, 0.0], false),
    ("rest_counts", "rest error, largest (counts)", |of| Some(of.rest_counts), [1.0, 0.0], false),
    ("reversals", "reversals at rest", |of| Some(of.reversals.into()), [2.0, 0.0], false),
    ("sticks_in_motion", "stops on the way", |of| Some(of.sticks.into()), [2.0, 0.0], false),
    ("held_v", "held effort, rms (V)", |of| Some(of.held_v), [0.01, EFFORT_SHARE], false),
    ("sliding_v", "sliding effort, mean (V)", |of| of.sliding_v, [0.01, EFFORT_SHARE], true),
    (
        "accelerating_v",
        "accelerating effort, mean (V)",
        |of| of.accelerating_v,
        [0.01, EFFORT_SHARE],
        true,
    ),
];

/// Returns the checks of measured figures. A figure that no predicted joint has is left out.
pub fn verdict(measured: &SessionFigures, prediction: &Prediction) -> Vec<SelfTestCheck> {
    checks(Some(measured), prediction)
}

/// Returns the bounds of every figure before the measurement.
pub fn bounds(prediction: &Prediction) -> Vec<SelfTestCheck> {
    checks(None, prediction)
}

fn checks(measured: Option<&SessionFigures>, prediction: &Prediction) -> Vec<SelfTestCheck> {
    ROWS.into_iter()
        .filter_map(|(name, words, of, [size, share], is_bounded_below)| {
            let mut all: Vec<f64> = prediction.figures.iter().filter_map(of).collect();
            all.sort_by(f64::total_cmp);
            let (low, high) = (*all.first()?, *all.last()?);
            let median = *all.get(all.len() / 2)?;
            let margin = (MARGIN * (high - low)).max(size).max(share * median.abs());
            Some(SelfTestCheck {
                name,
                words,
                measured: measured.and_then(of),
                predicted: [low, median, high],
                least: is_bounded_below.then_some(low - margin),
                most: high + margin,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_the_range_and_a_quarter_or_what_is_not_worth_a_word() {
        let of = |settled_s, sliding_v| SessionFigures {
            settled_s: Some(settled_s),
            sliding_v: Some(sliding_v),
            ..SessionFigures::default()
        };
        let prediction = Prediction {
            figures: vec![of(0.2, 1.0), of(1.0, 1.2), of(0.4, 1.4)],
            ..Prediction::default()
        };
        let checks = |figures: SessionFigures| verdict(&figures, &prediction);
        let named = |checks: &[SelfTestCheck], name| {
            let found = checks.iter().find(|check| check.name == name);
            found.copied().unwrap()
        };
        let fine = checks(of(0.5, 1.2));
        assert!(fine.iter().all(SelfTestCheck::passes), "{fine:?}");
        assert!(fine.iter().all(|check| check.name != "accelerating_v"));
        let settling = named(&fine, "settling_s");
        assert_eq!(settling.predicted, [0.2, 0.4, 1.0]);
        assert!((settling.most - 1.2).abs() < 1e-12 && settling.least.is_none());
        let sliding = named(&fine, "sliding_v");
        let (least, most) = (sliding.least.unwrap(), sliding.most);
        assert!((least - 0.9).abs() < 1e-12 && (most - 1.5).abs() < 1e-12);
        // Beyond each bound, and what was not measured.
        for (figures, name, passes) in [
            (of(1.19, 1.2), "settling_s", true),
            (of(1.21, 1.2), "settling_s", false),
            (of(0.0, 1.2), "settling_s", true),
            (of(0.5, 1.51), "sliding_v", false),
            (of(0.5, 0.89), "sliding_v", false),
            (SessionFigures { settled_s: None, ..of(0.5, 1.2) }, "settling_s", false),
            (SessionFigures { missed: 1, ..of(0.5, 1.2) }, "missed_moves", false),
            (SessionFigures { rest_counts: 1.0, ..of(0.5, 1.2) }, "rest_counts", true),
            (SessionFigures { rest_counts: 2.0, ..of(0.5, 1.2) }, "rest_counts", false),
        ] {
            assert_eq!(named(&checks(figures), name).passes(), passes, "{name}: {figures:?}");
        }
    }
}
