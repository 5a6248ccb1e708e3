//! Charts as SVG: marks, lines and texts that are laid out here.

use kuva::backend::svg::SvgBackend;
use kuva::render::render::{Scene, TextAnchor};

use super::chart::{Chart, ChartContent, Cloud, LogAxis, Share};
use super::layers;
use super::primitives::{
    BOUND, GRID, HEADER, INK, MARK, SMALL, TEXT, WIDTH, circle, line, power, text, turned,
};
use super::raster::FONT;

pub(super) const FOOTER: f64 = 44.0;
const TITLE: u32 = 22;

/// Left and right end of the axis of shares.
const SHARES: [f64; 2] = [210.0, 780.0];
const ROW: f64 = 20.0;

/// Total width of the clouds of a row, and height of a cloud with its numbers; then the width and
/// the height of the numbers beside and below its frame.
const CELLS: [f64; 2] = [870.0, 250.0];
const BESIDE: [f64; 2] = [82.0, 70.0];

/// Draws a chart.
pub(super) fn svg(chart: &Chart) -> String {
    let height = HEADER
        + FOOTER
        + match &chart.shown {
            ChartContent::Shares(groups) => {
                groups.iter().map(|(_, rows)| ROW * (rows.len() as f64 + 1.6)).sum()
            }
            ChartContent::Clouds { clouds, columns, .. } => {
                CELLS[1] * clouds.len().div_ceil((*columns).max(1)) as f64
            }
            ChartContent::Layers { panels, .. } => layers::height(panels.len()),
        };
    let mut page = Scene::new(WIDTH, height);
    page.font_family = Some(format!("{FONT}, Linux Libertine O, Times New Roman, serif"));
    page.add(text(&chart.title, TITLE, [0.5 * WIDTH, 30.0], TextAnchor::Middle));
    page.add(text(&chart.subtitle, TEXT, [0.5 * WIDTH, 53.0], TextAnchor::Middle));
    match &chart.shown {
        ChartContent::Shares(groups) => shares(&mut page, groups, height),
        ChartContent::Clouds { axes, clouds, columns } => {
            let columns = (*columns).max(1);
            let cell = [CELLS[0] / columns as f64, CELLS[1]];
            for (place, one) in clouds.iter().enumerate() {
                let corner = [
                    cell[0] * (place % columns) as f64 + 62.0,
                    HEADER + cell[1] * (place / columns) as f64 + 26.0,
                ];
                cloud(&mut page, axes, one, corner, [cell[0] - BESIDE[0], cell[1] - BESIDE[1]]);
            }
            let below = [0.5 * WIDTH, height - 14.0];
            page.add(text(&axes[0].label, TEXT, below, TextAnchor::Middle));
            page.add(turned(&axes[1].label, [18.0, 0.5 * height]));
        }
        ChartContent::Layers { axes, bounds, panels } => {
            layers::draw(&mut page, axes, bounds, panels);
            let below = [0.5 * WIDTH, height - 14.0];
            page.add(text(&axes[0].label, TEXT, below, TextAnchor::Middle));
            page.add(turned(&axes[1].label, [18.0, 0.5 * height]));
        }
    }
    SvgBackend::new().render_scene(&page)
}

fn shares(page: &mut Scene, groups: &[(String, Vec<Share>)], height: f64) {
    let [left, right] = SHARES;
    let at = |share: f64| left + (right - left) * share;
    let bottom = height - FOOTER;
    for tick in 0..=10 {
        let share = f64::from(tick) / 10.0;
        let label = format!("{}", 10 * tick);
        page.add(text(&label, TEXT, [at(share), bottom + 18.0], TextAnchor::Middle));
    }
    page.add(text("success (%)", TEXT, [at(0.5), bottom + 38.0], TextAnchor::Middle));
    let mut y = HEADER;
    for (group, rows) in groups {
        y += 1.2 * ROW;
        page.add(text(group, TEXT, [14.0, y], TextAnchor::Start));
        page.add(line([14.0, y + 5.0], [WIDTH - 14.0, y + 5.0], GRID, 0.7));
        // From title to title, so that no line crosses a title.
        let [upper, lower] = [y + 5.0, y + ROW * (rows.len() as f64 + 0.4) + 4.0];
        for tick in 0..=10 {
            let x = at(f64::from(tick) / 10.0);
            page.add(line([x, upper], [x, lower], GRID, 0.7));
        }
        y += 0.4 * ROW;
        for Share { name, share, interval } in rows {
            y += ROW;
            let middle = y - 5.0;
            page.add(text(name, TEXT, [left - 12.0, y], TextAnchor::End));
            page.add(line([at(interval[0]), middle], [at(interval[1]), middle], MARK, 2.0));
            page.add(circle([at(*share), middle], 4.0, 1.0));
            let value = format!("{:.1}", 100.0 * share);
            page.add(text(&value, TEXT, [right + 16.0, y], TextAnchor::Start));
        }
    }
}

