//! What an identification has found beyond a joint in degrees and volts: a constant load, gravity,
//! a Stribeck curve.
//!
//! `[joint]` of a machine's file has none of them, and a data sheet has all. So where the machine
//! has a data sheet, and one of them was found, the joint is written as a data sheet:
//!
//! | in the effort | written |
//! |---|---|
//! | off | `load.constant_nm` = -G off: what the effort bears drives the other way |
//! | g_s sin q + g_c cos q | `load.unbalance_nm`, `load.hangs_at_rad` |
//! | S sgn v exp(-(v / v_s)^2) | `friction.stribeck_rad_per_s` = v_s, from stick to slip friction |
//!
//! with g_s sin q + g_c cos q = U sin(q - q_h): U is the unbalance, and q_h where it hangs.
//!
//! The rest of the joint is in the same tables: all of the inertia is the load's, and the viscous
//! friction is without the back-EMF's, which the motor's table gives. Elsewhere the file says in a
//! comment what it cannot say, and whoever writes it is told.

use stiction::Parameters;
use toml::{Table, Value};
use toml_edit::{DocumentMut, Item};

use super::identified::Identified;
use super::machine_file;
use super::spread::{Ranges, deviations};
use crate::document::Document;
use crate::draft::spread::rounded;
use crate::error;
use crate::machine::Joint;

/// A constant load below this part of the slip friction is none: no error bar of a friction level
/// is believed to be narrower.
const LEAST: f64 = 0.02;

/// What was found, each value with the width of its error bar, V.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beyond {
    constant: Option<[f64; 2]>,
    /// Sine and cosine of the position.
    gravity: Option<[[f64; 2]; 2]>,
    /// Level, and speed in deg/s.
    stribeck: Option<[f64; 2]>,
}

impl Beyond {
    /// What there is in an identification.
    pub fn of(found: &Identified) -> Self {
        let Some(estimate) = &found.summary.estimate else { return Self::default() };
        let deviations = deviations(found);
        let bar = |[value, sd]: [f32; 2]| [f64::from(value), deviations * f64::from(sd)];
        let [offset, off] = bar(estimate.offset);
        let is_load = offset.abs() > off.max(LEAST * f64::from(estimate.coulomb[0]));
        let gravity = estimate.gravity.map(bar);
        let speed = f64::from(estimate.stribeck_velocity);
        Self {
            constant: is_load.then_some([offset, off]),
            gravity: (gravity[0][1] > 0.0).then_some(gravity),
            stribeck: (speed > 0.0).then_some([f64::from(estimate.stribeck[0]), speed]),
        }
    }

    /// Whether there is nothing.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// "a load of 0.1 V, gravity of 0.2 V".
    fn words(&self) -> String {
        let shown = error::rounded;
        let load = self.constant.map(|[load, _]| format!("a load of {} V", shown(load.abs())));
        let gravity = self.gravity.map(|_| format!("gravity of {} V", shown(self.amplitude()[0])));
        let stribeck = self.stribeck.map(|[level, speed]| {
            format!("a Stribeck curve of {} V at {} deg/s", shown(level), shown(speed))
        });
        load.into_iter().chain(gravity).chain(stribeck).collect::<Vec<_>>().join(", ")
    }

    /// The sentence on what a file leaves out, and why.
    pub fn left_out(&self, why: &str) -> String {
        format!(
            "{} was found. This file cannot say it, so predictions (`tune`, `device selftest`, \
             `report`, the studio's) leave it out: {why}.",
            capital(&self.words())
        )
    }

    /// Amplitude of gravity with its error bar, V.
    fn amplitude(&self) -> [f64; 2] {
        self.gravity
            .map_or([0.0; 2], |[[sine, off], [cosine, other]]| [sine.hypot(cosine), off.max(other)])
    }

