//! The texts of the report, which are data: captions, drawings, tables, misprints.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use files::error::Error;

/// Quantity of a body in a curve.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Position.
    Position,
    /// Position of the spring's far end, which moves at constant speed.
    FarEnd,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Force that friction and inertia balance.
    Input,
    /// Friction.
    Friction,
    /// p of the Reset Integrator, µm.
    Deflection,
    /// Rate of p, mm/s: that of the body while it sticks, else zero (eq. 2).
    DeflectionRate,
}

/// Captions and drawings of the figures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureTexts {
    figure: Vec<FigureText>,
}

/// A result that the thesis shows in one figure, or in two: measured and simulated.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FigureText {
    /// Its numbers in the thesis.
    pub numbers: Vec<u32>,
    /// Those of them that the thesis measured on its robot.
    #[serde(default)]
    pub robot: Vec<u32>,
    /// Heading.
    pub title: String,
    /// Caption.
    pub caption: String,
    /// Names of our drawings.
    pub drawings: Vec<String>,
    /// Title of each drawing; empty for a single one.
    #[serde(default)]
    pub parts: Vec<String>,
}

/// The drawings of the friction lab's figures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Drawings {
    drawing: Vec<LabDrawing>,
}

/// A drawing of runs of the friction lab.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabDrawing {
    /// Name of the drawing in [`FigureText::drawings`].
    pub stem: String,
    /// The figure of the thesis.
    pub thesis: String,
    /// Title of the files.
    pub title: String,
    /// Panels from top to bottom.
    pub panels: Vec<PanelText>,
}

/// One panel of a drawing.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelText {
    /// Label with the unit.
    pub label: String,
    /// Height relative to an ordinary panel.
    pub height: f64,
    /// Curves: name, run, body (from 1) and quantity.
    pub curves: Vec<(String, String, usize, Quantity)>,
}

/// The thesis's tables.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableTexts {
    table: Vec<TableText>,
}

/// One table of the thesis.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableText {
    /// Its number in the thesis.
    pub number: u32,
    /// Heading.
    pub title: String,
    /// The built-in experiment that its keys are looked up in.
    #[serde(default)]
    pub experiment: String,
    /// Note below the table.
    #[serde(default)]
    pub note: String,
    /// Its rows.
    pub rows: Vec<RowText>,
}

/// A row; the value used is a key of the experiment, the work of a run, or a text.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RowText {
    /// Quantity.
    pub what: String,
    /// Value that the thesis prints.
    pub printed: String,
    /// Path of a key, parts separated by `/`.
    pub key: Option<String>,
    /// Unit of the key's value.
    #[serde(default)]
    pub unit: String,
    /// A run of the friction lab.
    pub evaluations: Option<String>,
    /// Text for a value that is neither a key nor a run's work.
    pub used: Option<String>,
    /// Reason of a difference.
    #[serde(default)]
    pub note: String,
}

/// Misprints and gaps of the thesis.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misprints {
    misprint: Vec<Misprint>,
}

/// One misprint.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Misprint {
    /// Place in the thesis.
    pub place: String,
    /// Text that the thesis prints.
    pub printed: String,
    /// Text that this project uses instead.
    pub used: String,
    /// Reason why the printed text is wrong.
    pub why: String,
}

/// Returns the figures, in the thesis's order.
///
/// # Errors
/// Returns an error if the built-in text is invalid.
pub fn figures() -> Result<Vec<FigureText>, Error> {
    parsed::<FigureTexts>("figures", include_str!("../../page/figures.toml")).map(|all| all.figure)
}

/// Returns the drawings of the friction lab, in the thesis's order.
///
/// # Errors
/// Returns an error if the built-in text is invalid.
pub fn drawings() -> Result<Vec<LabDrawing>, Error> {
    parsed::<Drawings>("drawings", include_str!("../../page/drawings.toml")).map(|all| all.drawing)
}

/// Returns the tables, in the thesis's order.
///
/// # Errors
/// Returns an error if the built-in text is invalid.
pub fn tables() -> Result<Vec<TableText>, Error> {
    parsed::<TableTexts>("tables", include_str!("../../page/tables.toml")).map(|all| all.table)
}

/// Returns the misprints, in the thesis's order.
///
/// # Errors
/// Returns an error if the built-in text is invalid.
pub fn misprints() -> Result<Vec<Misprint>, Error> {
    parsed::<Misprints>("misprints", include_str!("../../page/misprints.toml"))
        .map(|all| all.misprint)
}

fn parsed<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Error> {
    toml::from_str(text)
        .map_err(|error| Error::Input(format!("the report's {name}: {}", error.message())))
}
