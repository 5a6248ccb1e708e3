//! Elements of charts: sizes, colours, lines and texts.

use kuva::render::render::{Primitive, TextAnchor};

pub(super) const WIDTH: f64 = 900.0;
pub(super) const HEADER: f64 = 70.0;
pub(super) const TEXT: u32 = 16;
pub(super) const SMALL: u32 = 13;

pub(super) const GRID: &str = "#DDDDDD";
pub(super) const INK: &str = "#000000";
pub(super) const MARK: &str = "#00548F";
pub(super) const BOUND: &str = "#D55E00";

/// Formats a power of ten for the numbers of an axis.
pub(super) fn power(decade: i32) -> String {
    if (-3..=4).contains(&decade) {
        files::error::shown(10f64.powi(decade))
    } else {
        format!("1e{decade}")
    }
}

pub(super) fn line(from: [f64; 2], to: [f64; 2], colour: &str, width: f64) -> Primitive {
    Primitive::Line {
        x1: from[0],
        y1: from[1],
        x2: to[0],
        y2: to[1],
        stroke: colour.into(),
        stroke_width: width,
        stroke_dasharray: None,
    }
}

pub(super) fn circle(at: [f64; 2], radius: f64, opacity: f64) -> Primitive {
    Primitive::Circle {
        cx: at[0],
        cy: at[1],
        r: radius,
        fill: MARK.into(),
        fill_opacity: Some(opacity),
        stroke: None,
        stroke_width: None,
    }
}

pub(super) fn text(content: &str, size: u32, at: [f64; 2], anchor: TextAnchor) -> Primitive {
    Primitive::Text {
        x: at[0],
        y: at[1],
        content: content.chars().filter(|c| !c.is_control()).collect(),
        size,
        anchor,
        rotate: None,
        bold: false,
        color: Some(INK.into()),
    }
}

pub(super) fn turned(content: &str, at: [f64; 2]) -> Primitive {
    match text(content, TEXT, at, TextAnchor::Middle) {
        Primitive::Text { x, y, content, size, anchor, bold, color, .. } => {
            Primitive::Text { x, y, content, size, anchor, rotate: Some(-90.0), bold, color }
        }
        other => other,
    }
}
