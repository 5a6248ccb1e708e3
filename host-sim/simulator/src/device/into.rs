//! The machine's file of an identified joint: `stiction device identify --into`.
//!
//! ```text
//! parameters of the device, with the identified joint in `robust` (robust_joint.rs)
//! [joint]       identified joint; a data sheet instead, if the machine has one (merged.rs)
//! [goal]        tolerance and times of the machine's file
//! [reference]   the motion of the device, then the other motions of the machine's file
//! [identified]  verdict and doubts (spread.rs)
//! [spread]      error bars, wider if there are doubts (spread.rs)
//! ```
//!
//! A device stores one motion. A machine's file has several, and `tune`, `benchmark` and `report`
//! judge by all of them: gains that were never tried on a trajectory can trip a monitor on it. So
//! the other steps and trajectories are copied, if the first step of the file is the device's.
//! Otherwise a comment in the new file states that they are missing, and why.

use stiction::{Motion, Parameters};
use toml_edit::{DocumentMut, Item};

use super::beyond::UnmodelledEffects;
use super::contradiction::Contradiction;
use super::identified::IdentifiedJoint;
use super::merged::{MergedFile, lost, merged};
use super::merged_sheet::kept_words;
use super::{machine_file, robust_joint, spread};
use crate::draft;
use files::document::Document;
use files::error::Error;
use files::machine::JointTable;

/// Relative difference up to which a step of the device equals that of the file: the device stores
/// single precision.
const SAME: f64 = 1e-6;

/// The machine's file of an identified joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IdentifiedFile {
    /// Text of the file.
    pub text: String,
    /// Sentence about results that the file cannot hold, with the reason.
    pub left_out: Option<String>,
    /// Keys that were not measured and are copied from the earlier machine's file.
    pub kept: Vec<String>,
    /// Keys of the earlier machine's file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
    /// Sentences about the copied and the contradicted keys.
    pub words: Vec<String>,
}

/// Returns the text of the machine's file of an identified joint; `of` is the earlier file of the
/// machine.
///
/// # Errors
/// As [`written`].
pub fn text(found: &IdentifiedJoint, of: &Document) -> Result<String, Error> {
    written(found, of).map(|written| written.text)
}

/// Returns the machine's file of an identified joint, with the keys of the earlier file that it
/// copies, contradicts and leaves out.
///
/// # Errors
/// Returns why the identification has no usable result, or that no machine's file can hold the
/// parameters of the device.
pub fn written(found: &IdentifiedJoint, of: &Document) -> Result<IdentifiedFile, Error> {
    let mut joint = found.joint()?;
    let off = spread::spread(found, &joint);
    spread::inside(&mut joint, &off);
    let (parameters, remark) = robust_joint::with_identified_joint(found, &joint, &off);
    let whose = "this device, as it was identified";
    let body = machine_file::render(&parameters, &joint, whose)?;
    let (body, no_motions) = match with_motions(&body, &parameters, of) {
        Ok(body) => (body, String::new()),
        Err(why) => (body, why.map_or(String::new(), |why| without_motions(of, why))),
    };
    let body = match remark {
        // A device has one controller.
        Some(remark) => body.replacen("\n[controller.", &format!("\n{remark}[controller."), 1),
        None => body,
    };
    let (merged, left_out) = match merged(found, (&joint, &off), of, (&body, &parameters)) {
        Ok(merged) => (merged, None),
        Err(why) => {
            let contradicted = in_volts(&joint, &off, of);
            let left_out = left_out(&UnmodelledEffects::of(found), of, &why);
            (MergedFile { text: body, ranges: off, kept: vec![], contradicted }, left_out)
        }
    };
    let MergedFile { text: body, ranges, kept, contradicted } = merged;
    let not_said =
        left_out.as_ref().map_or(String::new(), |why| format!("\n{}", spread::commented(why)));
    let ranges = draft::spread::table(ranges.iter().map(|(key, range)| (key.as_str(), *range)));
    let text = body + &no_motions + &not_said + &goal(of) + &spread::remarks(found) + &ranges;
    let file = &of.origin.name;
    let mut words: Vec<String> =
        kept_words(&kept, file, &Document::parse("", &text)?).into_iter().collect();
    words.extend(contradicted.iter().map(|one| format!("contradicted: {}", one.words(file))));
    Ok(IdentifiedFile { text, left_out, kept, contradicted, words })
}

/// Returns the sentence about the parts of the joint that a file in degrees and volts leaves out:
/// identified ones, and those of the data sheet.
fn left_out(beyond: &UnmodelledEffects, of: &Document, why: &str) -> Option<String> {
    let found = (!beyond.is_none()).then(|| beyond.left_out(why));
    let Some(lost) = lost(of) else { return found };
    let file = &of.origin.name;
    let lost = format!("Left out of {file}: {lost}");
    Some(found.map_or_else(|| format!("{lost}, since {why}."), |found| format!("{found} {lost}.")))
}

/// Returns the contradicted keys of a file in degrees and volts. A built-in file has none: its
/// joint is not the user's.
fn in_volts(joint: &JointTable, off: &spread::Ranges, of: &Document) -> Vec<Contradiction> {
    if files::document::find(&of.origin.name).is_ok() {
        return vec![];
    }
    let friction = &joint.friction;
    let of_joint = [
        ("joint.gain_deg_per_s2_per_v", joint.gain_deg_per_s2_per_v),
        ("joint.viscous_v_per_deg_per_s", joint.viscous_v_per_deg_per_s),
        ("joint.friction.slip_v", friction.slip_v),
        ("joint.friction.stick_v", friction.stick_v),
    ];
    let compared = of_joint.into_iter().filter_map(|(key, value)| {
        Contradiction::between(key, (of.number(key)?, None), (value, *off.get(key)?))
    });
    compared.collect()
}

