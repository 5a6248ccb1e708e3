//! Drawing with `kuva`, which provides axes, grid, curves and SVG output; the page
//! and the legends are laid out here.

use std::ops::RangeInclusive;
use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};
use kuva::{AxisLine, TickFormat};

use super::raster::FONT;
use super::shape::{Axis, drawable, extent, visible};
use super::thin::thin;
use super::{Figure, FigureError, InsetRange, Panel, PlotCurve, Style};

const LEFT: f64 = 92.0;
const RIGHT: f64 = 22.0;
const PANEL: f64 = 290.0;
const FOOTER: f64 = 42.0;
const GAP: f64 = 16.0;
const LEGEND_ROW: f64 = 22.0;
const SWATCH: f64 = 34.0;
const TITLE: u32 = 22;
const TEXT: u32 = 16;

/// Page on which a figure is drawn.
#[derive(Clone, Copy)]
pub(super) struct Sheet<'a> {
    width: f64,
    /// Height for title and subtitle. If it is too small, both are left out.
    header: f64,
    /// Start of the names of the clip paths.
    clip: &'a str,
}

impl<'a> Sheet<'a> {
    /// Page of a file with one figure.
    pub const FILE: Sheet<'static> = Sheet { width: 900.0, header: 64.0, clip: "panel" };

    /// Creates the sheet of a figure in a text that has the title. The sheet is narrow enough to be
    /// read on a telephone. `clip` must differ from that of all other figures in the text.
    pub const fn inline(clip: &'a str) -> Self {
        Self { width: 560.0, header: 4.0, clip }
    }
}

/// Smallest height of a panel's frame below its legend, in the figure's units.
const LEAST_FRAME: f64 = 40.0;

/// Left end of an inset with its labels, as a share of its panel's width.
const INSET_FROM: f64 = 0.4;

/// Width for the labels of an inset's values, in the figure's units.
const INSET_LABELS: f64 = 62.0;

/// Margin around an inset, in the figure's units.
const INSET_GAP: f64 = 6.0;

/// Smallest height of an inset, in the figure's units. A lower one would show no more than its
/// panel.
const LEAST_INSET: f64 = 40.0;

/// Allowed relative heights of a panel, which leave room for the legend and keep the page
/// printable.
const HEIGHTS: RangeInclusive<f64> = 0.4..=4.0;

/// Approximate width of a letter of size 1: the plotting crate does not export its text metrics.
const LETTER_OF_SIZE: f64 = 0.5;

/// Approximate width of a letter in ordinary text.
const LETTER: f64 = LETTER_OF_SIZE * TEXT as f64;

/// Height of the base line of the title's first line.
const TITLE_AT: f64 = 30.0;

/// Room between the last base line of the captions and the first panel.
const UNDER_CAPTIONS: f64 = 11.0;

/// Colour, stroke width and dashes.
type Look = (&'static str, f64, Option<&'static str>);

const ZERO: Look = ("#404040", 1.0, None);

/// Colours of Okabe and Ito, partly shifted in lightness to differ in grey, too.
fn look(style: Style) -> Look {
    match style {
        Style::Reference => ("#000000", 1.3, Some("6 4")),
        Style::Primary => ("#00548F", 2.0, None),
        // The gaps show a curve below that coincides with this one.
        Style::Second => ("#D55E00", 2.0, Some("10 8")),
        Style::Third => ("#009E73", 2.2, Some("2.2 2.8")),
        Style::Compensation => ("#B86E00", 1.2, None),
        Style::Total => ("#505050", 1.2, None),
        Style::Limit => ("#7F7F7F", 1.2, Some("9 3 2 3")),
        Style::PrimaryAtEncoder => ("#00548F", 1.0, None),
        Style::SecondAtEncoder => ("#D55E00", 1.0, Some("8 2 2 2")),
        Style::ThirdAtEncoder => ("#009E73", 1.0, Some("4 2")),
    }
}

