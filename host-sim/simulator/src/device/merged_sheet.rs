//! The data sheet of a machine, merged with its identified joint.
//!
//! | in the file | in the new file |
//! |---|---|
//! | motor, gear, supply | as in the file, but for `motor.dead_time_s`: see below |
//! | inertia, friction levels, viscous friction | measured |
//! | load, gravity | measured if possible (`found_load.rs`), otherwise as in the file |
//! | Stribeck curve | measured if one was found, otherwise as in the file |
//! | backlash, stiffness, damping, bristles, ripple, `motor_share` | as in the file |
//! | difference of the friction between both ways | as in the file, around the measured mean |
//! | rotor's inertia | as in the file; the load has the rest of the measured inertia |
//!
//! Friction measured in volts includes the effort that a dead time costs. So the drive of the new
//! file has no dead time, and `[device]` keeps the device's. With lost motion, the measured
//! breakaway is that of a part of the joint: the file's stick friction stays if it is within the
//! range of `spread.rs`; otherwise the nearer end of that range is used.
//!
//! A range of the new `[spread]` is the measured one. If the file has a range as well, the
//! intersection of both is used, provided that it contains the measured value with its least share
//! (`draft/spread.rs`) to either side. Ranges of keys that were not measured stay.

use std::collections::BTreeMap;

use toml::{Table, Value};

use super::contradiction::Contradiction;
use super::found_load::{FoundLoad, MeasuredLoad, load};
use super::measured_gear::MeasuredGear;
use super::spread::Ranges;
use crate::draft::spread::{LEAST, around, rounded};
use files::data_sheet::{DataSheet, Mapping};
use files::document::Document;
use files::error::shown;
use files::typed_number::of_value as number;

/// Largest ratio of the file's viscous friction by back-EMF to the upper end of the measured
/// viscous friction.
const BRAKES: f64 = 1.25;

/// Least share of the load in the inertia, if the gear is elastic.
const LIGHTEST: f64 = 0.05;

/// Least error bar of a gear's value, as a share of it.
const LEAST_OF_GEAR: f64 = 0.02;

/// Viscous friction per degree and per radian: two keys of the same quantity.
const PER_DEGREE: [&str; 2] = ["friction.viscous_nm_s_per_deg", "friction.viscous_nm_s_per_rad"];

/// Measured values of a joint, on the joint's side of the gear, each with its range.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredJoint {
    /// Inertia of rotor and load together, kg m^2.
    pub inertia: (f64, [f64; 2]),
    /// Viscous friction, N m s/rad.
    pub viscous: (f64, [f64; 2]),
    /// Slip friction, mean of both directions, N m.
    pub slip: (f64, [f64; 2]),
    /// Stick friction, mean of both directions, N m.
    pub stick: (f64, [f64; 2]),
    /// Whether the stick friction was measured; its range is used in any case.
    pub has_stick: bool,
    /// Stribeck velocity, rad/s, if a curve was found.
    pub stribeck: Option<f64>,
    /// Load.
    pub load: MeasuredLoad,
    /// Whether the measured effort is the output of the controller, V: then the viscous friction
    /// includes the back-EMF, and the friction includes the loss by a dead time.
    pub is_in_volts: bool,
}

/// Data sheet of a machine's file, merged with the measured joint.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedSheet {
    /// Tables of the data sheet.
    pub tables: BTreeMap<&'static str, Table>,
    /// Ranges for `[spread]`.
    pub ranges: Ranges,
    /// Keys that were not measured and are as in the file.
    pub kept: Vec<String>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

impl MergedSheet {
    /// Merges a measured joint into the data sheet of a machine's file.
    ///
    /// # Errors
    /// Returns why no data sheet can hold both.
    pub fn of(
        of: &Document,
        (sheet, mapping): (&DataSheet, &Mapping),
        measured: &MeasuredJoint,
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

    /// Sets the measured stiffness and slack of the gear; `of` is the data sheet of the file.
    ///
    /// # Errors
    /// Returns half a sentence with the reason if the data sheet cannot have an elastic gear.
    pub fn set_gear(&mut self, of: &DataSheet, gear: &MeasuredGear) -> Result<(), &'static str> {
        let above = |name: &str, key: &str| {
            self.tables.get(name).and_then(|table| number(table.get(key)?)).unwrap_or(0.0) > 0.0
        };
        let two_bodies = above("motor", "rotor_inertia_kg_m2") && above("load", "inertia_kg_m2");
        let becomes_elastic = two_bodies && gear.stiffness.is_some();
        if of.stiffness().is_none() && !becomes_elastic {
            return Err("an elastic gear needs a stiffness, and an inertia of rotor and load");
        }
        if let Some(measured) = gear.stiffness {
            let keys = ["gear.stiffness_nm_per_rad", "gear.stiffness_nm_per_deg"];
            self.replace(keys, of.stiffness(), measured);
        }
        if let Some([value, off]) = gear.slack_deg {
            let keys = ["gear.backlash_deg", "gear.backlash_rad"];
            let in_file = of.backlash().unwrap_or(0.0).to_degrees();
            self.replace(keys, Some(in_file), [if value > off { value } else { 0.0 }, off]);
        }
        Ok(())
    }

