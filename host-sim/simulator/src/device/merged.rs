//! The data sheet of a machine with the joint that was identified in it.
//!
//! | of the file | in the new file |
//! |---|---|
//! | motor, gear, supply | as in the file, but for `motor.dead_time_s`: see below |
//! | inertia, friction levels, viscous friction | measured |
//! | load, gravity | measured as far as they can be (`found_load.rs`), or else as in the file |
//! | Stribeck curve | measured if one was found, or else as in the file |
//! | backlash, stiffness, damping, bristles, ripple, `motor_share` | as in the file |
//! | difference of the friction between both ways | as in the file, around the measured mean |
//! | rotor's inertia | as in the file; the load has the rest of what was measured |
//!
//! What a dead time takes from each effort is in the friction that was measured. So the drive of
//! the new file has none, and `[device]` keeps the device's. With lost motion the breakaway that
//! was measured is that of a part of the joint: the file's stick friction stays, if it is within
//! the range of `spread.rs`, and its nearer end counts otherwise.
//!
//! A range of the new `[spread]` is the measured one. Where the file has a range, too, what both
//! have in common counts, if that has the measured value and its least share (`draft/spread.rs`) to
//! either side in it. Ranges of keys that were not measured stay.

use std::collections::BTreeMap;

use stiction::Parameters;
use toml::{Table, Value};
use toml_edit::{DocumentMut, Item};

use super::beyond::Beyond;
use super::contradiction::Contradiction;
use super::found_load::{FoundLoad, load};
use super::identified::Identified;
use super::machine_file;
use super::spread::{Ranges, commented};
use crate::data_sheet::{DataSheet, Mapping};
use crate::document::Document;
use crate::draft::spread::{LEAST, rounded};
use crate::error::shown;
use crate::machine::Joint;

/// Factor by which the back-EMF of a file may brake more than the joint was found to be braked.
const BRAKES: f64 = 1.25;

/// Share of the inertia that is the load's at least, if the gear is elastic.
const LIGHTEST: f64 = 0.05;

/// Keys that say the same in degrees and in radians, and the factor from the first to the second.
const PER_DEGREE: [&str; 2] = ["friction.viscous_nm_s_per_deg", "friction.viscous_nm_s_per_rad"];

/// A machine's file with the data sheet of a joint that was found.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Merged {
    /// Its text, without `[spread]`.
    pub text: String,
    /// Its `[spread]`.
    pub ranges: Ranges,
    /// Keys that are as in the file, since they were not measured.
    pub kept: Vec<String>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

/// Merges a joint that was found into the data sheet of a machine's file; `body` is the file of the
/// device in degrees and volts, `off` the ranges of its joint.
///
/// # Errors
/// Says why there is no such file.
pub(super) fn merged(
    found: &Identified,
    (joint, off): (&Joint, &Ranges),
    of: &Document,
    (body, parameters): (&str, &Parameters),
) -> Result<Merged, String> {
    const NO_SHEET: &str =
        "its joint is in degrees and volts; a data sheet in --machine has keys for it";
    let (sheet, mapping) = of.mapping().ok().flatten().ok_or(NO_SHEET)?;
    let mut new = Sheet::of(of, off)?;
    new.inertia(&sheet, &mapping, joint)?;
    new.viscous(&sheet, &mapping, joint)?;
    let difference = new.friction(found, &sheet, &mapping, joint)?;
    let beyond = Beyond::of(found);
    if let Some([_, speed]) = beyond.stribeck {
        new.set("friction", "stribeck_rad_per_s", speed.to_radians(), &["stribeck_deg_per_s"]);
    }
    new.load(load(found, &beyond, of, (&sheet, &mapping.units, difference)));
    new.ranges();
    let kept = new.kept();
    let text = new.text(body, &kept).ok_or("its tables cannot be written")?;
    match machine_file::read("", &text) {
        Ok(again) if again == *parameters => {
            let kept = kept.into_iter().map(|(key, _)| key).collect();
            Ok(Merged { text, ranges: new.written, kept, contradicted: new.contradicted })
        }
        Ok(_) => Err(format!(
            "the data sheet of {} gives a device other parameters than this one has",
            of.origin.name
        )),
        Err(error) => Err(error.to_string().trim_start_matches([':', ' ']).to_owned()),
    }
}

