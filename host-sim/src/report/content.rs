//! The texts of the report, which are data: captions, drawings, tables, misprints.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::figures::Quantity;
use crate::error::Error;

/// Captions and drawings of the figures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figures {
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
    /// What it shows.
    pub caption: String,
    /// Names of our drawings.
    pub drawings: Vec<String>,
    /// What each of them shows; left out for a single one.
    #[serde(default)]
    pub parts: Vec<String>,
}

/// The drawings of the friction lab's figures.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Drawings {
    drawing: Vec<Drawing>,
}

/// A drawing of runs of the friction lab.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drawing {
    /// What [`FigureText::drawings`] calls it.
    pub stem: String,
    /// The figure of the thesis.
    pub thesis: String,
    /// Title of the files.
    pub title: String,
    /// From top to bottom.
    pub panels: Vec<PanelText>,
}

/// One of its panels.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelText {
    /// What it shows, and its unit.
    pub label: String,
    /// Relative to an ordinary one.
    pub height: f64,
    /// Each its name, its run, its body (from 1) and what of it.
    pub curves: Vec<(String, String, usize, Quantity)>,
}

/// The thesis's tables.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    table: Vec<TableText>,
}

/// One of them.
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
    /// Below the table.
    #[serde(default)]
    pub note: String,
    /// Its rows.
    pub rows: Vec<RowText>,
}

/// A row: what is used is a key of the experiment, the work of a run, or a text.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RowText {
    /// What it is.
    pub what: String,
    /// As printed.
    pub printed: String,
    /// Path of a key, parts separated by `/`.
    pub key: Option<String>,
    /// Unit of the key's value.
    #[serde(default)]
    pub unit: String,
    /// A run of the friction lab.
    pub evaluations: Option<String>,
    /// What is used, where it is neither.
    pub used: Option<String>,
    /// Why it differs.
    #[serde(default)]
    pub note: String,
}

/// Where the thesis is misprinted or leaves something open.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misprints {
    misprint: Vec<Misprint>,
}

/// One of them.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Misprint {
    /// Where.
    pub place: String,
    /// What is printed.
    pub printed: String,
    /// What is used.
    pub used: String,
    /// Why.
    pub why: String,
}

/// The figures, in the thesis's order.
///
/// # Errors
/// If the built-in text is broken.
pub fn figures() -> Result<Vec<FigureText>, Error> {
    parsed::<Figures>("figures", include_str!("../../report/figures.toml")).map(|all| all.figure)
}

/// The drawings of the friction lab, in the thesis's order.
///
/// # Errors
/// If the built-in text is broken.
pub fn drawings() -> Result<Vec<Drawing>, Error> {
    parsed::<Drawings>("drawings", include_str!("../../report/drawings.toml"))
        .map(|all| all.drawing)
}

/// The tables, in the thesis's order.
///
/// # Errors
/// If the built-in text is broken.
pub fn tables() -> Result<Vec<TableText>, Error> {
    parsed::<Tables>("tables", include_str!("../../report/tables.toml")).map(|all| all.table)
}

/// The misprints, in the thesis's order.
///
/// # Errors
/// If the built-in text is broken.
pub fn misprints() -> Result<Vec<Misprint>, Error> {
    parsed::<Misprints>("misprints", include_str!("../../report/misprints.toml"))
        .map(|all| all.misprint)
}

fn parsed<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Error> {
    toml::from_str(text)
        .map_err(|error| Error::Input(format!("the report's {name}: {}", error.message())))
}
