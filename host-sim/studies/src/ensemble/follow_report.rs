//! Reports of ramps and sines: CSV, JSON, and tables for people.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::drawn_case::DrawOptions;
use super::follow::{
    BAND_COUNTS, BAND_S, FollowSummary, JUDGED_FROM_S, LASTS_S, RAMPS, RampSummary,
};
use super::follow_sine::{SINES, SineSummary, SinesSummary};
use super::run::Ensemble;
use super::statistics::SortedValues;
use files::error::Error;
use simulator::output::grid::{self, number};

/// Renders the rows as CSV.
///
/// # Errors
/// If a row cannot be written.
pub fn follow_csv(rows: &[impl Serialize]) -> Result<Vec<u8>, Error> {
    let cannot = |error: csv::Error| Error::Run(error.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(cannot)?;
    }
    writer.into_inner().map_err(|error| cannot(csv::Error::from(error.into_error())))
}

/// Returns the summaries as JSON.
pub fn follow_json(ensemble: &Ensemble, summaries: &[FollowSummary]) -> Value {
    let ramp = |ramp: &RampSummary| {
        json!({
            "counts_per_s": ramp.counts_per_s,
            "rms_counts_p50": quantile(&ramp.rms_counts, 0.5),
            "rms_counts_p90": quantile(&ramp.rms_counts, 0.9),
            "peak_counts_p90": quantile(&ramp.peak_counts, 0.9),
            "peak_counts_max": quantile(&ramp.peak_counts, 1.0),
            "stops_p50": quantile(&ramp.stops, 0.5),
            "follow": ramp.follow,
            "joints": ramp.joints,
        })
    };
    let laws = summaries.iter().map(|summary| {
        json!({
            "family": summary.family,
            "law": summary.law,
            "slowest_counts_per_s": summary.slowest(),
            "ramps": summary.ramps.iter().map(ramp).collect::<Vec<_>>(),
        })
    });
    let mut object = options(ensemble);
    object.extend([
        ("lasts_s".to_owned(), json!(LASTS_S)),
        ("judged_from_s".into(), json!(JUDGED_FROM_S)),
        ("band_counts".into(), json!(BAND_COUNTS)),
        ("band_s".into(), json!(BAND_S)),
        ("laws".into(), laws.collect()),
    ]);
    Value::Object(object)
}

/// Returns a quantile; `None` if a fault made it infinite.
fn quantile(values: &SortedValues, p: f64) -> Option<f64> {
    values.quantile(p).filter(|value| value.is_finite())
}

/// Returns the options of the command, with which each JSON report begins.
fn options(ensemble: &Ensemble) -> Map<String, Value> {
    let DrawOptions { hard, rate_hz, condition, bridge } = ensemble.kind;
    Map::from_iter([
        ("version".to_owned(), json!(env!("CARGO_PKG_VERSION"))),
        ("seed".into(), json!(ensemble.seed)),
        ("cases".into(), json!(ensemble.cases)),
        ("hard".into(), json!(hard)),
        ("rate_hz".into(), json!(rate_hz)),
        ("condition".into(), json!(condition.name())),
        ("bridge".into(), json!(bridge.name())),
    ])
}

/// A statistic of a ramp over the joints.
type Statistic = fn(&RampSummary) -> Option<f64>;

/// Renders the summaries for people: for each family the errors by law and speed, then the slowest
/// speeds.
pub fn follow_table(ensemble: &Ensemble, summaries: &[FollowSummary]) -> String {
    let titles: Vec<String> = RAMPS.iter().map(ToString::to_string).collect();
    let header: Vec<&str> =
        std::iter::once("law").chain(titles.iter().map(String::as_str)).collect();
    let mut text = String::new();
    for of_family in summaries.chunk_by(|a, b| a.family == b.family) {
        let tables: [(&str, Statistic); 3] = [
            ("rms of the error, counts, median of the joints", |ramp| {
                ramp.rms_counts.quantile(0.5)
            }),
            ("rms of the error, counts, 9 of 10 joints", |ramp| ramp.rms_counts.quantile(0.9)),
            ("largest error, counts, 9 of 10 joints", |ramp| ramp.peak_counts.quantile(0.9)),
        ];
        let joints = of_family.first().map_or(0, |law| law.ramps.first().map_or(0, |r| r.joints));
        let family = of_family.first().map_or("", |law| &law.family);
        for (what, value) in tables {
            let mut table = grid::new(&header);
            for law in of_family {
                let finite = |ramp| value(ramp).filter(|value| value.is_finite());
                let cells = law.ramps.iter().map(|ramp| number(finite(ramp), 2));
                table.add_row(std::iter::once(law.law.clone()).chain(cells));
            }
            text += &format!(
                "{family}{}, {joints} joints, by counts a second: {what}\n\n",
                ensemble.kind.suffix()
            );
            text += &format!("{}\n\n", table.trim_fmt());
        }
    }
    text + &slowest_table(summaries, false)
}

