//! Load of a joint that was identified, beside the load that its machine's file has.
//!
//! An identification measures one number for the constant load, `off`, and gravity only if the
//! joint has gone through 60 deg. In `off` is all that does not change with the motion:
//!
//! ```text
//! G off = D/2 + U_f m - T_f      m = -sin(q_h) sin(R/2) / (R/2)
//! ```
//!
//! with the difference D of the friction between both ways, the constant load T_f, the unbalance
//! U_f that hangs at q_h, the angle R that the joint has gone through, and the effort gain G. If
//! the right side, with the numbers of the file, is within the error bar of the left side, then the
//! measurement agrees with the file, and the file's load stays. The bar has the part of the gravity
//! that changes over R, too. Otherwise the rest is the constant load, and the file is contradicted.
//!
//! Limits: an unbalance and a constant load that are both wrong, and cancel out over R, agree.

use super::beyond::{Beyond, LEAST};
use super::contradiction::Contradiction;
use super::identified::Identified;
use super::spread::deviations;
use crate::data_sheet::DataSheet;
use crate::document::Document;
use crate::joint::CoreUnits;

/// Angle from which the sequence looks for gravity, deg: `WIDE` of `src/identification/model.rs`.
const WIDE_DEG: f64 = 60.0;

/// Load of a joint that was found, N m and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FoundLoad {
    /// Keys of `[load]` that have another value than in the file.
    pub set: Vec<(&'static str, f64)>,
    /// Keys of `[load]` that the file loses.
    pub removed: Vec<&'static str>,
    /// Ranges of what was measured, by their key.
    pub ranges: Vec<(&'static str, f64, [f64; 2])>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

/// Returns the load of a joint that was found, beside that of a data sheet; `difference` is the
/// friction's between both ways, N m.
pub(super) fn load(
    found: &Identified,
    beyond: &Beyond,
    of: &Document,
    (sheet, units, difference): (&DataSheet, &CoreUnits, f64),
) -> FoundLoad {
    let mut load = FoundLoad::default();
    let Some(estimate) = &found.summary.estimate else { return load };
    let torque = |value: f64| units.effort(value);
    let [offset, off] = [
        torque(f64::from(estimate.offset[0])),
        torque(deviations(found) * f64::from(estimate.offset[1])),
    ];
    let least = LEAST * torque(f64::from(estimate.coulomb[0]));
    let constant = of.get("load.constant_nm").map(|_| sheet.load.constant_nm);
    let (weight, hangs) = (sheet.load.unbalance_nm, sheet.hangs_at().unwrap_or(0.0));
    let half = 0.5 * f64::from(found.summary.range).to_radians();
    let rest = offset - 0.5 * difference;
    if let Some([[sine, off_sine], [cosine, off_cosine]]) = beyond.gravity {
        let measured = beyond.amplitude().map(torque);
        load.gravity(measured, (-cosine).atan2(sine));
        if of.get("load.unbalance_nm").is_some() {
            let apart = [
                (torque(sine) - weight * hangs.cos(), torque(off_sine)),
                (torque(cosine) + weight * hangs.sin(), torque(off_cosine)),
            ];
            if apart.iter().any(|(apart, off)| apart.abs() > off.max(least)) {
                let key = "load.unbalance_nm";
                load.contradicted.push(Contradiction::new(key, weight, measured));
            }
        }
        load.constant(constant, rest, off.max(least));
        return load;
    }
    // What of the file's gravity is in `off`, and by how much it changes over the way.
    let mean = if half > 0.0 { half.sin() / half } else { 1.0 };
    let held = -weight * hangs.sin() * mean;
    let changes = 0.5
        * weight
        * ((hangs.cos() * half.sin()).abs() + (hangs.sin() * (1.0 - half.cos())).abs());
    let bar = off.max(least);
    let pulls = constant.unwrap_or(0.0);
    let agrees = |held: f64, bar: f64| (rest - held + pulls).abs() <= bar;
    if weight > 0.0 {
        let with = agrees(held, bar + changes);
        let is_seen = found.summary.range >= WIDE_DEG as f32 && {
            // Standard deviation of the sine's coefficient, if that of a constant is known.
            let spread = (0.5 * (1.0 - (2.0 * half).sin() / (2.0 * half))).max(0.0).sqrt();
            (weight * hangs.cos()).abs() > (off / spread).max(5.0 * least)
        };
        if with && !is_seen {
            return load;
        }
        if is_seen || agrees(0.0, bar) {
            load.removed.extend(["unbalance_nm", "hangs_at_deg", "hangs_at_rad"]);
            let key = "load.unbalance_nm";
            load.contradicted.push(Contradiction::new(key, weight, [0.0, bar]));
            load.constant(constant, rest, bar);
            return load;
        }
        load.constant(constant, rest - held, bar + changes);
        return load;
    }
    load.constant(constant, rest, bar);
    load
}

impl FoundLoad {
    /// Takes gravity as measured: amplitude with its bar, N m, and where it hangs, rad.
    fn gravity(&mut self, [weight, off]: [f64; 2], hangs: f64) {
        self.removed.extend(["hangs_at_deg"]);
        self.set.extend([("unbalance_nm", weight), ("hangs_at_rad", hangs)]);
        self.ranges.push(("load.unbalance_nm", weight, [(weight - off).max(0.0), weight + off]));
    }

    /// Takes the constant load as measured: the effort that holds it, with its bar, N m. It drives
    /// the other way. What is within its bar is none.
    fn constant(&mut self, in_file: Option<f64>, held: f64, off: f64) {
        let pulls = -held;
        if pulls.abs() > off {
            self.set.push(("constant_nm", pulls));
            self.ranges.push(("load.constant_nm", pulls, [pulls - off, pulls + off]));
        } else if in_file.is_some_and(|constant| (constant - pulls).abs() > off) {
            self.removed.push("constant_nm");
        }
        if let Some(constant) = in_file.filter(|constant| (constant - pulls).abs() > off) {
            let key = "load.constant_nm";
            self.contradicted.push(Contradiction::new(key, constant, [pulls, off]));
        }
    }
}
