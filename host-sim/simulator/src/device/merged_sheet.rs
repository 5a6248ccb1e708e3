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
//! What a dead time takes from each effort is in the friction that was measured in volts. So the
//! drive of the new file has none, and `[device]` keeps the device's. With lost motion the breakaway
//! that was measured is that of a part of the joint: the file's stick friction stays, if it is
//! within the range of `spread.rs`, and its nearer end counts otherwise.
//!
//! A range of the new `[spread]` is the measured one. Where the file has a range, too, what both
//! have in common counts, if that has the measured value and its least share (`draft/spread.rs`) to
//! either side in it. Ranges of keys that were not measured stay.

use std::collections::BTreeMap;

use toml::{Table, Value};

use super::contradiction::Contradiction;
use super::found_load::{FoundLoad, MeasuredLoad, load};
use super::spread::Ranges;
use crate::data_sheet::{DataSheet, Mapping};
use crate::document::Document;
use crate::draft::spread::{LEAST, rounded};
use crate::error::shown;

/// Factor by which the back-EMF of a file may brake more than the joint was found to be braked.
const BRAKES: f64 = 1.25;

/// Share of the inertia that is the load's at least, if the gear is elastic.
const LIGHTEST: f64 = 0.05;

/// Keys that say the same in degrees and in radians, and the factor from the first to the second.
const PER_DEGREE: [&str; 2] = ["friction.viscous_nm_s_per_deg", "friction.viscous_nm_s_per_rad"];

/// A joint that was measured, at the joint: each value with its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Inertia of rotor and load together, kg m^2.
    pub inertia: (f64, [f64; 2]),
    /// Viscous friction, N m s/rad.
    pub viscous: (f64, [f64; 2]),
    /// Slip friction, mean of both ways, N m.
    pub slip: (f64, [f64; 2]),
    /// Stick friction, likewise.
    pub stick: (f64, [f64; 2]),
    /// Whether the stick friction was measured; its range counts in any case.
    pub has_stick: bool,
    /// Stribeck velocity, rad/s, if a curve was found.
    pub stribeck: Option<f64>,
    /// Load.
    pub load: MeasuredLoad,
    /// Whether the measured effort is the output of the controller, V: then the back-EMF is in the
    /// viscous friction, and what a dead time takes is in the friction.
    pub is_in_volts: bool,
}

/// Data sheet of a machine's file with the measured joint in it.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedSheet {
    /// Its tables.
    pub tables: BTreeMap<&'static str, Table>,
    /// Ranges of its `[spread]`.
    pub ranges: Ranges,
    /// Keys that are as in the file, since they were not measured.
    pub kept: Vec<String>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

impl MergedSheet {
    /// Merges a measured joint into the data sheet of a machine's file.
    ///
    /// # Errors
    /// Says why no data sheet has both.
    pub fn of(
        of: &Document,
        (sheet, mapping): (&DataSheet, &Mapping),
        measured: &Measured,
    ) -> Result<Self, String> {
        let mut new = Sheet::of(of, measured.is_in_volts);
        new.inertia(sheet, mapping, measured.inertia);
        let back_emf = if measured.is_in_volts { mapping.back_emf } else { 0.0 };
        new.viscous(sheet, back_emf, measured.viscous)?;
        let difference = new.friction(sheet, measured);
        if let Some(speed) = measured.stribeck {
            new.set("friction", "stribeck_rad_per_s", speed, &["stribeck_deg_per_s"]);
        }
        new.load(load(&measured.load, of, sheet, difference));
        new.ranges();
        let kept = new.kept();
        let Sheet { tables, written: ranges, contradicted, .. } = new;
        Ok(Self { tables, ranges, kept, contradicted })
    }
}

/// Returns the sentence on what stays as in a file.
pub fn kept_words(kept: &[String], file: &str, new: &Document) -> Option<String> {
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
pub(super) fn kept(table: impl Fn(&str) -> Option<Table>, measured: &[String]) -> Vec<String> {
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
                kept.push(path);
            }
        }
    }
    kept
}

/// Tables of a data sheet, in their order.
pub const TABLES: [&str; 5] = ["motor", "gear", "load", "friction", "supply"];