/// Renders the slowest speed without steps, by law and family; in Markdown for a page.
pub fn slowest_table(summaries: &[FollowSummary], is_markdown: bool) -> String {
    let mut families: Vec<&str> = Vec::new();
    let mut laws: Vec<&str> = Vec::new();
    for FollowSummary { family, law, .. } in summaries {
        if !families.contains(&&**family) {
            families.push(family);
        }
        if !laws.contains(&&**law) {
            laws.push(law);
        }
    }
    let cell = |law: &str, family: &str| {
        let found = summaries.iter().find(|found| found.law == law && found.family == family);
        found.map_or_else(String::new, |found| {
            found.slowest().map_or_else(|| "none".into(), |speed| speed.to_string())
        })
    };
    let row = |law: &str| -> Vec<String> {
        std::iter::once(law.to_owned())
            .chain(families.iter().map(|family| cell(law, family)))
            .collect()
    };
    let header: Vec<&str> = std::iter::once("law").chain(families.iter().copied()).collect();
    if is_markdown {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let titles: Vec<String> = header.iter().map(ToString::to_string).collect();
        let rows: String = laws.iter().map(|law| line(&row(law))).collect();
        return line(&titles) + &format!("|{}\n", "---|".repeat(header.len())) + &rows;
    }
    let mut table = grid::new(&header);
    for law in laws {
        table.add_row(row(law));
    }
    format!(
        "Slowest speed without steps, counts a second: there and above, 9 of 10 joints\nstay \
         within {BAND_COUNTS} counts of the set point, or its travel in {BAND_S} s.\n\n{}\n",
        table.trim_fmt()
    )
}

/// Returns the summaries of sines as JSON.
pub fn sine_json(ensemble: &Ensemble, summaries: &[SinesSummary]) -> Value {
    let sine = |sine: &SineSummary| {
        json!({
            "hz": sine.hz,
            "rms_mrad_p50": quantile(&sine.rms_mrad, 0.5),
            "rms_mrad_p90": quantile(&sine.rms_mrad, 0.9),
            "reversal_mrad_p90": quantile(&sine.reversal_mrad, 0.9),
            "reversal_mrad_max": quantile(&sine.reversal_mrad, 1.0),
            "joints": sine.joints,
        })
    };
    let laws = summaries.iter().map(|summary| {
        json!({
            "family": summary.family,
            "law": summary.law,
            "sines": summary.sines.iter().map(sine).collect::<Vec<_>>(),
        })
    });
    let mut object = options(ensemble);
    object.insert("laws".into(), laws.collect());
    Value::Object(object)
}

/// A statistic of a sine over the joints.
type SineStatistic = fn(&SineSummary) -> Option<f64>;

/// Renders the summaries of sines for people: for each family the errors by law and frequency.
pub fn sine_table(ensemble: &Ensemble, summaries: &[SinesSummary]) -> String {
    let titles: Vec<String> = SINES.iter().map(|hz| format!("{hz} Hz")).collect();
    let header: Vec<&str> =
        std::iter::once("law").chain(titles.iter().map(String::as_str)).collect();
    let mut text = String::new();
    for of_family in summaries.chunk_by(|a, b| a.family == b.family) {
        let Some(first) = of_family.first() else { continue };
        let joints = first.sines.first().map_or(0, |sine| sine.joints);
        let tables: [(&str, SineStatistic); 3] = [
            ("rms of the error, mrad, median of the joints", |sine| sine.rms_mrad.quantile(0.5)),
            ("rms of the error, mrad, 9 of 10 joints", |sine| sine.rms_mrad.quantile(0.9)),
            ("largest error at a reversal, mrad, 9 of 10 joints", |sine| {
                sine.reversal_mrad.quantile(0.9)
            }),
        ];
        for (what, value) in tables {
            let mut table = grid::new(&header);
            for law in of_family {
                let finite = |sine| value(sine).filter(|value| value.is_finite());
                let cells = law.sines.iter().map(|sine| number(finite(sine), 2));
                table.add_row(std::iter::once(law.law.clone()).chain(cells));
            }
            let condition = ensemble.kind.suffix();
            text += &format!("{}{condition}, {joints} joints: {what}\n\n", first.family);
            text += &format!("{}\n\n", table.trim_fmt());
        }
    }
    text
}