pub(super) fn svg(figure: &Figure, sheet: Sheet) -> Result<String, FigureError> {
    let panels = &figure.panels;
    let points = panels.iter().flat_map(|panel| drawable(&panel.lines));
    let time = extent(points.map(|point| point.0)).ok_or(FigureError::Empty)?;
    // Slightly longer: otherwise rounding would lose a tick at the end.
    let time = Axis::new((time.0, time.1 + 1e-9 * (time.1 - time.0)), sheet.width / 64.0)?;
    if !panels.iter().all(|p| HEIGHTS.contains(&p.height)) {
        return Err(FigureError::Size);
    }
    let height: f64 = panels.iter().map(|panel| panel.height * PANEL).sum();
    let has_title = sheet.header > TITLE_AT;
    let captions = if has_title { captions(figure, sheet.width) } else { Vec::new() };
    let header = captions.last().map_or(sheet.header, |(.., y)| y + UNDER_CAPTIONS);
    let mut page = Scene::new(sheet.width, header + height + FOOTER);
    page.font_family = Some(format!("{FONT}, Linux Libertine O, Times New Roman, serif"));
    let middle = (LEFT + sheet.width - RIGHT) / 2.0;
    for (content, size, y) in captions {
        page.add(text(&content, size, (middle, y), TextAnchor::Middle, None));
    }
    let below = (middle, page.height - 10.0);
    page.add(text(&figure.x_label, TEXT, below, TextAnchor::Middle, None));
    let mut top = header;
    for (index, panel) in panels.iter().enumerate() {
        let is_last = index + 1 == panels.len();
        let drawn = draw_panel(panel, &time, sheet.width, (top, page.height), is_last)?;
        for (part, scene) in drawn.into_iter().enumerate() {
            let part = if part == 0 { "" } else { "-inset" };
            add_panel(&mut page, scene, &format!("{}-{index}{part}", sheet.clip));
        }
        top += panel.height * PANEL;
    }
    Ok(SvgBackend::new().render_scene(&page))
}

/// Returns the lines of title and subtitle, with their sizes and heights on the page. A text that
/// is too long for one line is wrapped.
fn captions(figure: &Figure, width: f64) -> Vec<(String, u32, f64)> {
    let mut lines: Vec<(String, u32, f64)> = Vec::new();
    for (content, size) in [(&figure.title, TITLE), (&figure.subtitle, TEXT)] {
        let letters = ((width - 2.0 * RIGHT) / (LETTER_OF_SIZE * f64::from(size))) as usize;
        for line in wrapped(content, letters) {
            let y = lines.last().map_or(TITLE_AT, |(.., y)| y + 7.0 + f64::from(size));
            lines.push((line, size, y));
        }
    }
    lines
}

