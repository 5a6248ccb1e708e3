//! Merges a joint identified from a log into a machine's file: `stiction identify LOG.csv --machine
//! FILE --into NEW`.
//!
//! The identified values replace inertia, friction, load and, with `--gravity` or `--stribeck`,
//! those terms, by the rules of `simulator::device::merged_sheet`. `[identified]` and `[spread]`
//! are rewritten. Everything else stays as it is, comments included. A log of motion does not show
//! the stick friction: `friction.stick_nm` stays unless it is below the slip friction, and
//! `limits.breakaway_v` stays unless the log shows more. An effort in volts includes the back-EMF
//! and the loss by a dead time: the back-EMF is subtracted from the viscous friction, and
//! `motor.dead_time_s` moves to `device.dead_time_s`. Angles of log and file must have the same
//! zero.

use std::f64::consts::TAU;

use toml::Value;
use toml_edit::{DocumentMut, Item};

use super::IdentifiedMachine;
use super::effort_unit::EffortUnit;
use super::gear::IdentifiedGear;
use super::model::{FittedModel, MachineModel};
use super::units::LogUnits;
use files::data_sheet::tables::EncoderPlace;
use files::data_sheet::{DataSheet, Mapping, resting_torque};
use files::document::Document;
use files::error::{Error, rounded as digits};
use files::file_text::put_number;
use files::typed_number::of_value as number;
use simulator::device::contradiction::Contradiction;
use simulator::device::found_load::MeasuredLoad;
use simulator::device::merged_sheet::{MeasuredJoint, MergedSheet, TABLES, kept_words};
use simulator::device::spread::commented;
use simulator::draft::spread::{
    LEAST, around, identified as said, of_inertia, part, rounded, table,
};

/// Relative range of a stick friction that the log does not identify.
const UNTOLD: f64 = 0.25;

/// Least error bar of a load, as a share of the slip friction.
const LEAST_LOAD: f64 = 0.02;

/// Range of the ratio of the log's smallest position change to a count. Outside of it the log is of
/// another encoder.
const COUNTS: [f64; 2] = [0.6, 1.7];

/// Largest number of counts of a disc. A position with a finer resolution is not counted.
const MOST_COUNTS: f64 = 4.0 * 65536.0;

/// Least difference at which a gear's ratio counts as wrong, as a share of the expected ratio.
const RATIO: f64 = 1e-3;

/// Least difference at which a gear's ratio counts as wrong, standard deviations.
const OFF: f64 = 4.0;

/// A machine's file with the joint of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct IntoMachine {
    /// Text of the file.
    pub text: String,
    /// Keys that the log does not identify and that are as in the file.
    pub kept: Vec<String>,
    /// Keys of the file that the log contradicts.
    pub contradicted: Vec<Contradiction>,
    /// Sentences about these keys, and about a gear that is not written.
    pub words: Vec<String>,
}

/// Machine's file that a log is compared and merged with.
#[derive(Clone, Debug)]
pub struct MachineOfLog {
    /// The file.
    pub document: Document,
    text: String,
    sheet: DataSheet,
    mapping: Mapping,
    /// Unit of the log's effort.
    pub unit: EffortUnit,
    /// Torque at the joint for one unit of the effort, N m.
    pub effort_gain: f64,
}