/// Says which keys a file loses that has no data sheet, though the machine's file has one; none if
/// it loses nothing that a prediction needs.
pub(super) fn lost(of: &Document) -> Option<String> {
    let lost = kept(|table| of.get(table)?.as_table().cloned(), &[]);
    let lost: Vec<String> = lost.into_iter().map(|(key, _)| key).collect();
    (!lost.is_empty()).then(|| lost.join(", "))
}

/// Sentence on what stays as in a file.
pub(super) fn kept_words(kept: &[String], file: &str, new: &Document) -> Option<String> {
    let one = |key: &String| {
        let value = new.get(key);
        let number = value.and_then(|one| one.as_float().or(one.as_integer().map(|n| n as f64)));
        number.map_or_else(|| key.clone(), |number| format!("{key} = {}", shown(number)))
    };
    let all: Vec<String> = kept.iter().map(one).collect();
    (!all.is_empty()).then(|| format!("kept from {file}, not measured: {}", all.join(", ")))
}

/// Keys of a joint that an identification does not measure, of some tables; `measured` are left
/// out.
fn kept(table: impl Fn(&str) -> Option<Table>, measured: &[String]) -> Vec<(String, Value)> {
    let mut kept = Vec::new();
    for name in ["motor", "gear", "load", "friction"] {
        for (key, value) in table(name).unwrap_or_default() {
            let path = format!("{name}.{key}");
            let is_drive = match name {
                "motor" => key != "rotor_inertia_kg_m2",
                "gear" => key == "ratio" || key == "efficiency",
                _ => false,
            };
            let is_core = MEASURED.contains(&path.as_str());
            let number = value.as_float().or(value.as_integer().map(|n| n as f64));
            let is_none = number.is_none_or(|number| number == 0.0);
            if !(is_drive || is_core || is_none || measured.contains(&path)) {
                kept.push((path, value));
            }
        }
    }
    kept
}

/// Tables of a data sheet, in their order.
const TABLES: [&str; 5] = ["motor", "gear", "load", "friction", "supply"];

/// Keys that every identification measures.
const MEASURED: [&str; 5] =
    ["load.inertia_kg_m2", "friction.stick_nm", "friction.slip_nm", PER_DEGREE[0], PER_DEGREE[1]];

/// The tables of a data sheet that is being written.
struct Sheet<'a> {
    of: &'a Document,
    /// Ranges of the joint in degrees and volts.
    off: &'a Ranges,
    tables: BTreeMap<&'static str, Table>,
    /// Keys that have a measured value.
    measured: Vec<String>,
    /// Values and ranges that were measured, with the least share of the range.
    found: Vec<(&'static str, f64, [f64; 2], f64)>,
    written: Ranges,
    contradicted: Vec<Contradiction>,
}

impl<'a> Sheet<'a> {
    fn of(of: &'a Document, off: &'a Ranges) -> Result<Self, String> {
        let table = |name| Some((name, of.get(name)?.as_table()?.clone()));
        let mut tables: BTreeMap<&'static str, Table> =
            TABLES.into_iter().filter_map(table).collect();
        tables.entry("motor").or_default().remove("dead_time_s");
        Ok(Self {
            of,
            off,
            tables,
            measured: Vec::new(),
            found: Vec::new(),
            written: Ranges::new(),
            contradicted: Vec::new(),
        })
    }

    fn off(&self, key: &str) -> Result<[f64; 2], String> {
        self.off.get(key).copied().ok_or_else(|| "there is no [spread]".into())
    }