/// Wraps a text to lines of at most `letters` characters; a longer word has a line of its own.
pub(super) fn wrapped(content: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in content.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

fn draw_panel(
    panel: &Panel,
    time: &Axis,
    width: f64,
    (top, page_height): (f64, f64),
    is_last: bool,
) -> Result<Vec<Scene>, FigureError> {
    let data = extent(drawable(&panel.lines).map(|point| point.1));
    let padded = |(low, high)| (1.05 * low - 0.05 * high, 1.05 * high - 0.05 * low);
    let range = panel.y_range.or(data.map(padded)).unwrap_or((-1.0, 1.0));
    let axis = Axis::new(range, 9.0 * panel.height)?;

    let hidden = data.filter(|data| data.0 < axis.low || data.1 > axis.high);
    let note = hidden.map(|(low, high)| {
        let (low, high) = (axis.number(low, 1), axis.number(high, 1));
        format!("(cut; data from {low} to {high})")
    });
    let (legend, legend_height) = legend(panel, note.as_deref(), top, width - RIGHT);
    let bottom = top + panel.height * PANEL - GAP;
    let top = top + legend_height;
    if bottom - top < LEAST_FRAME {
        return Err(FigureError::Size);
    }

    let frame = Frame { left: LEFT, right: width - RIGHT, top, bottom };
    let mut scene = axes(&panel.lines, [time, &axis], &frame, (width, page_height), is_last);
    scene.elements.extend(legend);
    let at = (22.0, (top + bottom) / 2.0);
    let turned = Some(-90.0);
    scene.add(text(&panel.y_label, TEXT, at, TextAnchor::Middle, turned));
    let mut drawn = vec![scene];
    if let Some(window) = &panel.inset {
        drawn.extend(inset(panel, window, [time, &axis], &frame, (width, page_height))?);
    }
    Ok(drawn)
}

/// Rectangle on the sheet, in the sheet's units.
#[derive(Clone, Copy)]
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Draws axes with curves in a frame.
fn axes(
    lines: &[PlotCurve],
    [time, values]: [&Axis; 2],
    frame: &Frame,
    (width, height): (f64, f64),
    has_times: bool,
) -> Scene {
    let mut layout = Layout::new((time.low, time.high), (values.low, values.high))
        .with_width(width)
        .with_height(height)
        .with_force_margins(frame.left, width - frame.right)
        .with_force_margins_y(frame.top, height - frame.bottom)
        // Without these the axes would be widened to round numbers.
        .with_x_axis_min(time.low)
        .with_x_axis_max(time.high)
        .with_y_axis_min(values.low)
        .with_y_axis_max(values.high)
        .with_x_tick_step(time.step)
        .with_y_tick_step(values.step)
        .with_x_tick_format(tick_format(*time))
        .with_y_tick_format(tick_format(*values))
        .with_tick_size(TEXT)
        .with_axis_line(AxisLine::Box)
        .with_grid_line_width(0.7);
    layout.theme.grid_color = "#DDDDDD".into();
    layout.suppress_x_ticks = !has_times;

    // Size of a unit of the sheet on each axis.
    let unit = [
        (time.high - time.low) / (frame.right - frame.left),
        (values.high - values.low) / (frame.bottom - frame.top),
    ];
    // A chattering signal fills a band, which must not hide the other curves.
    let (mut curves, mut in_front) = (Vec::new(), Vec::new());
    if values.low < 0.0 && values.high > 0.0 {
        in_front.push(curve(vec![(time.low, 0.0), (time.high, 0.0)], ZERO));
    }
    for line in lines {
        let pieces = visible(line, values.low, values.high).into_iter();
        let pieces = pieces.map(|piece| curve(thin(&piece, unit), look(line.style)));
        match line.style {
            Style::Compensation | Style::Total => curves.extend(pieces),
            _ => in_front.extend(pieces),
        }
    }
    curves.extend(in_front);
    render_multiple(curves, layout)
}

/// Draws the window of a panel enlarged, above or below the curves on the right, on the side with
/// more space. Returns `None` if the space is too small to read the inset.
fn inset(
    panel: &Panel,
    window: &InsetRange,
    [time, axis]: [&Axis; 2],
    frame: &Frame,
    sheet: (f64, f64),
) -> Result<Option<Scene>, FigureError> {
    let left = frame.left + INSET_FROM * (frame.right - frame.left);
    let begin =
        time.low + (left - frame.left) / (frame.right - frame.left) * (time.high - time.low);
    let later = drawable(&panel.lines).filter(|point| point.0 >= begin).map(|point| point.1);
    let Some((low, high)) = extent(later) else { return Ok(None) };
    let y = |value: f64| {
        frame.bottom - (value - axis.low) / (axis.high - axis.low) * (frame.bottom - frame.top)
    };
    let (above, below) = (y(high) - frame.top, frame.bottom - y(low));
    let (top, bottom) = if above >= below { (frame.top, y(high)) } else { (y(low), frame.bottom) };
    let own = Frame {
        left: left + INSET_LABELS,
        right: frame.right - 2.0 * INSET_GAP,
        top: top + 2.0 * INSET_GAP,
        bottom: bottom - INSET_GAP - LEGEND_ROW,
    };
    if own.bottom - own.top < LEAST_INSET {
        return Ok(None);
    }
    let until = window.time.1.min(time.high);
    let own_time = Axis::new((window.time.0, until), (own.right - own.left) / 64.0)?;
    let values = Axis::new(window.values, ((own.bottom - own.top) / 26.0).max(3.0))?;
    let lines: Vec<PlotCurve> = panel.lines.iter().map(|line| line.since(own_time.low)).collect();
    let mut scene = axes(&lines, [&own_time, &values], &own, sheet, true);
    let paper = Primitive::Rect {
        x: left,
        y: top + INSET_GAP,
        width: frame.right - INSET_GAP - left,
        height: bottom - top - 2.0 * INSET_GAP,
        fill: "#FFFFFF".into(),
        stroke: None,
        stroke_width: None,
        opacity: None,
    };
    scene.elements.insert(0, paper);
    Ok(Some(scene))
}

fn tick_format(axis: Axis) -> TickFormat {
    TickFormat::Custom(Arc::new(move |value| axis.number(value, 0)))
}

fn curve(points: Vec<(f64, f64)>, (colour, width, dashes): Look) -> Plot {
    let dashes = dashes.map_or(LineStyle::Solid, |d| LineStyle::Custom(d.into()));
    let plot = LinePlot::new().with_data(points).with_color(colour);
    Plot::Line(plot.with_stroke_width(width).with_line_style(dashes))
}

/// Returns the legend in rows from `top` down, and its height. Its swatches are long enough to show
/// the dashes, unlike those of the plotting crate.
fn legend(panel: &Panel, note: Option<&str>, top: f64, right: f64) -> (Vec<Primitive>, f64) {
    let lines = panel.lines.iter().filter(|line| !line.name.is_empty());
    let entries = lines.map(|line| (line.name.as_str(), Some(line.style)));
    let (mut x, mut y) = (LEFT, top + LEGEND_ROW / 2.0);
    let mut drawn = Vec::new();
    for (name, style) in entries.chain(note.map(|note| (note, None))) {
        let swatch = style.map_or(0.0, |_| SWATCH + 8.0);
        let width = swatch + LETTER * name.chars().count() as f64;
        if x > LEFT && x + width > right {
            (x, y) = (LEFT, y + LEGEND_ROW);
        }
        if let Some((colour, stroke_width, dashes)) = style.map(look) {
            drawn.push(Primitive::Line {
                x1: x,
                y1: y,
                x2: x + SWATCH,
                y2: y,
                stroke: colour.into(),
                stroke_width,
                stroke_dasharray: dashes.map(str::to_owned),
            });
        }
        let at = (x + swatch, y + 5.0);
        drawn.push(text(name, TEXT, at, TextAnchor::Start, None));
        x += width + 20.0;
    }
    (drawn, y + LEGEND_ROW / 2.0 + 6.0 - top)
}

fn text(
    content: &str,
    size: u32,
    (x, y): (f64, f64),
    anchor: TextAnchor,
    rotate: Option<f64>,
) -> Primitive {
    Primitive::Text {
        x,
        y,
        // XML does not allow control characters, not even escaped.
        content: content.chars().filter(|c| !c.is_control()).collect(),
        size,
        anchor,
        rotate,
        bold: false,
        color: Some("#000000".into()),
    }
}

/// Adds a panel whose clip path is named after its place on the page. The plotting crate numbers
/// clip paths throughout the program, but equal figures must result in equal files.
fn add_panel(page: &mut Scene, mut panel: Scene, own: &str) {
    for element in &mut panel.elements {
        if let Primitive::ClipStart { id, .. } = element {
            for definition in &mut panel.defs {
                *definition = definition.replace(id.as_str(), own);
            }
            *id = own.to_owned();
        }
    }
    page.defs.extend(panel.defs);
    page.add(Primitive::GroupStart {
        transform: None,
        title: None,
        // Mitred joins would grow spikes on a chattering signal.
        extra_attrs: Some("stroke-linejoin=\"round\"".into()),
    });
    page.elements.extend(panel.elements);
    page.add(Primitive::GroupEnd);
}