    /// Replaces a value of the gear, and its range. The value has two keys: `key` is in the unit of
    /// the numbers; `other` is in another unit, and is removed.
    fn replace(
        &mut self,
        [key, other]: [&'static str; 2],
        in_file: Option<f64>,
        [value, off]: [f64; 2],
    ) {
        let range = self.ranges.remove(key);
        let found = in_file.and_then(|in_file| {
            Contradiction::between(key, (in_file, range), (value, [value - off, value + off]))
        });
        self.contradicted.extend(found);
        self.ranges.remove(other);
        if value > 0.0 {
            let measured = around(value, off, LEAST_OF_GEAR);
            self.ranges.insert(key.to_owned(), measured.map(rounded));
        }
        self.kept.retain(|kept| kept != key && kept != other);
        let table = self.tables.entry("gear").or_default();
        table.remove(other.trim_start_matches("gear."));
        table.insert(key.trim_start_matches("gear.").into(), rounded(value).into());
    }
}

/// Returns the sentence that lists the keys copied from a file; `None` if there are none.
pub fn kept_words(kept: &[String], file: &str, new: &Document) -> Option<String> {
    let one = |key: &String| {
        new.number(key).map_or_else(|| key.clone(), |number| format!("{key} = {}", shown(number)))
    };
    let all: Vec<String> = kept.iter().map(one).collect();
    (!all.is_empty()).then(|| format!("kept from {file}, not measured: {}", all.join(", ")))
}

/// Returns the keys of motor, gear, load and friction with a number other than zero that an
/// identification does not measure. Keys of the drive and those in `measured` are left out.
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
            let is_none = number(&value).is_none_or(|number| number == 0.0);
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

/// A data sheet under construction.
struct Sheet<'a> {
    of: &'a Document,
    tables: BTreeMap<&'static str, Table>,
    /// Keys with a measured value.
    measured: Vec<String>,
    /// Measured keys with value, range, and least share of the range.
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

    /// Sets a key to a measured value, and removes other keys of the same quantity.
    fn set(&mut self, name: &'static str, key: &str, value: f64, others: &[&str]) {
        let table = self.tables.entry(name).or_default();
        others.iter().for_each(|other| drop(table.remove(*other)));
        table.insert(key.into(), rounded(value).into());
        self.measured.push(format!("{name}.{key}"));
    }

    /// Stores a measured range, and compares it with the value of the file.
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

    /// Returns the range of a key in the file's `[spread]`, in the key's unit.
    fn of_file(&self, key: &str) -> Option<[f64; 2]> {
        let spread = self.of.get("spread")?;
        let range = |key: &str| -> Option<[f64; 2]> {
            let array = spread.get(key)?.as_array()?;
            let end = |end: usize| array.get(end).and_then(number);
            Some([end(0)?, end(1)?])
        };
        let in_degrees = || range(PER_DEGREE[0]).filter(|_| key == PER_DEGREE[1]);
        range(key).or_else(|| Some(in_degrees()?.map(f64::to_degrees)))
    }

    /// Splits the measured inertia between rotor and load.
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
            // The rotor of the file alone has more inertia. With an elastic gear, rotor and load
            // keep their shares of the file; otherwise the load has all of it.
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

    /// Sets the measured viscous friction, less the part that is due to the back-EMF.
    fn viscous(
        &mut self,
        sheet: &DataSheet,
        back_emf: f64,
        (value, range): (f64, [f64; 2]),
    ) -> Result<(), String> {
        if BRAKES * range[1] < back_emf {
            return Err(format!(
                "the back-EMF of {} alone is larger than the measured viscous friction",
                self.of.origin.name
            ));
        }
        let value = value - back_emf;
        let [low, high] = range.map(|end| end - back_emf);
        let others = ["viscous_nm_s_per_deg"];
        self.set("friction", "viscous_nm_s_per_rad", value.max(0.0), &others);
        self.measured(PER_DEGREE[1], (value, [low, high], LEAST[1]), sheet.viscous());
        // The file has no negative friction.
        if let Some((_, value, range, _)) = self.found.last_mut() {
            *value = value.max(0.0);
            *range = range.map(|end| end.max(0.0));
        }
        Ok(())
    }

    /// Sets the measured friction levels; the difference between both directions is that of the
    /// file. Returns this difference, N m.
    fn friction(&mut self, sheet: &DataSheet, measured: &MeasuredJoint) -> f64 {
        let ((slip, slips), (mut stick, sticks)) = (measured.slip, measured.stick);
        // The measured levels are means of both directions.
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
            // Both ways have the measured level.
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

    /// Sets the ranges: measured ones, narrowed by those of the file, and those of keys that were
    /// not measured.
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

    /// Returns the keys that are as in the file.
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

/// Returns the intersection of a measured range with that of a file, if it contains the value with
/// its least share to either side; otherwise the measured range.
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
