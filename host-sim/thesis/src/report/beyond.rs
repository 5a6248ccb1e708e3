//! The chapter beyond the thesis: untuned laws on random joints.

use std::sync::{Mutex, PoisonError};

use serde::Serialize;

use super::evidence::ReportEvidence;
use super::figures::ReportDrawing;
use figure::figures;
use files::error::Error;
use simulator::progress::Silent;
use simulator::rules::rules;
use studies::ensemble::{
    Approach, DrawOptions, Ensemble, EnsembleHeader, Family, Group, LawSummary, run, sort_rows,
    summaries,
};

/// The experiment whose joints are drawn.
const UNTUNED: &str = "untuned-joints";

/// Joints of a family: with twenty, the widest interval is some 40 % wide, and the page still takes
/// only seconds.
const CASES: u64 = 20;

/// Seed of the joints; no law was tuned on it. The first year of the project.
const SEED: u64 = 2026;

/// The thesis's PD and its best law, the best sum of its laws, and the project's own law.
const LAWS: [&str; 4] = ["pd", "srnf", "feedforward+observer", "robust"];

/// One family with a joint of each kind: stiff, with bristles, flexible, the thesis's own.
const FAMILIES: [Family; 4] =
    [Family::Rigid, Family::LuGre, Family::FlexibleMotor, Family::ThesisAxis];

/// The chapter on untuned laws.
#[derive(Debug, Serialize)]
pub struct UntunedChapter {
    cases: u64,
    seed: u64,
    rows: Vec<RowView>,
}

#[derive(Debug, Serialize)]
struct RowView {
    family: String,
    law: String,
    success: String,
    interval: String,
    rest: String,
    settled: String,
    hunting: usize,
}

/// Runs the ensemble of the chapter.
///
/// # Errors
/// Returns an error if the core refuses the gains of a rule.
pub fn ranked() -> Result<UntunedChapter, Error> {
    let ensemble = Ensemble {
        seed: SEED,
        cases: CASES,
        kind: DrawOptions::ORDINARY,
        approach: Approach::Profiled,
        moves: 0,
        families: FAMILIES.to_vec(),
        rules: rules(&LAWS.map(str::to_owned))?,
    };
    let rows = Mutex::new(Vec::new());
    run(
        &ensemble,
        &Silent,
        |_, _, _| true,
        |row| {
            rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
            Ok(())
        },
    )?;
    let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    let header = EnsembleHeader::of(&ensemble);
    sort_rows(&header, &mut rows);
    let families = summaries(&header, &rows);
    let rows = families.iter().flat_map(|(group, laws)| laws.iter().map(|law| view(group, law)));
    Ok(UntunedChapter { cases: CASES, seed: SEED, rows: rows.collect() })
}

fn view(group: &Group, law: &LawSummary) -> RowView {
    let percent = |share: f64| format!("{:.0}", 100.0 * share);
    let [low, high] = law.success_ci;
    let shown = |value: Option<f64>, digits: usize| match value {
        Some(value) if value.is_finite() => format!("{value:.digits$}"),
        _ => "never".to_owned(),
    };
    RowView {
        family: group.name.clone(),
        law: law.law.clone(),
        success: percent(law.success as f64 / law.cases.max(1) as f64),
        interval: format!("{} to {}", percent(low), percent(high)),
        rest: shown(law.rest_counts.quantile(0.9), 1),
        settled: shown(law.settling_s.quantile(0.5), 2),
        hunting: law.hunting_cases,
    }
}

/// Draws the three joints.
///
/// # Errors
/// Returns an error if no run makes the drawing.
pub fn drawing(evidence: &ReportEvidence) -> Result<ReportDrawing, Error> {
    let stem = format!("{UNTUNED}-compared");
    figures(UNTUNED, evidence.axis(UNTUNED), &[])
        .into_iter()
        .find(|named| named.stem == stem)
        .map(|named| ReportDrawing { stem: named.stem, figure: named.figure })
        .ok_or_else(|| Error::Figure(format!("`{stem}`: no run makes it")))
}
