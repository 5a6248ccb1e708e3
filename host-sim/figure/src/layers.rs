//! Panels with layers of points over each other, on logarithmic axes, and their legend.

use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::chart::{Layer, LayeredPanel, LogAxis, Mark, Point};
use super::primitives::{BOUND, GRID, HEADER, INK, MARK, SMALL, TEXT, WIDTH, line, power, text};

/// Height of the legend.
const LEGEND: f64 = 30.0;

/// Width left of the first panel, for its label and the numbers of its axis.
const LEFT: f64 = 74.0;

/// Width right of the last panel.
const RIGHT: f64 = 22.0;

/// Space between two panels of a row, above a panel, and below a panel.
const GAP: f64 = 54.0;
const ABOVE: f64 = 26.0;
const BELOW: f64 = 34.0;

/// Largest number of panels in a row.
const COLUMNS: usize = 3;

const DOT: &str = "#8A8A8A";
const FRONT: &str = "#000000";

/// Returns width and height of the frame of each of `panels` panels.
fn frame(panels: usize) -> [f64; 2] {
    let columns = panels.clamp(1, COLUMNS) as f64;
    let width = (WIDTH - LEFT - RIGHT - GAP * (columns - 1.0)) / columns;
    // A single panel is wider than high.
    [width, width.clamp(180.0, 380.0)]
}

/// Returns the height of all panels and their legend.
pub(super) fn height(panels: usize) -> f64 {
    let rows = panels.div_ceil(COLUMNS).max(1) as f64;
    LEGEND + rows * (ABOVE + frame(panels)[1] + BELOW)
}

/// Draws the panels below the header of a page, and their legend above them.
pub(super) fn draw(page: &mut Scene, axes: &[LogAxis; 2], bounds: &str, panels: &[LayeredPanel]) {
    legend(page, bounds, panels);
    let [width, height] = frame(panels.len());
    for (place, panel) in panels.iter().enumerate() {
        let [column, row] = [place % COLUMNS, place / COLUMNS].map(|at| at as f64);
        let left = LEFT + column * (width + GAP);
        let top = HEADER + LEGEND + ABOVE + row * (ABOVE + height + BELOW);
        Panel { axes, left, top, width, height }.draw(page, panel);
    }
}

/// Draws the legend: each kind of mark once, and the bounds.
fn legend(page: &mut Scene, bounds: &str, panels: &[LayeredPanel]) {
    let mut kinds: Vec<(&str, Option<Mark>)> = Vec::new();
    for layer in panels.iter().flat_map(|panel| &panel.layers) {
        if !layer.points.is_empty() && !kinds.iter().any(|(name, _)| *name == layer.name) {
            kinds.push((&layer.name, Some(layer.mark)));
        }
    }
    if !bounds.is_empty() {
        kinds.push((bounds, None));
    }
    // Approximate widths of the entries.
    let widths: Vec<f64> =
        kinds.iter().map(|(name, _)| 52.0 + 7.4 * name.chars().count() as f64).collect();
    let mut x = 0.5 * (WIDTH - widths.iter().sum::<f64>()).max(0.0);
    let y = HEADER + 0.5 * LEGEND;
    for ((name, mark), width) in kinds.iter().zip(widths) {
        match mark {
            Some(Mark::Steps) => page.add(line([x, y], [x + 24.0, y], FRONT, 1.4)),
            None => page.add(line([x, y], [x + 24.0, y], BOUND, 1.2)),
            Some(mark) => marked(page, *mark, [x + 12.0, y]),
        }
        page.add(text(name, TEXT, [x + 32.0, y + 5.0], TextAnchor::Start));
        x += width;
    }
}

/// Draws one mark.
fn marked(page: &mut Scene, mark: Mark, [x, y]: Point) {
    match mark {
        Mark::Dot | Mark::Steps => page.add(Primitive::Circle {
            cx: x,
            cy: y,
            r: 2.6,
            fill: DOT.into(),
            fill_opacity: Some(0.7),
            stroke: None,
            stroke_width: None,
        }),
        Mark::Square => {
            let r = 6.0;
            let corners = [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]];
            polygon(page, &corners, INK, 1.8);
        }
        Mark::Diamond => {
            // Filled with smaller diamonds: a scene has no polygons.
            for r in [7.5, 6.0, 4.5, 3.0, 1.5] {
                let corners = [[x, y - r], [x + r, y], [x, y + r], [x - r, y]];
                polygon(page, &corners, MARK, 2.4);
            }
        }
    }
}

fn polygon(page: &mut Scene, corners: &[Point], colour: &str, width: f64) {
    for (i, corner) in corners.iter().enumerate() {
        page.add(line(*corner, corners[(i + 1) % corners.len()], colour, width));
    }
}

