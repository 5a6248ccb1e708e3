//! Machine's file of an identified joint with a data sheet. `merged_sheet.rs` has the rules.

use stiction::Parameters;
use toml::{Table, Value};
use toml_edit::{DocumentMut, Item};

use super::beyond::{LEAST as LEAST_LOAD, UnmodelledEffects};
use super::contradiction::Contradiction;
use super::found_load::{MeasuredLoad, WIDE_DEG};
use super::identified::IdentifiedJoint;
use super::machine_file;
use super::merged_sheet::{MeasuredJoint, MergedSheet, TABLES, kept};
use super::spread::{Ranges, commented, deviations};
use dynamics::joint::CoreUnits;
use files::document::Document;
use files::machine::JointTable;

/// A machine's file with the data sheet of an identified joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MergedFile {
    /// Text, without `[spread]`.
    pub text: String,
    /// Ranges for `[spread]`.
    pub ranges: Ranges,
    /// Keys that were not measured and are as in the file.
    pub kept: Vec<String>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

/// Merges an identified joint into the data sheet of a machine's file; `body` is the file of the
/// device in degrees and volts, `off` the ranges of its joint.
///
/// # Errors
/// Returns why the merged file cannot be written.
pub(super) fn merged(
    found: &IdentifiedJoint,
    (joint, off): (&JointTable, &Ranges),
    of: &Document,
    (body, parameters): (&str, &Parameters),
) -> Result<MergedFile, String> {
    const NO_SHEET: &str =
        "its joint is in degrees and volts; a data sheet in --machine has keys for it";
    // The twists of the device are those of the gear before: those of the measured joint differ.
    const TWO: &str = "its two encoders are as the device has them, with the twists it tolerates";
    const NO_LOAD: &str = "the data sheet in --machine has no [load_encoder], and the device has \
                           two encoders: add that table, with its counts_per_turn";
    let has_two = parameters.controller.motor.count().is_some();
    if has_two && found.gear.is_none() {
        return Err(TWO.into());
    }
    if has_two && of.get("load_encoder").is_none() {
        return Err(NO_LOAD.into());
    }
    let (sheet, mapping) = of.mapping().ok().flatten().ok_or(NO_SHEET)?;
    let measured = measured(found, joint, off, &mapping.units).ok_or("there is no [spread]")?;
    let mut new = MergedSheet::of(of, (&sheet, &mapping), &measured)?;
    if let Some(gear) = &found.gear {
        new.set_gear(&sheet, gear)?;
    }
    let text = text(&new, of, (body, has_two)).ok_or("its tables cannot be written")?;
    match machine_file::read("", &text) {
        Ok(again) if again == *parameters || has_two && is_same(&again, parameters) => {
            let MergedSheet { ranges, kept, contradicted, .. } = new;
            Ok(MergedFile { text, ranges, kept, contradicted })
        }
        Ok(_) => Err(format!(
            "with the data sheet of {}, a device would have other parameters than this one",
            of.origin.name
        )),
        Err(error) => Err(error.to_string().trim_start_matches([':', ' ']).to_owned()),
    }
}

/// Returns whether two devices with two encoders have the same parameters, except for two: the
/// twists that they tolerate, which the measured gear changes, and the motion, which the counts of
/// the data sheet round otherwise.
fn is_same(one: &Parameters, other: &Parameters) -> bool {
    let mut one = Parameters { motion: other.motion.clone(), ..one.clone() };
    let motor = &mut one.controller.motor;
    (motor.twist, motor.swing) = (other.controller.motor.twist, other.controller.motor.swing);
    one == *other
}

