//! Check of the offset of an absolute encoder on the load, beside a jog: the angle that the encoder
//! shows, against the position that a person states.
//!
//! ```text
//! a = z + d p    mod a turn      reading a at the position p, with the offset z and direction d
//! z' = a - d' t  mod a turn      the offset for which t is the position; d' is the true direction
//! ```
//!
//! The jog finds d', and this check z'. Does badly: the offset is only as good as the statement. A
//! wrong number of counts a turn is none of it: that of the chip is fixed, and the magnet turns
//! with the joint.

use serde_json::{Map, Value, json};
use stiction::Parameters;
use stiction::control::encoder::Direction;
use stiction::control::motor_encoder::LoadEncoderKind;
use stiction::load_encoder::as5047p;
use stiction::motion::jog::{JogFindings, Verdict};

/// Difference beyond which the offset is wrong, deg: a person sets a joint by eye to less.
pub const TOLERANCE_DEG: f64 = 1.0;

/// Counts of a turn.
const TURN: i32 = 1 << as5047p::BITS;

/// Result of the check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offset {
    /// The person stated no position.
    NotStated,
    /// The joint has no absolute encoder, and no offset.
    None,
    /// The jog did not find the direction of the encoder.
    Unknown,
    /// The offset is known.
    Checked(CheckedOffset),
}

/// Offset that was compared with a stated position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedOffset {
    /// Stated position of the joint, deg.
    pub at_deg: f64,
    /// Position by the offset of the file less the stated one, deg, from minus half a turn on.
    pub error_deg: f64,
    /// Offset for which the stated position is right, counts: `load_encoder.zero_counts`.
    pub zero_counts: u32,
}

impl CheckedOffset {
    /// Returns whether the offset of the file is wrong.
    pub fn is_wrong(&self) -> bool {
        self.error_deg.abs() > TOLERANCE_DEG
    }
}

/// Returns whether the parameters have an absolute encoder on the load.
pub fn has_offset(parameters: &Parameters) -> bool {
    let motor = &parameters.controller.motor;
    motor.count().is_some() && motor.load_kind == LoadEncoderKind::As5047p
}

impl Offset {
    /// Compares the offset of the parameters with the position that a person has stated (deg),
    /// where the encoder has shown `angle` (counts of a turn) before the jog.
    pub fn check(
        at_deg: Option<f64>,
        angle: u16,
        found: &JogFindings,
        parameters: &Parameters,
    ) -> Self {
        if !has_offset(parameters) {
            return Self::None;
        }
        let Some(at_deg) = at_deg else { return Self::NotStated };
        let encoder = &parameters.controller.encoder;
        let configured = if encoder.direction == Direction::Forward { 1 } else { -1 };
        let (Verdict::Agrees | Verdict::Reversed) = found.verdict() else { return Self::Unknown };
        let is_reversed = found.verdict() == Verdict::Reversed;
        let direction = if is_reversed { -configured } else { configured };
        let resolution = f64::from(encoder.resolution);
        let stated = (at_deg / resolution).round().rem_euclid(f64::from(TURN)) as i32;
        let zero_counts = (i32::from(angle) - direction * stated).rem_euclid(TURN);
        // z' - z = d' (p - t) for the position p by the offset of the file.
        let ahead = direction * (zero_counts - parameters.controller.motor.load_zero as i32);
        let error = (ahead + TURN / 2).rem_euclid(TURN) - TURN / 2;
        let error_deg = f64::from(error) * resolution;
        Self::Checked(CheckedOffset { at_deg, error_deg, zero_counts: zero_counts as u32 })
    }

    /// Returns the result if the offset is wrong.
    pub fn wrong(&self) -> Option<&CheckedOffset> {
        match self {
            Self::Checked(checked) if checked.is_wrong() => Some(checked),
            _ => None,
        }
    }

    /// Returns the result as lines of text; empty without an absolute encoder.
    pub fn words(&self) -> String {
        let lines = match self {
            Self::None => return String::new(),
            Self::NotStated => vec![
                "offset     not checked: `--at DEG` states where the joint is when the jog begins"
                    .into(),
            ],
            Self::Unknown => vec![
                "offset     not checked: the jog has not found the direction of the load's encoder"
                    .into(),
            ],
            Self::Checked(checked) => {
                let CheckedOffset { at_deg, error_deg, zero_counts } = checked;
                let is = if checked.is_wrong() { "WRONG" } else { "right" };
                let mut lines = vec![format!(
                    "offset     {is}: {error_deg:+.2} deg off the stated {at_deg} deg"
                )];
                if checked.is_wrong() {
                    lines.extend([
                        "           do not arm it like this. In the machine's file, set".into(),
                        format!("               load_encoder.zero_counts = {zero_counts}"),
                        "           send it with `params push FILE.toml`, and jog again.".into(),
                    ]);
                }
                lines
            }
        };
        lines.join("\n") + "\n"
    }

    /// Adds the result to the JSON object of a jog, and the offset to the keys that have to be set.
    pub fn add_to(&self, object: &mut Value) {
        let Value::Object(fields) = object else { return };
        let offset = match self {
            Self::Checked(checked) => json!({
                "at_deg": checked.at_deg,
                "error_deg": checked.error_deg,
                "zero_counts": checked.zero_counts,
                "wrong": checked.is_wrong(),
            }),
            _ => Value::Null,
        };
        fields.insert("offset".into(), offset);
        if let Some(wrong) = self.wrong() {
            let set = fields.entry("set").or_insert(Value::Null);
            if set.is_null() {
                *set = Value::Object(Map::new());
            }
            if let Value::Object(keys) = set {
                keys.insert("load_encoder.zero_counts".into(), wrong.zero_counts.into());
            }
        }
    }
}
