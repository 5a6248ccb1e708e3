//! The machine's file of a joint that was identified: `stiction device identify --into`.
//!
//! ```text
//! parameters of the device, with what `robust` is told of the joint (told.rs)
//! [joint]       what was found
//! [reference]   the motion of the device, and the others of the file that it was begun with
//! [spread]      the error bars, with what is doubted above them (spread.rs)
//! ```
//!
//! A device knows one motion. The file that a user has of the machine has more, and `tune`,
//! `benchmark` and `report` judge by all of them: gains that were never tried on a trajectory may
//! trip a monitor in one. So the rest of the file's steps and its trajectories come along, if its
//! first step is the device's.

use stiction::{Motion, Parameters};
use toml_edit::{DocumentMut, Item};

use super::identified::Identified;
use super::{machine_file, spread, told};
use crate::document::Document;
use crate::error::Error;

/// A step of the device is the file's if it is no farther off than this part of it: the device's
/// number is in single precision.
const SAME: f64 = 1e-6;

/// Writes the file of a joint that was found; `of` is the file that is known of the machine.
///
/// # Errors
/// Says why the result is none that a file should have, or that no file says what the device runs.
pub fn text(found: &Identified, of: &Document) -> Result<String, Error> {
    let joint = found.joint()?;
    let off = spread::spread(found, &joint);
    let (parameters, remark) = told::retold(found, &joint, &off);
    let whose = "this device, as it was identified";
    let body = machine_file::render(&parameters, &joint, whose)?;
    let body = with_motions(&body, &parameters, of).unwrap_or(body);
    let body = match remark {
        // Of a device there is one controller.
        Some(remark) => body.replacen("\n[controller.", &format!("\n{remark}[controller."), 1),
        None => body,
    };
    Ok(body + &spread::remarks(found) + &spread::table(&off))
}

/// Adds the motions of another file; none if they do not begin with the device's, or a device would
/// be told something else for them.
fn with_motions(body: &str, parameters: &Parameters, of: &Document) -> Option<String> {
    if !matches!(parameters.motion, Motion::Step(_)) {
        return None;
    }
    let mut whole: DocumentMut = body.parse().ok()?;
    let reference = toml::to_string(of.get("reference")?).ok()?;
    let reference: DocumentMut = reference.parse().ok()?;
    let steps = |item: &Item| -> Vec<f64> {
        let array = item.get("steps_deg").and_then(Item::as_array);
        let number =
            |value: &toml_edit::Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        array.into_iter().flatten().filter_map(number).collect()
    };
    let own = *steps(whole.get("reference")?).first()?;
    let others = steps(reference.as_item());
    let (first, rest) = others.split_first()?;
    if (own - first).abs() > SAME * first.abs() {
        return None;
    }
    let table = whole.get_mut("reference")?.as_table_mut()?;
    let array = table.get_mut("steps_deg")?.as_array_mut()?;
    rest.iter().for_each(|step| array.push(*step));
    if let Some(trajectories) = reference.get("trajectories") {
        table.insert("trajectories", trajectories.clone());
    }
    let text = whole.to_string();
    let again = machine_file::read("", &text).ok()?;
    (again == *parameters).then_some(text)
}