impl MachineOfLog {
    /// Opens the file `name`. `column` is the name of the effort's column, `gain` the value of
    /// `--effort-gain`.
    ///
    /// # Errors
    /// Returns an error about the file, or if the unit of the effort is unknown.
    pub fn open(name: &str, column: &str, gain: Option<f64>) -> Result<Self, Error> {
        let document = Document::open(name)?;
        let (sheet, mapping) = document.mapping()?.ok_or_else(|| {
            Error::Input(format!(
                "--machine {name}: its joint is in degrees and volts, but a log can only be merged \
                 into a data sheet; write one with `stiction new`, or leave --machine out"
            ))
        })?;
        let named = EffortUnit::of_name(column);
        let unit = named.or(gain.map(|gain| EffortUnit::of_gain(gain, &sheet, &mapping)));
        let unit = unit.ok_or_else(|| {
            Error::Input(format!(
                "the unit of `{column}` is unknown: set --effort-gain, the N m at the joint for \
                 each unit (from {name}: {} for a volt of the controller's output, {} for an \
                 ampere in the motor)",
                digits(EffortUnit::Volt.gain(&sheet, &mapping)),
                digits(EffortUnit::Ampere.gain(&sheet, &mapping)),
            ))
        })?;
        let effort_gain = gain.unwrap_or_else(|| unit.gain(&sheet, &mapping));
        let text = Document::text(name)?;
        Ok(Self { document, text, sheet, mapping, unit, effort_gain })
    }

    /// Compares the units of a log with the file. Returns the contradictions, one sentence each.
    /// `counts_per_turn` is the value of `--counts-per-turn`, if it is set.
    pub fn against(&self, found: &IdentifiedMachine, counts_per_turn: Option<f64>) -> Vec<String> {
        let Self { document, sheet, mapping, unit, effort_gain, .. } = self;
        let file = &document.origin.name;
        let mut words = Vec::new();
        if let Some(Ok(gear)) = &found.gear {
            words.extend(self.against_gear(gear, &found.scale));
        }
        // A torque can be the motor's; then its gain includes the gear.
        if *unit != EffortUnit::NewtonMetre && !unit.agrees(*effort_gain, sheet, mapping) {
            words.push(format!(
                "--effort-gain is {} N m for 1 {}, but {} of {file} give {}",
                digits(effort_gain.abs()),
                unit.symbol(),
                unit.keys(),
                digits(unit.gain(sheet, mapping))
            ));
        }
        // If the log has a column for the motor, the position is that of the load.
        let (count, key) = match found.gear {
            Some(_) if sheet.load_encoder.is_some() => {
                let load = sheet.load_encoder.map(|load| load.count_deg().to_radians());
                (load, "load_encoder.counts_per_turn")
            }
            Some(_) if sheet.encoder.at == Some(EncoderPlace::Motor) => (None, ""),
            _ => (mapping.count, "encoder.lines"),
        };
        let Some(count) = count else { return words };
        let turn = TAU / count;
        if let Some(counts) = counts_per_turn {
            if (counts / turn - 1.0).abs() > 1e-3 {
                words.push(format!(
                    "--counts-per-turn is {}, but {key} of {file} gives {} counts per turn of the \
                     joint",
                    digits(counts),
                    digits(turn)
                ));
            }
            return words;
        }
        let of_log = found.read.count;
        let is_counted = of_log > 0.0 && TAU / of_log <= MOST_COUNTS * sheet.gear.ratio;
        // The last written digit is not a count.
        let digit = (of_log / found.scale.position).log10();
        let is_digit = (digit - digit.round()).abs() < 1e-6;
        let is_same = (COUNTS[0]..=COUNTS[1]).contains(&(of_log / count));
        if is_counted && !is_digit && !is_same {
            words.push(format!(
                "the smallest position change of the log is {} rad, but {key} of {file} gives \
                 counts of {} rad",
                digits(of_log),
                digits(count)
            ));
        }
        words
    }