/// Returns the measured joint of a device in SI units.
fn measured(
    found: &IdentifiedJoint,
    joint: &JointTable,
    off: &Ranges,
    units: &CoreUnits,
) -> Option<MeasuredJoint> {
    let range = |key: &str| off.get(key).copied();
    let torque = |volts: f64| units.effort(volts);
    let per_radian = 1.0 / units.per_degree(1.0);
    let [weak, strong] = range("joint.gain_deg_per_s2_per_v")?;
    let friction = &joint.friction;
    let estimate = found.summary.estimate.as_ref()?;
    let deviations = deviations(found);
    let bar = |[value, sd]: [f32; 2]| [f64::from(value), deviations * f64::from(sd)].map(torque);
    let beyond = UnmodelledEffects::of(found);
    let half = 0.5 * f64::from(found.summary.range).to_radians();
    Some(MeasuredJoint {
        inertia: (
            per_radian / joint.gain_deg_per_s2_per_v,
            [per_radian / strong, per_radian / weak],
        ),
        viscous: (
            joint.viscous_v_per_deg_per_s * per_radian,
            range("joint.viscous_v_per_deg_per_s")?.map(|volts| volts * per_radian),
        ),
        slip: (torque(friction.slip_v), range("joint.friction.slip_v")?.map(torque)),
        stick: (torque(friction.stick_v), range("joint.friction.stick_v")?.map(torque)),
        // With lost motion, the breakaway was that of a part of the joint.
        has_stick: !found.summary.doubts.lost_motion,
        stribeck: beyond.stribeck.map(|[_, speed]| speed.to_radians()),
        load: MeasuredLoad {
            offset: bar(estimate.offset),
            gravity: beyond.gravity.map(|both| both.map(|one| one.map(torque))),
            looked: f64::from(found.summary.range) >= WIDE_DEG,
            range: [-half, half],
            least: LEAST_LOAD * torque(f64::from(estimate.coulomb[0])),
        },
        is_in_volts: true,
    })
}

/// Returns the keys that a file loses because it has no data sheet while the machine's file has
/// one; `None` if a prediction needs none of them.
pub(super) fn lost(of: &Document) -> Option<String> {
    let lost = kept(|table| of.get(table)?.as_table().cloned(), &[]);
    (!lost.is_empty()).then(|| lost.join(", "))
}

/// Returns the file with the tables of a data sheet in place of `[joint]`. Two encoders are those
/// of the machine's file, since only they state the gear between them.
fn text(new: &MergedSheet, of: &Document, (body, has_two): (&str, bool)) -> Option<String> {
    let file = &of.origin.name;
    let encoder = of.get("encoder").and_then(Value::as_table).cloned();
    // The count of the device is written as it is: computed from the lines, it would differ.
    let encoder: Table = encoder
        .into_iter()
        .flatten()
        .filter(|(key, _)| ["at", "noise_counts"].contains(&key.as_str()))
        .collect();
    let mut whole: DocumentMut = body.parse().ok()?;
    whole.remove("joint");
    if has_two {
        whole.remove("motor_encoder");
        for name in ["encoder", "load_encoder"] {
            let both: Table = [(name.to_owned(), of.get(name)?.clone())].into_iter().collect();
            let both: DocumentMut = toml::to_string(&both).ok()?.parse().ok()?;
            whole.insert(name, both.get(name)?.clone());
        }
    } else {
        let counts = whole.get_mut("encoder").and_then(Item::as_table_mut)?;
        let more: DocumentMut = toml::to_string(&encoder).ok()?.parse().ok()?;
        more.iter().for_each(|(key, item)| drop(counts.insert(key, item.clone())));
    }
    let text = whole.to_string().replacen("[joint] is that", "[load] and [friction] are those", 1);
    let table = |name: &str| {
        let table = new.tables.get(name)?;
        (!table.is_empty()).then(|| (name.to_owned(), Value::Table(table.clone())))
    };
    let sheet: Table = TABLES.into_iter().filter_map(table).collect();
    let sheet = toml::to_string(&sheet).ok()?;
    let mut remarks = format!(
        "The joint as a data sheet: motor, gear and supply of {file}, and the measured values. \
         Angles count from the position at arming."
    );
    if !new.kept.is_empty() {
        remarks += &format!(" Kept from {file}, not measured: {}.", new.kept.join(", "));
    }
    for one in &new.contradicted {
        remarks += &format!(" Contradicted: {}.", one.words(file));
    }
    Some(format!("{text}\n{}{sheet}", commented(&remarks)))
}
