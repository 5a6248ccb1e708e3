//! Tables for people, within 80 columns.

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};

use crate::experiment::Motion;
use crate::run::RunResult;

/// The width that a terminal is sure to have.
const WIDTH: u16 = 80;

/// A table with a header, the first column to the left and all others to the right.
pub fn new(header: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH)
        .set_header(header.iter().map(|title| Cell::new(title).set_alignment(CellAlignment::Right)));
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    if let Some(first) = table.column_mut(0) {
        first.set_cell_alignment(CellAlignment::Left);
    }
    table
}

/// The results of an experiment: one table for each kind of motion, and a line below for each run that went wrong.
pub fn render(results: &[RunResult]) -> String {
    let of_kind =
        |wanted: fn(&Motion) -> bool| results.iter().filter(|r| wanted(&r.plan.motion)).collect::<Vec<_>>();
    let mut parts = Vec::new();
    let steps = of_kind(|motion| matches!(motion, Motion::Step(_)));
    if !steps.is_empty() {
        parts.push(step_table(&steps));
    }
    let trajectories = of_kind(|motion| matches!(motion, Motion::Trajectory(_)));
    if !trajectories.is_empty() {
        parts.push(trajectory_table(&trajectories));
    }
    let ramps = of_kind(|motion| matches!(motion, Motion::Ramp(_)));
    if !ramps.is_empty() {
        parts.push(ramp_table(&ramps));
    }
    let remarks: Vec<String> = results.iter().filter_map(remark).collect();
    if !remarks.is_empty() {
        parts.push(remarks.join("\n") + "\n");
    }
    parts.join("\n")
}

/// A number with so many digits behind the point, or a dash.
pub fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(
        || "-".into(),
        |value| {
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

fn step_table(results: &[&RunResult]) -> String {
    let header = [
        "step",
        "rest\ncounts",
        "overshoot\ndeg",
        "rise\ns",
        "settled\ns",
        "rms\ndeg",
        "chatter\nV/s",
        "hunts\ndeg",
    ];
    let mut table = new(&header);
    for result in results {
        let m = &result.metrics;
        table.add_row([
            result.plan.label.clone(),
            number(m.rest_error_counts, 1),
            number(m.overshoot_deg, 3),
            number(m.rise_time_s, 2),
            number(m.settling_time_s, 2),
            number(m.rms_error_deg, 3),
            number(m.control_total_variation_v_per_s, 2),
            number(m.hunting_peak_to_peak_deg, 4),
        ]);
    }
    format!("{table}\n")
}

fn trajectory_table(results: &[&RunResult]) -> String {
    let header = ["trajectory", "rest\ncounts", "cruise\ndeg", "rms\ndeg", "max\ndeg", "chatter\nV/s"];
    let mut table = new(&header);
    for result in results {
        let m = &result.metrics;
        table.add_row([
            result.plan.label.clone(),
            number(m.rest_error_counts, 1),
            number(m.cruise_error_deg, 4),
            number(m.rms_error_deg, 4),
            number(m.max_error_deg, 4),
            number(m.control_total_variation_v_per_s, 2),
        ]);
    }
    format!("{table}\n")
}

fn ramp_table(results: &[&RunResult]) -> String {
    let mut table = new(&["ramp (V/s)", "stick\nV", "slip\nV", "slip, lag corrected\nV"]);
    for result in results {
        let m = &result.metrics;
        table.add_row([
            result.plan.label.clone(),
            number(m.stick_v, 4),
            number(m.slip_v, 4),
            number(m.slip_corrected_v, 4),
        ]);
    }
    format!("{table}\n")
}

fn remark(result: &RunResult) -> Option<String> {
    let label = &result.plan.label;
    match result.diverged_at_s {
        Some(time_s) => Some(format!("{label}: diverged, not finite at {time_s} s; the run ends there")),
        None if result.unstable => Some(format!("{label}: unstable")),
        None => None,
    }
}