    /// Sets a key to what was measured, and removes those that say the same.
    fn set(&mut self, name: &'static str, key: &str, value: f64, others: &[&str]) {
        let table = self.tables.entry(name).or_default();
        others.iter().for_each(|other| drop(table.remove(*other)));
        table.insert(key.into(), rounded(value).into());
        self.measured.push(format!("{name}.{key}"));
    }

    /// Remembers a measured range, and compares it with a value of the file.
    fn measured(
        &mut self,
        key: &'static str,
        (value, range, least): (f64, [f64; 2], f64),
        in_file: f64,
    ) {
        let of_file = self.of_file(key);
        self.contradicted.extend(Contradiction::between(key, (in_file, of_file), (value, range)));
        self.found.push((key, value, range, least));
    }

    /// The range of a key in the file's `[spread]`, in the key's unit.
    fn of_file(&self, key: &str) -> Option<[f64; 2]> {
        let spread = self.of.get("spread")?;
        let range = |key: &str| -> Option<[f64; 2]> {
            let array = spread.get(key)?.as_array()?;
            let end = |end: usize| {
                let value = array.get(end)?;
                value.as_float().or(value.as_integer().map(|n| n as f64))
            };
            Some([end(0)?, end(1)?])
        };
        let in_degrees = || range(PER_DEGREE[0]).filter(|_| key == PER_DEGREE[1]);
        range(key).or_else(|| Some(in_degrees()?.map(f64::to_degrees)))
    }

    /// Shares the measured inertia between rotor and load.
    fn inertia(
        &mut self,
        sheet: &DataSheet,
        mapping: &Mapping,
        joint: &Joint,
    ) -> Result<(), String> {
        let [weak, strong] = self.off("joint.gain_deg_per_s2_per_v")?;
        let of_gain = |gain: f64| 1.0 / mapping.units.per_degree(1.0) / gain;
        let whole = of_gain(joint.gain_deg_per_s2_per_v);
        let [light, heavy] = [of_gain(strong), of_gain(weak)];
        let per_rotor = sheet.gear.efficiency * sheet.gear.ratio.powi(2);
        let is_elastic = sheet.stiffness().is_some();
        let mut rotor = per_rotor * sheet.motor.rotor_inertia_kg_m2;
        let least = if is_elastic { LIGHTEST * whole } else { 0.0 };
        let in_file = sheet.load.inertia_kg_m2;
        if whole - rotor < least || whole <= rotor {
            // The rotor alone has more: both have the share that they have in the file, or the load
            // has all of it.
            let key = "motor.rotor_inertia_kg_m2";
            let of_rotor = sheet.motor.rotor_inertia_kg_m2;
            rotor = if is_elastic { rotor * whole / mapping.inertia } else { 0.0 };
            let measured = [whole / per_rotor, (heavy - whole) / per_rotor];
            self.contradicted.push(Contradiction::new(key, of_rotor, measured));
            self.set("motor", "rotor_inertia_kg_m2", rotor / per_rotor, &[]);
        }
        let load = whole - rotor;
        self.set("load", "inertia_kg_m2", load, &[]);
        let lowest = if is_elastic { LIGHTEST * load } else { 0.0 };
        let range = [(light - rotor).max(lowest), heavy - rotor];
        self.measured("load.inertia_kg_m2", (load, range, LEAST[0]), in_file);
        Ok(())
    }