    /// Compares direction and ratio of a gear with the file. Returns the contradictions, one
    /// sentence each.
    fn against_gear(&self, gear: &IdentifiedGear, scale: &LogUnits) -> Vec<String> {
        let file = &self.document.origin.name;
        let found = gear.ratio.value;
        let mut words = Vec::new();
        if found < 0.0 {
            words.push(
                "the direction is wrong: the motor's column falls while the position rises".into(),
            );
        }
        let turns = self.sheet.gear.ratio;
        let at_motor = self.sheet.encoder.at == Some(EncoderPlace::Motor);
        let lines = self.sheet.encoder.lines.filter(|_| at_motor);
        let (expected, keys) = match (scale.motor, lines) {
            (Some(_), _) => (turns, "gear.ratio"),
            (None, Some(lines)) => (4.0 * f64::from(lines) * turns, "encoder.lines and gear.ratio"),
            (None, None) => return words,
        };
        let off = (OFF * gear.ratio.sd).max(RATIO * expected);
        if (found.abs() - expected).abs() > off {
            words.push(format!(
                "the ratio is wrong: {keys} of {file} give {} {}, but the log has {}",
                digits(expected),
                scale.ratio_unit(),
                digits(found.abs())
            ));
        }
        words
    }

    /// Merges the joint identified from `log` into the file.
    ///
    /// # Errors
    /// Returns the reason why log and file cannot be merged.
    pub fn merge(&self, log: &str, found: &IdentifiedMachine) -> Result<IntoMachine, Error> {
        let Self { document, sheet, mapping, unit, .. } = self;
        let file = &document.origin.name;
        let refuse = |why: String| Error::Input(format!("--machine {file}: {why}"));
        let measured = measured(found, sheet, *unit).ok_or_else(|| {
            refuse("the identified friction is negative, which is impossible".into())
        })?;
        let mut new = MergedSheet::of(document, (sheet, mapping), &measured).map_err(refuse)?;
        let unwritten = match &found.gear {
            Some(Ok(gear)) => new.set_gear(sheet, &gear.measured(1.0)).err(),
            _ => None,
        };
        let mut whole: DocumentMut =
            self.text.parse().map_err(|_| refuse("its text cannot be edited".into()))?;
        for name in TABLES {
            let Some(table) = new.tables.get(name) else { continue };
            edit(&mut whole, name, document.get(name).and_then(Value::as_table), table);
        }
        let MergedSheet { mut ranges, kept, mut contradicted, .. } = new;
        let dead_time_s = sheet.motor.dead_time_s;
        if measured.is_in_volts && dead_time_s > 0.0 {
            put_number(&mut whole, &["device"], "dead_time_s", dead_time_s);
        }
        let starts = mapping.volts(breakaway(&measured));
        let limit = document.number("limits.breakaway_v");
        if let Some(limit) = limit.filter(|limit| *limit < starts) {
            put_number(&mut whole, &["limits"], "breakaway_v", rounded(starts));
            contradicted.push(Contradiction::new("limits.breakaway_v", limit, [starts, 0.0]));
        }
        whole.remove("identified");
        whole.remove("spread");
        ranges.retain(|_, [low, high]| *low != 0.0 || *high != 0.0);
        let verdict = &found.verdict;
        let mut remark = format!(
            "The joint is from `stiction identify {log}`: a fit that is {}, with a residual of {} \
             % of the effort.",
            verdict.quality.word(),
            super::output::short(found.fitted.relative_residual_percent())
        );
        for one in &contradicted {
            remark += &format!(" Contradicted: {}.", one.words(file));
        }
        let text = commented(&remark)
            + &whole.to_string()
            + &said(verdict.quality.word(), &verdict.doubts)
            + &table(ranges.iter().map(|(key, range)| (key.as_str(), *range)));
        let written = Document::parse(file, &text)?;
        written.machine()?;
        let mut words: Vec<String> = kept_words(&kept, file, &written).into_iter().collect();
        words.extend(unwritten.map(|why| format!("the gear is not written: {why}")));
        words.extend(contradicted.iter().map(|one| format!("contradicted: {}", one.words(file))));
        Ok(IntoMachine { text, kept, contradicted, words })
    }
}

/// Returns the largest torque against which the joint of the log can rest, N m.
fn breakaway(measured: &MeasuredJoint) -> f64 {
    let gravity = measured.load.gravity.map_or(0.0, |[[sine, _], [cosine, _]]| sine.hypot(cosine));
    let friction = if measured.has_stick { measured.stick.0 } else { measured.slip.0 };
    resting_torque(friction, measured.load.offset[0], gravity)
}

