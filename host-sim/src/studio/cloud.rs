//! Predictions of a move on joints around the one in use (the cloud), and the worst of them.
//!
//! The joints are drawn as in [`studies::tuning`], with a sample of delay and without. Guarantee:
//! the same request gives the same joints. Limits: the sliders scale slip and stick level
//! separately; if a drawn slip level would exceed the stick level, the stick level replaces it. The
//! reported spread of a data sheet is that of the file, without the sliders.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::knobs::{DELAY, GAIN};
use super::machine_in_use::MachineInUse;
use super::prediction::{PredictedMove, set};
use super::request::PredictionRequest;
use files::error::Error;
use simulator::experiment::{Document, for_a_device};
use studies::ensemble::{KeySpread, drawn_keys, written_spreads};
use studies::tuning::{assumed, spreads};

/// Largest number of points of a curve; there are many curves.
const POINTS: usize = 240;

/// Seed of the joints.
const SEED: u64 = 1;

/// Keys of the joint's slip and stick friction, V.
const SLIP: &str = "joint.friction.slip_v";
const STICK: &str = "joint.friction.stick_v";
const OF_A_JOINT: [&str; 4] = [GAIN, "joint.viscous_v_per_deg_per_s", SLIP, STICK];

/// Prefixes of a data sheet's keys that the joint's keys replace.
const IN_A_JOINT: [&str; 6] = [
    "load.inertia_",
    "motor.rotor_inertia_",
    "friction.viscous_",
    "friction.slip_nm=",
    "friction.stick_nm=",
    "joint.",
];

/// Returns the spread of a joint in degrees and volts, `KEY=LOW..HIGH` each, and whether it is from
/// the file. If the file has a `[spread]`, its ranges are scaled with the sliders; otherwise
/// [`assumed`] applies.
///
/// # Errors
/// Returns an error that names what is wrong with the file.
fn spread(machine: &Document, turned: &Document) -> Result<(Vec<String>, bool), Error> {
    let written = machine.machine()?.spread;
    let written = written.into_iter().filter_map(|(key, [low, high])| {
        let (before, after) = (machine.number(&key)?, turned.number(&key)?);
        let ratio = if before == 0.0 { 1.0 } else { after / before };
        Some(format!("{key}={:?}..{:?}", low * ratio, high * ratio))
    });
    let written: Vec<String> = written.collect();
    Ok(if written.is_empty() { (assumed(turned), false) } else { (written, true) })
}

/// A joint around the requested one.
struct DrawnJoint {
    machine: MachineInUse,
    /// Keys to be set in `machine` when its run is planned.
    set: Vec<String>,
    /// Keys that differ from the requested joint, for the page.
    changed_keys: Vec<String>,
}

/// Joints around the requested one.
struct JointDrawing<'a> {
    /// The machine in use, without and with the sliders.
    machine: &'a MachineInUse,
    turned: MachineInUse,
    written: Vec<String>,
    spreads: Vec<KeySpread>,
    is_written: bool,
}

impl<'a> JointDrawing<'a> {
    /// Reads the spread. If the file is a data sheet, the keys of the sheet are drawn, all at once,
    /// since the mapping to the joint's keys needs all of them. In another file, keys of the joint
    /// are drawn, with the sliders applied.
    fn new(
        machine: &'a MachineInUse,
        wish: &'a PredictionRequest,
        law: &str,
    ) -> Result<Self, Error> {
        let mut turned = machine.clone();
        turned.document.set(&set(machine, wish, None))?;
        turned.document.set(&set(machine, wish, Some(law)))?;
        let (written, is_written) = match machine.sheet() {
            Some(sheet) => (spreads(sheet)?, !written_spreads(sheet)?.is_empty()),
            None => spread(&machine.document, &turned.document)?,
        };
        let spreads = written.iter().map(|text| KeySpread::read(text)).collect::<Result<_, _>>()?;
        Ok(Self { machine, turned, written, spreads, is_written })
    }

