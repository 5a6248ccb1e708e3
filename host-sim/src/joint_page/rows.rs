//! The tables of the page on a joint.

use serde::Serialize;

use files::data_sheet::overview;
use files::document::Document;
use files::error::{Error, rounded};
use files::machine::MachineFile;
use studies::benchmark::Score;
use studies::ensemble::{CaseResult, SortedValues};
use studies::selftest::{
    MoveMeasures, MoveRange, Prediction, bounds, ends, late, late_at_load, rest_at_load,
};
use studies::tuning::{GainSearch, SideFigures, TuningResult};

/// A quantity of the joint, in the core's units and in SI units.
#[derive(Debug, Serialize)]
pub struct DescriptionRow {
    what: String,
    core: String,
    si: String,
    how: String,
}

/// Describes the joint of a file; for a data sheet, with every derived number.
///
/// # Errors
/// Returns an error that names what is wrong with the file.
pub fn described(document: &Document) -> Result<Vec<DescriptionRow>, Error> {
    let machine = document.machine()?;
    let mut rows: Vec<DescriptionRow> = match document.mapping()? {
        Some((sheet, mapping)) => overview::rows(&sheet, &mapping)
            .into_iter()
            .map(|overview::DerivedNumber { what, si, core, how }| DescriptionRow {
                what: what.into(),
                core,
                si,
                how,
            })
            .collect(),
        None => {
            let joint = &machine.joint;
            let row = |what: &str, value: f64, unit: &str| DescriptionRow {
                what: what.into(),
                core: format!("{} {unit}", rounded(value)),
                si: String::new(),
                how: String::new(),
            };
            vec![
                row("acceleration per volt", joint.gain_deg_per_s2_per_v, "deg/s^2"),
                row("viscous friction", joint.viscous_v_per_deg_per_s, "V s/deg"),
                row("stick friction", joint.friction.stick_v, "V"),
                row("slip friction", joint.friction.slip_v, "V"),
                row("encoder's count", machine.encoder.resolution_deg(), "deg"),
            ]
        }
    };
    rows.push(DescriptionRow {
        what: "samples".into(),
        core: format!("{} a second", rounded(1.0 / machine.sampling.sample_time_s())),
        si: String::new(),
        how: String::new(),
    });
    Ok(rows)
}

/// A key of the joint with its range.
#[derive(Debug, Serialize)]
pub struct SpreadRow {
    key: String,
    low: String,
    high: String,
}

/// Splits `KEY=LOW..HIGH` into rows.
pub fn off(spreads: &[String]) -> Vec<SpreadRow> {
    let number = |text: &str| text.parse().map_or_else(|_| text.to_owned(), rounded);
    let parts = spreads.iter().filter_map(|text| {
        let (key, range) = text.split_once('=')?;
        let (low, high) = range.split_once("..")?;
        Some(SpreadRow { key: key.into(), low: number(low), high: number(high) })
    });
    parts.collect()
}

/// Metrics of a law, on the file's joint and on the joints around it.
#[derive(Debug, Serialize)]
pub struct LawRow {
    name: String,
    place: String,
    rest: String,
    settled: String,
    /// Rest, settling and verdict at the encoder and at the load, by the file's goal.
    sides: [SideCells; 2],
    tracking: String,
    chatter: String,
    success: String,
    around_settled: String,
    around_rest: String,
    margins: String,
    remark: String,
}

/// Metrics of a law's steps at one side of the gear.
#[derive(Debug, Serialize)]
pub struct SideCells {
    rest: String,
    settled: String,
    goal: &'static str,
}

impl SideCells {
    fn of(rest: Option<f64>, settled_s: Option<f64>, success: Option<bool>) -> Self {
        Self {
            rest: shown(rest, 1),
            settled: settled_s.map_or_else(|| "never".into(), |s| format!("{s:.2}")),
            goal: match success {
                Some(true) => "met",
                Some(false) => "missed",
                None => "-",
            },
        }
    }
}

fn shown(value: Option<f64>, digits: usize) -> String {
    value.filter(|value| value.is_finite()).map_or_else(|| "-".into(), |v| format!("{v:.digits$}"))
}

/// Returns the rows of the laws, in the order of the benchmark.
///
/// # Errors
/// Returns the errors of [`GainSearch::standing`].
pub fn laws(
    scores: &[Score],
    request: &GainSearch,
    tuned: &[TuningResult],
) -> Result<Vec<LawRow>, Error> {
    let law = |score: &Score| {
        let standing = request.standing(&score.controller)?;
        let figures = standing.figures;
        let [low, high] = standing.margins;
        let found = tuned.iter().find(|one| one.controller == score.controller);
        let remark = match (score.disqualified, found) {
            (Some(why), _) => why.describe().to_owned(),
            (None, Some(one)) if one.better => "tuned".into(),
            (None, Some(_)) => "nothing better was found".into(),
            (None, None) => String::new(),
        };
        let sides = &score.sides;
        // At the encoder, and, if the encoder cannot measure slack, at the load as well.
        let of_sides = |cell: &dyn Fn(&SideFigures) -> String| {
            let at_load = cell(&figures.at_load);
            if score.is_ranked_at_encoder {
                format!("{} / {at_load}", cell(&figures.at_encoder))
            } else {
                at_load
            }
        };
        Ok(LawRow {
            sides: [
                SideCells::of(
                    sides.rest_at_encoder_counts,
                    sides.settled_at_encoder_s,
                    sides.success_at_encoder,
                ),
                SideCells::of(
                    sides.rest_at_load_counts,
                    sides.settled_at_load_s,
                    sides.success_at_load,
                ),
            ],
            name: score.controller.clone(),
            place: shown(score.mean_place, 1),
            rest: shown(score.rest_error_counts, 1),
            settled: score.settling_time_s.map_or_else(|| "never".into(), |s| format!("{s:.2}")),
            tracking: shown(score.tracking_rms_deg, 3),
            chatter: shown(score.chatter_v_per_s, 2),
            success: of_sides(&|side| format!("{} of {}", side.successes, figures.cases)),
            around_settled: of_sides(&|side| shown(Some(side.settling_s), 2)),
            around_rest: of_sides(&|side| shown(Some(side.rest_counts), 1)),
            margins: if low < high {
                format!("{} to {}", rounded(low), rounded(high))
            } else {
                "-".into()
            },
            remark,
        })
    };
    scores.iter().map(law).collect()
}