    /// Takes the back-EMF's part from the measured viscous friction.
    fn viscous(
        &mut self,
        sheet: &DataSheet,
        mapping: &Mapping,
        joint: &Joint,
    ) -> Result<(), String> {
        let per_radian = 1.0 / mapping.units.per_degree(1.0);
        let rest = |volts: f64| volts * per_radian - mapping.back_emf;
        let braked = self.off("joint.viscous_v_per_deg_per_s")?;
        if BRAKES * braked[1] * per_radian < mapping.back_emf {
            return Err(format!(
                "the back-EMF of {} alone brakes more than the joint was found to be braked",
                self.of.origin.name
            ));
        }
        let [low, high] = braked.map(rest);
        let value = rest(joint.viscous_v_per_deg_per_s);
        let others = ["viscous_nm_s_per_deg"];
        self.set("friction", "viscous_nm_s_per_rad", value.max(0.0), &others);
        self.measured(PER_DEGREE[1], (value, [low, high], LEAST[1]), sheet.viscous());
        // Less than none is none, in the file.
        if let Some((_, value, range, _)) = self.found.last_mut() {
            *value = value.max(0.0);
            *range = range.map(|end| end.max(0.0));
        }
        Ok(())
    }

    /// Takes the measured levels, around which both ways differ as in the file; returns by how
    /// much, N m.
    fn friction(
        &mut self,
        found: &Identified,
        sheet: &DataSheet,
        mapping: &Mapping,
        joint: &Joint,
    ) -> Result<f64, String> {
        let torque = |volts: f64| mapping.units.effort(volts);
        let [slips, sticks] = [
            self.off("joint.friction.slip_v")?.map(torque),
            self.off("joint.friction.stick_v")?.map(torque),
        ];
        let [slip, mut stick] = [joint.friction.slip_v, joint.friction.stick_v].map(torque);
        let [of_slip, of_stick] = [sheet.slip(), sheet.stick()].map(|[one, other]| {
            // The mean of both ways is what was measured.
            0.5 * (one + other)
        });
        let mut difference = sheet.slip()[0] - sheet.slip()[1];
        if 0.5 * difference.abs() >= slip {
            let key = "friction.slip_reverse_nm";
            let [in_file, measured] = [sheet.slip()[1], slip];
            self.contradicted.push(Contradiction::new(key, in_file, [measured, slips[1] - slip]));
            let table = self.tables.entry("friction").or_default();
            ["slip_reverse_nm", "stick_reverse_nm"].iter().for_each(|key| drop(table.remove(*key)));
            difference = 0.0;
        }
        let half = 0.5 * difference;
        // With lost motion, the breakaway was that of a part of the joint.
        let is_kept = found.summary.doubts.lost_motion;
        if is_kept {
            stick = of_stick.max(sticks[0]).min(sticks[1]);
        }
        self.set("friction", "slip_nm", slip + half, &[]);
        self.set("friction", "stick_nm", stick + half, &[]);
        if difference != 0.0 {
            let table = self.tables.entry("friction").or_default();
            table.insert("slip_reverse_nm".into(), rounded(slip - half).into());
            table.insert("stick_reverse_nm".into(), rounded(stick - half).into());
        }
        let up = |range: [f64; 2]| range.map(|end| end + half);
        let of = [of_slip, of_stick].map(|level| level + half);
        self.measured("friction.slip_nm", (slip + half, up(slips), LEAST[2]), of[0]);
        self.measured("friction.stick_nm", (stick + half, up(sticks), LEAST[3]), of[1]);
        if is_kept && stick == of_stick {
            self.measured.retain(|key| key != "friction.stick_nm");
        }
        Ok(difference)
    }

    fn load(&mut self, load: FoundLoad) {
        let table = self.tables.entry("load").or_default();
        load.removed.iter().for_each(|key| drop(table.remove(*key)));
        for (key, value) in load.set {
            self.set("load", key, value, &[]);
        }
        self.contradicted.extend(load.contradicted);
        self.found.extend(
            load.ranges.into_iter().map(|(key, value, range)| (key, value, range, LEAST[0])),
        );
    }

    /// Writes the ranges: measured and narrowed by the file's, and those that were not measured.
    fn ranges(&mut self) {
        for (key, value, range, least) in &self.found {
            let range = narrowed(*range, self.of_file(key), (*value, *least));
            self.written.insert((*key).to_owned(), range.map(rounded));
        }
        let of_file = self.of.get("spread").and_then(Value::as_table);
        for (path, _) in of_file.into_iter().flatten() {
            let (name, key) = path.split_once('.').unwrap_or_default();
            let is_there = self.tables.get(name).and_then(|table| table.get(key)).is_some();
            let is_written = self.written.contains_key(path) || path == PER_DEGREE[0];
            if let Some(range) = self.of_file(path).filter(|_| is_there && !is_written) {
                self.written.insert(path.clone(), range);
            }
        }
    }