    /// Writes a file in degrees and volts anew, with the data sheet of the machine and the joint
    /// that was found.
    ///
    /// # Errors
    /// Says why there is no such file.
    pub fn in_si(
        &self,
        body: &str,
        joint: &Joint,
        off: &Ranges,
        of: &Document,
        parameters: &Parameters,
    ) -> Result<(String, Ranges), String> {
        const NO_SHEET: &str =
            "its joint is in degrees and volts; a data sheet in --machine has keys for it";
        let mapped = of.mapping().ok().flatten();
        let (_, mapping) = mapped.ok_or(NO_SHEET)?;
        let torque = |volts: f64| mapping.units.effort(volts);
        let per_radian = 1.0 / mapping.units.per_degree(1.0);
        let viscous = |volts: f64| (volts * per_radian - mapping.back_emf).max(0.0);
        let range = |key: &str| off.get(key).copied().ok_or("there is no [spread]");
        let [weak, strong] = range("joint.gain_deg_per_s2_per_v")?;
        let braked = range("joint.viscous_v_per_deg_per_s")?;
        if braked[1] * per_radian < mapping.back_emf {
            return Err(format!(
                "the back-EMF of {} alone brakes more than the joint was found to be braked",
                of.origin.name
            ));
        }
        let friction = &joint.friction;
        let mut load = vec![("inertia_kg_m2", per_radian / joint.gain_deg_per_s2_per_v)];
        let mut rubs = vec![
            ("stick_nm", torque(friction.stick_v)),
            ("slip_nm", torque(friction.slip_v)),
            ("viscous_nm_s_per_rad", viscous(joint.viscous_v_per_deg_per_s)),
        ];
        let mut ranges: Ranges = [
            ("load.inertia_kg_m2", [per_radian / strong, per_radian / weak]),
            ("friction.viscous_nm_s_per_rad", braked.map(viscous)),
            ("friction.slip_nm", range("joint.friction.slip_v")?.map(torque)),
            ("friction.stick_nm", range("joint.friction.stick_v")?.map(torque)),
        ]
        .map(|(key, range)| (key.to_owned(), range.map(rounded)))
        .into();
        let mut vary = |key: &str, [low, high]: [f64; 2]| {
            ranges.insert(key.to_owned(), [low, high].map(torque).map(rounded));
        };
        if let Some([value, off]) = self.constant {
            load.push(("constant_nm", torque(-value)));
            vary("load.constant_nm", [-value - off, -value + off]);
        }
        if let Some([[sine, _], [cosine, _]]) = self.gravity {
            let [value, off] = self.amplitude();
            load.push(("unbalance_nm", torque(value)));
            load.push(("hangs_at_rad", (-cosine).atan2(sine)));
            vary("load.unbalance_nm", [(value - off).max(0.0), value + off]);
        }
        if let Some([_, speed]) = self.stribeck {
            rubs.push(("stribeck_rad_per_s", speed.to_radians()));
        }
        let text = sheet(body, of, [load, rubs]).ok_or("its tables cannot be written")?;
        match machine_file::read("", &text) {
            Ok(again) if again == *parameters => Ok((text, ranges)),
            Ok(_) => Err(format!(
                "the data sheet of {} gives a device other parameters than this one has",
                of.origin.name
            )),
            Err(error) => Err(error.to_string().trim_start_matches([':', ' ']).to_owned()),
        }
    }
}

/// Puts the tables of a data sheet in the place of `[joint]`.
fn sheet(body: &str, of: &Document, [load, friction]: [Vec<(&str, f64)>; 2]) -> Option<String> {
    let table = |name: &str| of.get(name).and_then(Value::as_table).cloned();
    let only = |table: Table, keys: &[&str]| -> Table {
        table.into_iter().filter(|(key, _)| keys.contains(&key.as_str())).collect()
    };
    let numbers = |all: Vec<(&str, f64)>| -> Table {
        all.into_iter().map(|(key, value)| (key.to_owned(), rounded(value).into())).collect()
    };
    let mut motor = table("motor")?;
    // The rotor is in the inertia that was found. What a dead time takes from each effort is in the
    // friction that was found, so the drive of the file has none; `[device]` keeps the device's.
    for found in ["rotor_inertia_kg_m2", "dead_time_s"] {
        motor.remove(found);
    }
    // What is elastic or loose in it was not found.
    let gear = table("gear").map(|gear| only(gear, &["ratio", "efficiency"]));
    // A count is written as the device has it: by the lines, its step would be another number.
    let encoder = table("encoder").map(|all| only(all, &["at", "noise_counts"]));
    let sheet: Table = [
        ("motor", Some(motor)),
        ("gear", gear),
        ("load", Some(numbers(load))),
        ("friction", Some(numbers(friction))),
        ("supply", table("supply")),
    ]
    .into_iter()
    .filter_map(|(name, table)| Some((name.to_owned(), Value::Table(table?))))
    .collect();
    let mut whole: DocumentMut = body.parse().ok()?;
    whole.remove("joint");
    let counts = whole.get_mut("encoder").and_then(Item::as_table_mut)?;
    let more: DocumentMut = toml::to_string(&encoder.unwrap_or_default()).ok()?.parse().ok()?;
    for (key, item) in more.iter() {
        counts.insert(key, item.clone());
    }
    let text = whole.to_string().replacen("[joint] is that", "[load] and [friction] are those", 1);
    let sheet = toml::to_string(&sheet).ok()?;
    Some(format!(
        "{text}\n# The joint as a data sheet: the motor, gear and supply of {}, and what was\n\
         # found. All of the inertia is the load's. Angles count from where the device\n\
         # was armed.\n{sheet}",
        of.origin.name
    ))
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
