//! A figure on a page of HTML: the drawing inline, and the style and script of all pages.

use serde::Serialize;

/// Style sheet of a page with figures, CSS.
pub const STYLE: &str = include_str!("../page/page.css");

/// Script of a page with figures: it enlarges a drawing.
pub const SCRIPT: &str = include_str!("../page/page.js");

/// A drawing of a figure.
#[derive(Serialize)]
pub struct DrawingView {
    /// Title; empty if the figure's heading is enough.
    pub title: String,
    /// Inline SVG.
    pub svg: String,
}