/// Returns the measured joint; `None` if its friction is negative.
fn measured(
    found: &IdentifiedMachine,
    sheet: &DataSheet,
    unit: EffortUnit,
) -> Option<MeasuredJoint> {
    let fitted = &found.fitted;
    let bar = |name: &str| {
        let all = || found.parameters.iter();
        all().find(|(one, _)| *one == name).map_or(0.0, |(_, found)| 2.0 * found.sd)
    };
    let [forward, backward] = fitted.levels();
    let slip = 0.5 * (forward + backward);
    let [b_forward, b_backward] = fitted.viscous();
    let viscous = 0.5 * (b_forward + b_backward);
    let [of_inertia_, of_viscous, of_slip, of_stick] = LEAST;
    let inertia = fitted.inertia();
    let widest = |names: &[&str]| names.iter().map(|name| bar(name)).fold(0.0, f64::max);
    let off_slip = widest(&["coulomb", "coulomb_positive", "coulomb_negative"]);
    let off_viscous = widest(&["viscous", "viscous_positive", "viscous_negative"]);
    let off_viscous = off_viscous.max(of_viscous * viscous.abs());
    let stribeck = fitted.stribeck(0.0).max(0.0);
    let has_stick = stribeck > 0.0;
    let mut slips = around(slip, off_slip, of_slip);
    // The log does not show the stick friction: that of the file is used.
    let [one, other] = sheet.stick();
    let most = if has_stick { slip + stribeck } else { slip.max(0.5 * (one + other)) };
    let off_stick = off_slip + bar("stribeck");
    let mut sticks = around(most, off_stick, if has_stick { of_stick } else { UNTOLD });
    if has_stick {
        part(&mut slips, &mut sticks, [slip, most]);
    } else {
        sticks[0] = slips[1];
        sticks[1] = sticks[1].max(sticks[0]);
    }
    let gravity = || {
        let get = |name: &str| fitted.get(name).map_or(0.0, |found| found.value);
        ["gravity_sine", "gravity_cosine"].map(|name| [get(name), bar(name)])
    };
    let positions = found.moments.iter().map(|at| at.position);
    let range = positions
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    let MachineModel { has_gravity, stribeck: speed, .. } = fitted.model;
    (slip > 0.0).then(|| MeasuredJoint {
        inertia: (inertia, around(inertia, of_inertia(inertia, bar("inertia")), of_inertia_)),
        viscous: (viscous, [viscous - off_viscous, viscous + off_viscous]),
        slip: (slip, slips),
        stick: (most, sticks),
        has_stick,
        stribeck: speed.filter(|_| has_stick),
        load: MeasuredLoad {
            offset: [offset(fitted), bar("offset")],
            gravity: has_gravity.then(gravity),
            looked: has_gravity,
            range,
            least: LEAST_LOAD * slip,
        },
        is_in_volts: unit == EffortUnit::Volt,
    })
}

/// Returns half of the difference between the levels of both ways.
fn offset(fitted: &FittedModel) -> f64 {
    let [forward, backward] = fitted.levels();
    0.5 * (forward - backward)
}

/// Edits a table of a file: sets keys that differ, and removes keys that are not in `after`.
fn edit(whole: &mut DocumentMut, name: &str, before: Option<&toml::Table>, after: &toml::Table) {
    for (key, value) in after {
        if before.and_then(|before| before.get(key)) != Some(value) {
            number(value).into_iter().for_each(|number| put_number(whole, &[name], key, number));
        }
    }
    let gone = before.into_iter().flatten().filter(|(key, _)| !after.contains_key(*key));
    if let Some(table) = whole.get_mut(name).and_then(Item::as_table_like_mut) {
        gone.for_each(|(key, _)| drop(table.remove(key)));
    }
}