/// Frame of a panel on the page.
struct Panel<'a> {
    axes: &'a [LogAxis; 2],
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl Panel<'_> {
    /// Returns the place of a value along an axis, from 0 to 1. A value beyond an end lies on it.
    fn share(axis: &LogAxis, value: f64) -> f64 {
        let [low, high] = axis.decades.map(f64::from);
        if value == f64::INFINITY {
            return 1.0;
        }
        ((value.max(f64::MIN_POSITIVE).log10() - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn x(&self, value: f64) -> f64 {
        self.left + self.width * Self::share(&self.axes[0], value)
    }

    fn y(&self, value: f64) -> f64 {
        self.top + self.height * (1.0 - Self::share(&self.axes[1], value))
    }

    fn draw(&self, page: &mut Scene, panel: &LayeredPanel) {
        let Self { axes, left, top, width, height } = *self;
        let [right, bottom] = [left + width, top + height];
        page.add(text(&panel.name, TEXT, [left + 0.5 * width, top - 8.0], TextAnchor::Middle));
        self.grid(page);
        for (axis, is_across) in axes.iter().zip([true, false]) {
            let share = Self::share(axis, axis.bound);
            // A bound beyond the axis is left out: on its end it would be at a wrong value.
            if !(0.0 < share && share < 1.0) {
                continue;
            }
            let [from, to] = if is_across {
                [[self.x(axis.bound), top], [self.x(axis.bound), bottom]]
            } else {
                [[left, self.y(axis.bound)], [right, self.y(axis.bound)]]
            };
            page.add(line(from, to, BOUND, 1.2));
        }
        polygon(page, &[[left, top], [right, top], [right, bottom], [left, bottom]], INK, 0.8);
        for layer in &panel.layers {
            self.layer(page, layer);
        }
    }

    /// Draws lines with numbers at the powers of ten; on an axis of one or two decades, at 2 and 5
    /// as well.
    fn grid(&self, page: &mut Scene) {
        let Self { axes, left, top, width, height } = *self;
        for decade in axes[0].decades[0]..=axes[0].decades[1] {
            let x = self.x(10f64.powi(decade));
            page.add(line([x, top], [x, top + height], GRID, 0.7));
            let below = [x, top + height + 16.0];
            page.add(text(&power(decade), SMALL, below, TextAnchor::Middle));
        }
        for decade in axes[1].decades[0]..=axes[1].decades[1] {
            let y = self.y(10f64.powi(decade));
            page.add(line([left, y], [left + width, y], GRID, 0.7));
            page.add(text(&power(decade), SMALL, [left - 6.0, y + 4.0], TextAnchor::End));
        }
        for (axis, is_across) in axes.iter().zip([true, false]) {
            let [low, high] = axis.decades;
            for (decade, multiple) in
                (low..high).flat_map(|decade| [2.0, 5.0].map(|multiple| (decade, multiple)))
            {
                if high - low > 2 {
                    continue;
                }
                let value = multiple * 10f64.powi(decade);
                let number = files::error::rounded(value);
                if is_across {
                    let x = self.x(value);
                    page.add(line([x, top], [x, top + height], GRID, 0.4));
                    let below = [x, top + height + 16.0];
                    page.add(text(&number, SMALL, below, TextAnchor::Middle));
                } else {
                    let y = self.y(value);
                    page.add(line([left, y], [left + width, y], GRID, 0.4));
                    page.add(text(&number, SMALL, [left - 6.0, y + 4.0], TextAnchor::End));
                }
            }
        }
    }

    fn layer(&self, page: &mut Scene, layer: &Layer) {
        let at: Vec<Point> = layer
            .points
            .iter()
            .filter(|point| point.iter().all(|value| !value.is_nan()))
            .map(|[across, up]| [self.x(*across), self.y(*up)])
            .collect();
        if layer.mark != Mark::Steps {
            at.iter().for_each(|place| marked(page, layer.mark, *place));
            return;
        }
        for pair in at.windows(2) {
            let corner = [pair[1][0], pair[0][1]];
            page.add(line(pair[0], corner, FRONT, 1.4));
            page.add(line(corner, pair[1], FRONT, 1.4));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::chart::{Chart, ChartContent};
    use super::super::{marks, raster};
    use super::*;

    fn axis(decades: [i32; 2], bound: f64) -> LogAxis {
        LogAxis { label: "s".into(), decades, bound, beyond: String::new() }
    }

    #[test]
    fn layers_of_a_law_lie_over_each_other_in_one_panel_and_are_named_once() {
        let layers = |shift: f64| {
            let layer = |name: &str, mark, points| Layer { name: name.into(), mark, points };
            vec![
                layer("tried", Mark::Dot, vec![[0.1 * shift, 10.0], [1.0, 100.0]]),
                layer("Pareto front", Mark::Steps, vec![[0.1 * shift, 10.0], [1.0, 5.0]]),
                layer("kept", Mark::Diamond, vec![[1.0, f64::INFINITY], [f64::NAN, 1.0]]),
            ]
        };
        let panel = |name: &str, shift| LayeredPanel { name: name.into(), layers: layers(shift) };
        let panels = vec![panel("srnf", 1.0), panel("robust", 2.0)];
        let [stem, title, subtitle] = ["a", "A title", "simulated"].map(str::to_owned);
        let axes = [axis([-2, 1], 5.0), axis([0, 3], 2.0)];
        let bounds = "limits of success".to_owned();
        let shown = ChartContent::Layers { axes, bounds, panels };
        let drawn = marks::svg(&Chart { stem, title, subtitle, shown });
        for name in ["tried", "Pareto front", "kept", "limits of success", "srnf", "robust"] {
            assert_eq!(drawn.matches(&format!(">{name}<")).count(), 1, "{name}: {drawn}");
        }
        // Two dots in each of two panels, and one in the legend.
        assert_eq!(drawn.matches("<circle").count(), 5);
        // A tenth of a second is a third of the way along three decades.
        let [width, _] = frame(2);
        let x = LEFT + width / 3.0;
        let is_there = drawn
            .split("cx=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next()?.parse::<f64>().ok())
            .any(|found| (found - x).abs() < 0.01);
        assert!(is_there, "{x}: {drawn}");
        assert!(raster::png(&drawn, 1.0).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn panels_fill_the_page_however_many_there_are() {
        for panels in 1..=7 {
            let [width, high] = frame(panels);
            let columns = panels.min(COLUMNS) as f64;
            let right = LEFT + columns * width + (columns - 1.0) * GAP + RIGHT;
            assert!((right - WIDTH).abs() < 1e-9 && (180.0..=380.0).contains(&high));
            assert!(height(panels) >= panels.div_ceil(COLUMNS) as f64 * high);
        }
    }
}
