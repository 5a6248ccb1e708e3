//! The grid of every text table: within 80 columns, with aligned numbers.

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, Table, presets};

/// Least width of a terminal, columns.
const WIDTH: u16 = 80;

/// Creates a table with a header; the first column is left-aligned, all others right-aligned.
pub fn new(header: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH)
        .set_header(
            header.iter().map(|title| Cell::new(title).set_alignment(CellAlignment::Right)),
        );
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    if let Some(first) = table.column_mut(0) {
        first.set_constraint(ColumnConstraint::ContentWidth);
        first.set_cell_alignment(CellAlignment::Left);
    }
    table
}

/// Formats a number with the given number of decimals; a dash for `None`.
pub fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(
        || "-".into(),
        |value| {
            // Columns have no room for more digits; a value that is not finite has a line of its
            // own.
            if !value.is_finite() || value.abs() >= 1e6 {
                return if value.is_finite() { format!("{value:.1e}") } else { "-".into() };
            }
            let text = format!("{value:.digits$}");
            // No minus in front of a zero.
            if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
                text.trim_start_matches('-').into()
            } else {
                text
            }
        },
    )
}
