//! Charts without a time axis: shares with their intervals, clouds of points, and layers of points.
//!
//! The types here describe the content; `marks.rs` and `layers.rs` draw it.

/// A row of a chart of shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// Label.
    pub name: String,
    /// Share, from 0 to 1.
    pub share: f64,
    /// Confidence interval.
    pub interval: [f64; 2],
}

/// A point of a cloud; an infinite value is drawn at the upper end of its axis.
pub type Point = [f64; 2];

/// One cloud among others of the same axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// Name of the cloud.
    pub name: String,
    /// Points of the cloud.
    pub points: Vec<Point>,
}

/// An axis of a cloud, in powers of ten.
#[derive(Clone, Debug, PartialEq)]
pub struct LogAxis {
    /// Label of the axis, with the unit.
    pub label: String,
    /// Powers of ten of its ends.
    pub decades: [i32; 2],
    /// Bound, drawn as a line across.
    pub bound: f64,
    /// Label for values beyond the upper end.
    pub beyond: String,
}

/// Marker of the points of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Small grey dot at each point.
    Dot,
    /// Steps from point to point, in the order of the horizontal axis.
    Steps,
    /// Hollow square at each point.
    Square,
    /// Filled diamond at each point.
    Diamond,
}

/// Points of one kind in a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name of the points in the legend. The same name has the same mark in all panels.
    pub name: String,
    /// Marker of the points.
    pub mark: Mark,
    /// The points.
    pub points: Vec<Point>,
}

/// A panel of layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredPanel {
    /// Name of the panel.
    pub name: String,
    /// The layers, the lowest first.
    pub layers: Vec<Layer>,
}

/// Content of a chart.
#[derive(Clone, Debug, PartialEq)]
pub enum ChartContent {
    /// Groups of shares under each other.
    Shares(Vec<(String, Vec<Share>)>),
    /// Clouds beside each other.
    Clouds {
        /// The horizontal axis and the vertical one.
        axes: [LogAxis; 2],
        /// The clouds.
        clouds: Vec<Cloud>,
        /// Clouds in a row: 2 for pairs of sides, or 3.
        columns: usize,
    },
    /// Panels of the same axes beside each other, with layers of points.
    Layers {
        /// The horizontal axis and the vertical one; `bound` is drawn across.
        axes: [LogAxis; 2],
        /// Name of the bounds in the legend.
        bounds: String,
        /// The panels.
        panels: Vec<LayeredPanel>,
    },
}

/// A chart and the name of its file, without an ending.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Name of the file, without an ending.
    pub stem: String,
    /// The title.
    pub title: String,
    /// Smaller line below the title.
    pub subtitle: String,
    /// Content of the chart.
    pub shown: ChartContent,
}
