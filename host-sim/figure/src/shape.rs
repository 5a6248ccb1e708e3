//! Axis ranges, ticks and the visible pieces of a curve, in data coordinates.

use super::{FigureError, PlotCurve};

type Point = (f64, f64);

/// A value range with the distance of its ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    pub step: f64,
}

impl Axis {
    /// Creates an axis with at most about `ticks` ticks at a round distance.
    pub fn new((low, high): (f64, f64), ticks: f64) -> Result<Self, FigureError> {
        let span = high - low;
        if !(span > 0.0 && span.is_finite()) {
            return Err(FigureError::Range);
        }
        let decade = 10f64.powf((span / ticks).log10().floor());
        let enough = |factor: &f64| factor * decade * ticks >= span;
        let factor = [1.0, 2.0, 5.0].into_iter().find(enough).unwrap_or(10.0);
        let step = factor * decade;
        Ok(Self { low, high, step })
    }

    /// Formats a number with the decimals of the ticks and `extra` more.
    pub fn number(&self, value: f64, extra: usize) -> String {
        // The factor guards against a logarithm just below a whole number.
        let decimals = (-(1.001 * self.step).log10().floor()).max(0.0) as usize;
        let text = if decimals <= 4 && value.abs() < 1e6 {
            format!("{value:.*}", decimals + extra)
        } else {
            format!("{value:.1e}").replace("0.0e0", "0")
        };
        let is_zero = text.chars().all(|c| "-0.".contains(c));
        text.replace('-', if is_zero { "" } else { "\u{2212}" })
    }
}

/// Returns the smallest and the largest value; nearly equal ones are moved apart.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let pairs = values.map(|value| (value, value));
    let (low, high) = pairs.reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))?;
    let size = low.abs().max(high.abs());
    if size > 1e-12 && high - low > 1e-9 * size {
        return Some((low, high));
    }
    let margin = if size > 1e-12 { 0.1 * size } else { 1.0 };
    Some((low - margin, high + margin))
}

fn is_finite(point: &Point) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// Returns all finite points of the lines.
pub(super) fn drawable(lines: &[PlotCurve]) -> impl Iterator<Item = Point> {
    let points = lines.iter().flat_map(|line| &line.points);
    points.copied().filter(is_finite)
}

/// Returns the pieces of a line that lie between `low` and `high`.
pub(super) fn visible(line: &PlotCurve, low: f64, high: f64) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for run in line.points.split(|point| !is_finite(point)) {
        let mut end = None;
        for (from, to) in segments(run, line.held) {
            let Some((from, to)) = cut(from, to, low, high) else {
                continue;
            };
            match pieces.last_mut() {
                Some(piece) if end == Some(from) => piece.push(to),
                _ => pieces.push(vec![from, to]),
            }
            end = Some(to);
        }
    }
    pieces
}

fn segments(run: &[Point], held: bool) -> impl Iterator<Item = (Point, Point)> {
    run.windows(2).flat_map(move |pair| {
        let (from, to) = (pair[0], pair[1]);
        let corner = if held { (to.0, from.1) } else { from };
        [(from, corner), (corner, to)].into_iter().filter(|(from, to)| from != to)
    })
}

/// Returns the part of a segment between `low` and `high`, if there is any.
///
/// The cut is made here and not left to the SVG clip path because coordinates far
/// outside of the page overflow the single precision of the PNG renderer.
fn cut(from: Point, to: Point, low: f64, high: f64) -> Option<(Point, Point)> {
    if from.1.min(to.1) > high || from.1.max(to.1) < low {
        return None;
    }
    let at = |y: f64| {
        let along = (y - from.1) / (to.1 - from.1);
        (from.0 + along * (to.0 - from.0), y)
    };
    let fit = |point: Point| match point.1 {
        y if y < low => at(low),
        y if y > high => at(high),
        _ => point,
    };
    Some((fit(from), fit(to)))
}