    fn joint(&self, number_of_joint: u64) -> Result<DrawnJoint, Error> {
        let keys = drawn_keys(&self.spreads, SEED, number_of_joint);
        if self.machine.sheet().is_none() {
            return Ok(DrawnJoint {
                machine: self.turned.clone(),
                set: keys.clone(),
                changed_keys: keys,
            });
        }
        let mut machine = self.machine.drawn(&keys)?;
        // A slider scales a drawn value as it scales the value in use.
        let turned = |key: &str| {
            let own = machine.document.number(key)?;
            let [is, was] =
                [&self.turned, self.machine].map(|of| of.document.number(key).unwrap_or(0.0));
            Some(match (own == was, was == 0.0) {
                (true, _) => is,
                (false, true) => own,
                (false, false) => own * (is / was),
            })
        };
        let mut values: BTreeMap<&str, f64> =
            OF_A_JOINT.into_iter().filter_map(|key| Some((key, turned(key)?))).collect();
        // The sliders are separate, but slip friction must not exceed stick friction.
        if let (Some(slip), Some(stick)) = (values.get(SLIP), values.get(STICK)) {
            let slip = slip.min(*stick);
            values.insert(SLIP, slip);
        }
        let written: Vec<String> =
            values.iter().map(|(key, value)| format!("{key}={value:?}")).collect();
        machine.document.set(&written)?;
        let differs = |key: &str| self.turned.document.number(key) != values.get(key).copied();
        let mut changed_keys: Vec<String> = OF_A_JOINT
            .into_iter()
            .filter(|key| differs(key))
            .filter_map(|key| Some(format!("{key}={:?}", values.get(key)?)))
            .collect();
        let is_covered = |key: &&String| IN_A_JOINT.iter().any(|begin| key.starts_with(begin));
        changed_keys.extend(keys.iter().filter(|key| !is_covered(key)).cloned());
        Ok(DrawnJoint { machine, set: vec![], changed_keys })
    }
}

/// Predicts the move on joints around the requested one. Returns `None` as soon as `is_old` returns
/// true.
///
/// # Errors
/// Returns an error that names the invalid value.
pub fn cloud(
    machine: &MachineInUse,
    wish: &PredictionRequest,
    is_old: impl Fn() -> bool,
) -> Result<Option<Value>, Error> {
    let Some(law) = wish.laws.first() else { return Ok(None) };
    let drawing = JointDrawing::new(machine, wish, law)?;
    let parameters = for_a_device(&drawing.turned.plan(law, &[])?)?;
    let mut all: Vec<(PredictedMove, Vec<String>)> = Vec::new();
    let mut refused = Vec::new();
    for number in 0..u64::from(wish.cloud) {
        if is_old() {
            return Ok(None);
        }
        let DrawnJoint { machine, mut set, mut changed_keys } = drawing.joint(number)?;
        let delay = format!("{}={}", DELAY, number % 2);
        set.push(delay.clone());
        changed_keys.push(delay);
        let joint = machine.plan_from(wish.from_deg, law, &set)?;
        match PredictedMove::of(&parameters, &joint, &wish.way) {
            Ok(one) => all.push((one, changed_keys)),
            // A load may move one of these joints. If all are refused, the reason is returned.
            Err(Error::Refused(why)) => refused.push(why),
            Err(other) => return Err(other),
        }
    }
    if all.is_empty()
        && let Some(why) = refused.pop()
    {
        return Err(Error::Refused(why));
    }
    let worst = all.iter().enumerate().max_by(|(_, (a, _)), (_, (b, _))| {
        let ((late, rest), (other_late, other_rest)) = (a.badness(), b.badness());
        late.total_cmp(&other_late).then(rest.total_cmp(&other_rest))
    });
    let worst = worst.map(|(place, (_, keys))| json!({ "place": place, "joint": keys }));
    let settled = all.iter().filter(|(one, _)| one.settled_s.is_some()).count();
    let met = |side: usize| all.iter().filter(|(one, _)| one.success[side]).count();
    let curves = all.iter().map(|(one, _)| {
        let mut curve = one.json(POINTS, wish.from_deg);
        // The page draws neither set point nor effort of these curves.
        let of_load = ["position_at_load_deg", "error_at_load_counts", "motor_less_load_deg"];
        for left_out in ["reference_deg", "effort_v"].into_iter().chain(of_load) {
            curve.as_object_mut().map(|curve| curve.remove(left_out));
        }
        curve
    });
    Ok(Some(json!({
        "law": law,
        "success_at_encoder": met(0),
        "success_at_load": met(1),
        "spreads": drawing.written,
        "is_written": drawing.is_written,
        "settled": settled,
        "refused_joints": refused,
        "worst": worst,
        "curves": curves.collect::<Vec<_>>(),
    })))
}