/// A gain of the chosen law.
#[derive(Debug, Serialize)]
pub struct GainRow {
    key: String,
    value: String,
    before: String,
}

/// Returns the gains of a controller, with the values before tuning.
pub fn gains(machine: &MachineFile, controller: &str, tuned: &[TuningResult]) -> Vec<GainRow> {
    let turned = tuned.iter().find(|one| one.controller == controller && one.better);
    let turned = turned.map_or(&[][..], |one| &one.gains);
    let written = machine.controller.get(controller);
    let table = written.and_then(|gains| toml::Table::try_from(gains).ok()).unwrap_or_default();
    let number = |value: &toml::Value| value.as_float();
    // A gain of zero is off, or belongs to another law.
    let entries = table.iter().filter_map(|(key, value)| Some((key, number(value)?)));
    entries
        .filter(|(_, value)| *value != 0.0)
        .map(|(key, value)| {
            let before = turned.iter().find(|gain| gain.key == key && gain.from != gain.to);
            GainRow {
                key: key.clone(),
                value: rounded(value),
                before: before.map_or_else(String::new, |gain| rounded(gain.from)),
            }
        })
        .collect()
}

/// Describes the worst joint in a sentence.
pub fn worst(drawn: &[String], delay: u8, row: &CaseResult) -> String {
    let fault = row.faults().next().map(|name| format!(", and ends with {name}"));
    let settled = row
        .settled_at_encoder_s
        .map_or_else(|| "never settles".into(), |s| format!("settles in {} s", rounded(s)));
    let keys: Vec<String> = drawn
        .iter()
        .filter_map(|text| {
            let (key, value) = text.split_once('=')?;
            Some(format!("{key} = {}", value.parse().map_or_else(|_| value.into(), rounded)))
        })
        .collect();
    let at_load = if row.rest_at_load_counts == row.rest_at_encoder_counts {
        String::new()
    } else {
        format!(" at the encoder and {} at the load", rounded(row.rest_at_load_counts))
    };
    format!(
        "The worst of them {settled}{}, rests {} counts off{at_load}, and has {} and {delay} \
         samples of delay.",
        fault.unwrap_or_default(),
        rounded(row.rest_at_encoder_counts),
        keys.join(", ")
    )
}

/// Expected results of a self-test.
#[derive(Debug, Serialize)]
pub struct ExpectedSelftest {
    range: String,
    joints: usize,
    ended: Vec<String>,
    figures: Vec<Figure>,
    moves: Vec<Move>,
    /// Number of moves in which the median joint misses the goal, at the encoder and at the load.
    missed: [Option<u32>; 2],
    /// The device's parameters that the prediction assumes, as TOML.
    parameters: String,
}

#[derive(Debug, Serialize)]
struct Figure {
    what: &'static str,
    low: String,
    median: String,
    high: String,
    allowed: String,
}

#[derive(Debug, Serialize)]
struct Move {
    to: String,
    settled: String,
    rest: String,
    settled_at_load: String,
    rest_at_load: String,
}

/// Returns the metrics of a prediction with their bounds, and its moves one by one.
pub fn expected(
    range: MoveRange,
    targets: &[f64],
    prediction: &Prediction,
    parameters: String,
) -> ExpectedSelftest {
    let figures = bounds(prediction).into_iter().map(|check| {
        let digits = check.digits();
        let value = |value: f64| format!("{value:.digits$}");
        let [low, median, high] = check.predicted.map(value);
        let allowed = match check.least {
            Some(least) => format!("{} to {}", value(least), value(check.most)),
            None => format!("up to {}", value(check.most)),
        };
        Figure { what: check.words, low, median, high, allowed }
    });
    let spread = |place: usize, digits: usize, of: &dyn Fn(&MoveMeasures) -> f64| {
        let all = prediction.moves.iter().filter_map(|moves| moves.get(place)).map(of);
        let sorted = SortedValues::new(all);
        let both = sorted.quantile(0.0).zip(sorted.max());
        both.map_or("-".into(), |(low, high)| ends([low, high], digits, " to "))
    };
    let moves = targets.iter().enumerate().map(|(place, to)| Move {
        to: rounded(*to),
        settled: spread(place, 2, &late),
        rest: spread(place, 0, &|one| one.rest_counts),
        settled_at_load: spread(place, 2, &late_at_load),
        rest_at_load: spread(place, 0, &rest_at_load),
    });
    ExpectedSelftest {
        range: rounded(range.deg),
        joints: prediction.figures.len(),
        ended: prediction.ended.clone(),
        figures: figures.collect(),
        moves: moves.collect(),
        missed: prediction.missed_of_most(),
        parameters,
    }
}