    /// Keys that are as in the file.
    fn kept(&self) -> Vec<(String, Value)> {
        let table = |name: &str| self.tables.get(name).cloned();
        let mut all = kept(table, &self.measured);
        let is_kept = !self.measured.iter().any(|key| key == "friction.stick_nm");
        let stick = self.tables.get("friction").and_then(|table| table.get("stick_nm"));
        all.extend(stick.filter(|_| is_kept).map(|one| ("friction.stick_nm".into(), one.clone())));
        all
    }

    /// Puts the tables in the place of `[joint]`.
    fn text(&self, body: &str, kept: &[(String, Value)]) -> Option<String> {
        let file = &self.of.origin.name;
        let encoder = self.of.get("encoder").and_then(Value::as_table).cloned();
        // A count is written as the device has it: by the lines, its step would be another number.
        let encoder: Table = encoder
            .into_iter()
            .flatten()
            .filter(|(key, _)| ["at", "noise_counts"].contains(&key.as_str()))
            .collect();
        let mut whole: DocumentMut = body.parse().ok()?;
        whole.remove("joint");
        let counts = whole.get_mut("encoder").and_then(Item::as_table_mut)?;
        let more: DocumentMut = toml::to_string(&encoder).ok()?.parse().ok()?;
        more.iter().for_each(|(key, item)| drop(counts.insert(key, item.clone())));
        let text =
            whole.to_string().replacen("[joint] is that", "[load] and [friction] are those", 1);
        let table = |name: &str| {
            let table = self.tables.get(name)?;
            (!table.is_empty()).then(|| (name.to_owned(), Value::Table(table.clone())))
        };
        let sheet: Table = TABLES.into_iter().filter_map(table).collect();
        let sheet = toml::to_string(&sheet).ok()?;
        let names: Vec<&str> = kept.iter().map(|(key, _)| key.as_str()).collect();
        let mut remarks = format!(
            "The joint as a data sheet: the motor, gear and supply of {file}, and what was measured. \
             Angles count from where the device was armed."
        );
        if !names.is_empty() {
            remarks += &format!(" Kept from {file}, not measured: {}.", names.join(", "));
        }
        for one in &self.contradicted {
            remarks += &format!(" Contradicted: {}.", one.words(file));
        }
        Some(format!("{text}\n{}{sheet}", commented(&remarks)))
    }
}

/// What a measured range and that of a file have in common, if the value and its least share to
/// either side are in it; otherwise the measured range.
fn narrowed(measured: [f64; 2], file: Option<[f64; 2]>, (value, least): (f64, f64)) -> [f64; 2] {
    let Some([low, high]) = file else { return measured };
    let both = [low.max(measured[0]), high.min(measured[1])];
    let off = least * value.abs();
    if both[0] <= value - off && value + off <= both[1] { both } else { measured }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_narrowed_by_the_file_s_if_both_have_the_value_and_its_least_share() {
        let of = |file| narrowed([0.9, 1.1], file, (1.0, 0.02));
        assert_eq!(of(None), [0.9, 1.1]);
        assert_eq!(of(Some([0.5, 2.0])), [0.9, 1.1]);
        assert_eq!(of(Some([0.95, 2.0])), [0.95, 1.1]);
        assert_eq!(of(Some([0.95, 1.05])), [0.95, 1.05]);
        // The value, or its least share, is not in both.
        assert_eq!(of(Some([0.99, 2.0])), [0.9, 1.1]);
        assert_eq!(of(Some([1.05, 2.0])), [0.9, 1.1]);
    }
}