/// Keys that every identification measures.
const MEASURED: [&str; 5] =
    ["load.inertia_kg_m2", "friction.stick_nm", "friction.slip_nm", PER_DEGREE[0], PER_DEGREE[1]];

/// The tables of a data sheet that is being written.
struct Sheet<'a> {
    of: &'a Document,
    tables: BTreeMap<&'static str, Table>,
    /// Keys that have a measured value.
    measured: Vec<String>,
    /// Values and ranges that were measured, with the least share of the range.
    found: Vec<(&'static str, f64, [f64; 2], f64)>,
    written: Ranges,
    contradicted: Vec<Contradiction>,
}

impl<'a> Sheet<'a> {
    fn of(of: &'a Document, is_in_volts: bool) -> Self {
        let table = |name| Some((name, of.get(name)?.as_table()?.clone()));
        let mut tables: BTreeMap<_, Table> = TABLES.into_iter().filter_map(table).collect();
        if is_in_volts {
            tables.entry("motor").or_default().remove("dead_time_s");
        }
        Self {
            of,
            tables,
            measured: Vec::new(),
            found: Vec::new(),
            written: Ranges::new(),
            contradicted: Vec::new(),
        }
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
        (whole, [light, heavy]): (f64, [f64; 2]),
    ) {
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
    }

    /// Takes the back-EMF's part from the measured viscous friction.
    fn viscous(
        &mut self,
        sheet: &DataSheet,
        back_emf: f64,
        (value, range): (f64, [f64; 2]),
    ) -> Result<(), String> {
        if BRAKES * range[1] < back_emf {
            return Err(format!(
                "the back-EMF of {} alone brakes more than the joint was found to be braked",
                self.of.origin.name
            ));
        }
        let value = value - back_emf;
        let [low, high] = range.map(|end| end - back_emf);
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
    fn friction(&mut self, sheet: &DataSheet, measured: &Measured) -> f64 {
        let ((slip, slips), (mut stick, sticks)) = (measured.slip, measured.stick);
        // The mean of both ways is what was measured.
        let [of_slip, of_stick] =
            [sheet.slip(), sheet.stick()].map(|[one, other]| 0.5 * (one + other));
        let mut difference = sheet.slip()[0] - sheet.slip()[1];
        if 0.5 * difference.abs() >= slip {
            let key = "friction.slip_reverse_nm";
            let [in_file, measured] = [sheet.slip()[1], slip];
            self.contradicted.push(Contradiction::new(key, in_file, [measured, slips[1] - slip]));
            difference = 0.0;
        }
        let half = 0.5 * difference;
        let is_kept = !measured.has_stick;
        if is_kept {
            stick = of_stick.max(sticks[0]).min(sticks[1]);
        }
        self.set("friction", "slip_nm", slip + half, &[]);
        self.set("friction", "stick_nm", stick + half, &[]);
        if difference != 0.0 {
            let table = self.tables.entry("friction").or_default();
            table.insert("slip_reverse_nm".into(), rounded(slip - half).into());
            table.insert("stick_reverse_nm".into(), rounded(stick - half).into());
        } else if let Some(table) = self.tables.get_mut("friction") {
            // Both ways have the measured level, whatever the file has for the other one.
            ["slip_reverse_nm", "stick_reverse_nm"].iter().for_each(|key| drop(table.remove(*key)));
        }
        let up = |range: [f64; 2]| range.map(|end| end + half);
        let of = [of_slip, of_stick].map(|level| level + half);
        self.measured("friction.slip_nm", (slip + half, up(slips), LEAST[2]), of[0]);
        self.measured("friction.stick_nm", (stick + half, up(sticks), LEAST[3]), of[1]);
        if is_kept && stick == of_stick {
            self.measured.retain(|key| key != "friction.stick_nm");
        }
        difference
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
    fn kept(&self) -> Vec<String> {
        let table = |name: &str| self.tables.get(name).cloned();
        let mut all = kept(table, &self.measured);
        const STICK: &str = "friction.stick_nm";
        if !self.measured.iter().any(|key| key == STICK) {
            all.push(STICK.into());
        }
        all
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
