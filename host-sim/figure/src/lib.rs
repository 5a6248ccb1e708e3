//! Stacked time-series panels with one time axis, as SVG or PNG.
//!
//! The types here define the content of a figure. Only `draw` defines its appearance, so that every
//! figure of a report has the same fonts, weights and dash patterns.

pub mod chart;
pub mod compared;
#[cfg(feature = "figures")]
mod draw;
mod files;
#[cfg(feature = "figures")]
mod inline;
#[cfg(feature = "figures")]
mod layers;
pub mod logged;
#[cfg(feature = "figures")]
mod marks;
mod of_runs;
pub mod page;
#[cfg(feature = "figures")]
mod primitives;
#[cfg(feature = "figures")]
mod raster;
mod results;
#[cfg(feature = "figures")]
mod shape;
#[cfg(all(test, feature = "figures"))]
mod tests;
#[cfg(feature = "figures")]
mod thin;

use std::fmt;

pub use files::{chart_svg, figure_directory, write_charts, write_figures};
pub use of_runs::NamedFigure;
pub use results::{figures, set_title};

/// Role of a curve; it determines colour, weight and dashes.
///
/// The roles differ in weight or dash pattern as well as in colour, so that they
/// can be distinguished in a black-and-white print. The two for chattering
/// signals are solid, since dashes on such a signal look like noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Reference of the joint: thin black dashes.
    Reference,
    /// The curve the panel is about: thick solid blue.
    Primary,
    /// The curve to compare with: vermilion, long dashes.
    Second,
    /// One more curve to compare with: green dots.
    Third,
    /// The part of a control signal that counters friction: thin solid ochre.
    Compensation,
    /// A whole control signal: thin solid dark grey.
    Total,
    /// A bound such as a tolerance or a supply voltage: thin grey dash-dots.
    Limit,
    /// The encoder's side of a gear, beside [`Self::Primary`] of its load: thin solid blue.
    PrimaryAtEncoder,
    /// The encoder's side, beside [`Self::Second`]: thin vermilion, dash-dots.
    SecondAtEncoder,
    /// The encoder's side, beside [`Self::Third`]: thin green, fine dashes.
    ThirdAtEncoder,
}

impl Style {
    /// Returns the style of the encoder's side beside a curve of the load.
    pub const fn at_encoder(self) -> Self {
        match self {
            Self::Second => Self::SecondAtEncoder,
            Self::Third => Self::ThirdAtEncoder,
            _ => Self::PrimaryAtEncoder,
        }
    }
}

/// One curve of a panel. Points that are not finite leave a gap.
#[derive(Debug, Clone)]
pub struct PlotCurve {
    /// Name in the legend; an empty name keeps the curve out of the legend.
    pub name: String,
    /// Time and value of each sample.
    pub points: Vec<(f64, f64)>,
    /// Role of the curve.
    pub style: Style,
    /// Whether each value lasts until the next point, as with a zero-order hold.
    pub held: bool,
}

impl PlotCurve {
    /// Creates a curve with straight lines between its points.
    pub fn new(name: impl Into<String>, style: Style, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, style, held: false }
    }

    /// Returns the part of the curve from a time on, with its value at that time.
    #[cfg(feature = "figures")]
    fn since(&self, time: f64) -> Self {
        let first = self.points.partition_point(|point| point.0 < time);
        let mut points = self.points[first..].to_vec();
        if let (Some(before), Some(after)) = (first.checked_sub(1), points.first().copied()) {
            let before = self.points[before];
            let share = (time - before.0) / (after.0 - before.0);
            let value = if self.held { before.1 } else { before.1 + share * (after.1 - before.1) };
            points.insert(0, (time, value));
        }
        Self { points, ..self.clone() }
    }

    /// Returns the same curve, drawn as the output of a zero-order hold.
    pub fn held(mut self) -> Self {
        self.held = true;
        self
    }
}

/// One set of axes.
///
/// Later curves cover earlier ones, except that [`Style::Compensation`] and
/// [`Style::Total`] stay below the zero line and all other curves. A signal that
/// chatters at every sample shows as a solid band, so two of them need two panels.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Label of the value axis, with its unit.
    pub y_label: String,
    /// The curves.
    pub lines: Vec<PlotCurve>,
    /// Height relative to an ordinary panel, between 0.4 and 4.
    pub height: f64,
    /// Fixed range of the value axis; without it the axis covers all points.
    ///
    /// Curves are cut at the range, and the legend then states the range of the data.
    pub y_range: Option<(f64, f64)>,
    /// Part of the panel that an inset enlarges, if the curves leave room for it.
    pub inset: Option<InsetRange>,
}

/// A part of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsetRange {
    /// Start and end on the time axis.
    pub time: (f64, f64),
    /// Lowest and highest value.
    pub values: (f64, f64),
}

impl Panel {
    /// Creates a panel of ordinary height whose axis covers all its points.
    pub fn new(y_label: impl Into<String>, lines: Vec<PlotCurve>) -> Self {
        Self { y_label: y_label.into(), lines, height: 1.0, y_range: None, inset: None }
    }

    /// Returns whether all curves except limits are zero everywhere: such a panel shows nothing.
    pub fn is_zero(&self) -> bool {
        let curves = self.lines.iter().filter(|line| line.style != Style::Limit);
        let mut values = curves.flat_map(|line| &line.points).map(|(_, value)| *value).peekable();
        values.peek().is_some() && values.all(|value| value == 0.0)
    }
}

/// A page of panels under each other that share the time axis.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Title of the page.
    pub title: String,
    /// Smaller line below the title; may be empty.
    pub subtitle: String,
    /// Label of the shared time axis, with its unit.
    pub x_label: String,
    /// The panels, top to bottom.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Draws the figure as an SVG document, 900 units wide.
    #[cfg(feature = "figures")]
    pub fn to_svg(&self) -> Result<String, FigureError> {
        draw::svg(self, draw::Sheet::FILE)
    }

    /// Draws the figure as an element of an HTML page, without a title. The names of its clip paths
    /// begin with `id`, which must be unique on the page.
    #[cfg(feature = "figures")]
    pub fn to_inline_svg(&self, id: &str) -> Result<String, FigureError> {
        Ok(inline::element(&draw::svg(self, draw::Sheet::inline(id))?, &self.title))
    }

    /// Draws the figure as a PNG file with `scale` pixels for each SVG unit.
    #[cfg(feature = "figures")]
    pub fn to_png(&self, scale: f32) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.to_svg()?, scale)
    }
}

/// Error of a figure that cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FigureError {
    /// No panel has a finite point, so there is no time axis to draw.
    Empty,
    /// An axis range is empty, reversed or not finite.
    Range,
    /// A panel height or the PNG scale is out of bounds, or a legend fills its panel.
    Size,
    /// The bundled font is missing.
    Font,
    /// The SVG could not be turned into a PNG.
    Raster(String),
}

impl fmt::Display for FigureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the figure has no finite point"),
            Self::Range => f.write_str("an axis range is empty, reversed or not finite"),
            Self::Size => f.write_str("a panel is too low or the scale is out of bounds"),
            Self::Font => f.write_str("the bundled font is missing"),
            Self::Raster(reason) => write!(f, "the PNG could not be made: {reason}"),
        }
    }
}

impl std::error::Error for FigureError {}