fn cloud(
    page: &mut Scene,
    axes: &[LogAxis; 2],
    cloud: &Cloud,
    [left, top]: [f64; 2],
    [width, height]: [f64; 2],
) {
    let share = |axis: &LogAxis, value: f64| {
        let [low, high] = axis.decades.map(f64::from);
        // A value beyond the axis lies on its edge.
        ((value.max(f64::MIN_POSITIVE).log10() - low) / (high - low)).clamp(0.0, 1.0)
    };
    // The last tenth of the horizontal axis is for infinite values.
    let x = |value: f64| {
        let finite = 0.9 * share(&axes[0], value);
        left + width * if value.is_finite() { finite } else { 0.96 }
    };
    let y = |value: f64| top + height * (1.0 - share(&axes[1], value));
    page.add(text(&cloud.name, TEXT, [left + 0.5 * width, top - 8.0], TextAnchor::Middle));
    for decade in axes[0].decades[0]..=axes[0].decades[1] {
        let at = x(10f64.powi(decade));
        page.add(line([at, top], [at, top + height], GRID, 0.7));
        page.add(text(&power(decade), SMALL, [at, top + height + 15.0], TextAnchor::Middle));
    }
    page.add(text(
        &axes[0].beyond,
        SMALL,
        [left + 0.97 * width, top + height + 29.0],
        TextAnchor::Middle,
    ));
    for decade in axes[1].decades[0]..=axes[1].decades[1] {
        let at = y(10f64.powi(decade));
        page.add(line([left, at], [left + width, at], GRID, 0.7));
        page.add(text(&power(decade), SMALL, [left - 6.0, at + 4.0], TextAnchor::End));
    }
    let bounds = [x(axes[0].bound), y(axes[1].bound)];
    page.add(line([bounds[0], top], [bounds[0], top + height], BOUND, 1.0));
    page.add(line([left, bounds[1]], [left + width, bounds[1]], BOUND, 1.0));
    let frame =
        [[left, top], [left + width, top], [left + width, top + height], [left, top + height]];
    for (i, corner) in frame.iter().enumerate() {
        page.add(line(*corner, frame[(i + 1) % 4], INK, 0.8));
    }
    for [settling, rest] in &cloud.points {
        page.add(circle([x(*settling), y(*rest)], 2.2, 0.45));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster;

    fn chart(shown: ChartContent) -> Chart {
        let [stem, title, subtitle] = ["a", "A title", "simulated"].map(str::to_owned);
        Chart { stem, title, subtitle, shown }
    }

    #[test]
    fn shares_lie_where_they_are_on_the_axis_and_the_png_is_one() {
        let share = |name: &str, share| Share { name: name.into(), share, interval: [0.0, share] };
        let rows = vec![share("none", 0.0), share("half", 0.5), share("all", 1.0)];
        let drawn = svg(&chart(ChartContent::Shares(vec![("rigid".into(), rows)])));
        for x in [210.0, 495.0, 780.0] {
            assert!(drawn.contains(&format!("cx=\"{x}\"")), "{x}: {drawn}");
        }
        for name in ["none", "half", "all", "rigid", "50.0"] {
            assert!(drawn.contains(name), "{name}");
        }
        assert!(raster::png(&drawn, 1.0).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn what_never_settles_and_what_is_beyond_an_axis_lie_within_the_frame() {
        let axis = |decades, bound| {
            let [label, beyond] = ["s", "never"].map(str::to_owned);
            LogAxis { label, decades, bound, beyond }
        };
        let axes = [axis([-2, 1], 5.0), axis([-1, 3], 2.0)];
        let points = vec![[f64::INFINITY, 1e9], [1e-9, 0.0], [0.1, 10.0]];
        let clouds = vec![Cloud { name: "pd".into(), points }];
        let drawn = svg(&chart(ChartContent::Clouds { axes, clouds, columns: 3 }));
        let found: Vec<f64> = drawn
            .split("cx=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next()?.parse().ok())
            .collect();
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|x| (62.0..=270.0).contains(x)), "{found:?}");
        // A tenth of a second is a third of the way of three decades, which are 0.9 of the frame.
        assert!((found[2] - (62.0 + 208.0 * 0.3)).abs() < 0.01, "{found:?}");
    }
}