/// Returns the table `[goal]` of a machine's file. The device does not store it.
fn goal(of: &Document) -> String {
    let goal = of.get("goal").and_then(|goal| toml::to_string(goal).ok());
    goal.map_or(String::new(), |goal| format!("\n[goal]\n{goal}"))
}

/// Returns a comment that the motions of the earlier file are missing, and why.
fn without_motions(of: &Document, why: &str) -> String {
    let sentence = format!(
        "The steps and trajectories of {} were not copied, since {why}. If this is the same \
         machine, copy its [reference]: `tune`, `benchmark` and `report` judge by all motions of a \
         file.",
        of.origin.name
    );
    format!("\n{}", spread::commented(&sentence))
}

/// Returns the file with the motions of the earlier file added.
///
/// # Errors
/// Returns why the motions cannot be copied: their first one is not the device's, or the file would
/// change the parameters of the device. The reason is `None` if the earlier file has no motions.
fn with_motions(
    body: &str,
    parameters: &Parameters,
    of: &Document,
) -> Result<String, Option<&'static str>> {
    let reference = of.get("reference").and_then(|table| toml::to_string(table).ok());
    let reference: DocumentMut = reference.and_then(|text| text.parse().ok()).ok_or(None)?;
    let steps = |item: &Item| -> Vec<f64> {
        let array = item.get("steps_deg").and_then(Item::as_array);
        let number =
            |value: &toml_edit::Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        array.into_iter().flatten().filter_map(number).collect()
    };
    let others = steps(reference.as_item());
    let trajectories = reference
        .get("trajectories")
        .filter(|all| !all.as_array().is_some_and(toml_edit::Array::is_empty));
    let Some((first, rest)) = others.split_first() else {
        return Err(trajectories.map(|_| "its first motion is no step"));
    };
    let is_alone = rest.is_empty() && trajectories.is_none();
    if !matches!(parameters.motion, Motion::Step(_)) {
        return Err(Some("the motion of the device is no step"));
    }
    let mut whole: DocumentMut = body.parse().map_err(|_| None)?;
    let own = whole.get("reference").and_then(|table| steps(table).first().copied());
    if own.is_none_or(|own| (own - first).abs() > SAME * first.abs()) {
        return Err(Some("its first step is not that of the device"));
    }
    if is_alone {
        return Ok(body.to_owned());
    }
    let table = whole.get_mut("reference").and_then(Item::as_table_mut).ok_or(None)?;
    let array = table.get_mut("steps_deg").and_then(Item::as_array_mut).ok_or(None)?;
    rest.iter().for_each(|step| array.push(*step));
    if let Some(trajectories) = trajectories {
        let mut trajectories = trajectories.clone();
        // Their place is behind this table, and not that in the other file.
        let all = trajectories.as_array_of_tables_mut().into_iter().flat_map(|all| all.iter_mut());
        all.for_each(|one| one.set_position(None));
        table.insert("trajectories", trajectories);
    }
    let text = whole.to_string();
    let is_same = machine_file::read("", &text).is_ok_and(|again| again == *parameters);
    if is_same { Ok(text) } else { Err(Some("they would change the parameters of the device")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draft::{Typical, text};
    use crate::experiment::Experiment;

    #[test]
    fn motions_come_along_if_the_first_is_the_device_s_and_else_the_file_says_why_not() {
        let typical = Typical::find("thesis").unwrap();
        let sheet = text("arm.toml", &typical.answers().unwrap(), Some(&typical)).unwrap();
        let sheet = Document::parse("arm.toml", &sheet).unwrap();
        let first =
            |document: &Document| Experiment::plan(document, &[], &[]).unwrap().runs.remove(0);
        let parameters = super::super::parameters(&first(&sheet)).unwrap();
        let joint = sheet.machine().unwrap().joint;
        let body = machine_file::render(&parameters, &joint, "a test").unwrap();
        let whole = with_motions(&body, &parameters, &sheet).unwrap();
        let place = |part: &str| whole.find(part).unwrap();
        assert!(
            place("[reference]") < place("[[reference.traj") && place("[[") < place("[device]")
        );
        let of = |text: &str| Document::parse("", text).unwrap().machine().unwrap().reference;
        let (steps, trajectories) = (of(&whole).steps_deg, of(&whole).trajectories.len());
        // The device has counts of its step.
        assert!((steps[0] - 1.0).abs() < 1e-6, "{steps:?}");
        assert_eq!((&steps[1..], trajectories), (&[5.0][..], 1));
        let mut other = sheet.clone();
        other.set(&["reference.steps_deg=[2.0, 5.0]".to_owned()]).unwrap();
        let why = with_motions(&body, &parameters, &other).unwrap_err().unwrap();
        let said = without_motions(&other, why);
        assert!(said.contains("arm.toml") && said.contains("first step"), "{said}");
        assert!(said.lines().all(|line| line.is_empty() || line.starts_with('#')), "{said}");
        // A file of the one step has nothing that could be left out.
        other
            .set(&["reference.steps_deg=[1.0]".into(), "reference.trajectories=[]".into()])
            .unwrap();
        assert_eq!(with_motions(&body, &parameters, &other).as_deref(), Ok(body.as_str()));
        other.set(&["reference.steps_deg=[]".to_owned()]).unwrap();
        assert_eq!(with_motions(&body, &parameters, &other), Err(None));
    }
}
