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

/// A point of a cloud; an infinite value is drawn on the upper edge.
pub type Point = [f64; 2];

/// One cloud among others of the same axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// What it is of.
    pub name: String,
    /// Its points.
    pub points: Vec<Point>,
}

/// An axis of a cloud, in powers of ten.
#[derive(Clone, Debug, PartialEq)]
pub struct LogAxis {
    /// Its label, with the unit.
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
    /// A small grey dot each.
    Dot,
    /// Steps from point to point, in the order of the horizontal axis.
    Steps,
    /// A hollow square each.
    Square,
    /// A filled diamond each.
    Diamond,
}

/// Points of one kind in a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What they are, for the legend. The same name has the same mark in all panels.
    pub name: String,
    /// Their mark.
    pub mark: Mark,
    /// The points.
    pub points: Vec<Point>,
}

/// A panel of layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredPanel {
    /// What it is of.
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
        /// What the bounds are, for the legend.
        bounds: String,
        /// The panels.
        panels: Vec<LayeredPanel>,
    },
}

/// A chart and the name of its file, without an ending.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// The name of the file.
    pub stem: String,
    /// The title.
    pub title: String,
    /// Smaller line below the title.
    pub subtitle: String,
    /// What is shown.
    pub shown: ChartContent,
}
