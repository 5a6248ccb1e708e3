//! Load of a joint that was identified, beside the load that its machine's file has.
//!
//! An identification measures one number for the constant load, `off`, and gravity only if the
//! joint has gone through 60 deg (of a log: if the model has the term). In `off` is all that does
//! not change with the motion:
//!
//! ```text
//! off = D/2 + mean U_f sin(q - q_h) - T_f
//! ```
//!
//! with the difference D of the friction between both ways, the constant load T_f, and the mean
//! over the motion of the unbalance U_f that hangs at q_h. If the right side, with the numbers of
//! the file, is within the error bar of the left side, then the measurement agrees with the file,
//! and the file's load stays. The bar has what the gravity changes by over the motion, too. If
//! gravity was looked for and not found, though it would vary by more than the bar (root mean
//! square), then the unbalance is contradicted. Otherwise the rest is the constant load.
//!
//! Limits: an unbalance and a constant load that are both wrong, and cancel out, agree.

use super::contradiction::Contradiction;
use crate::data_sheet::DataSheet;
use crate::document::Document;

/// Angle from which the sequence looks for gravity, deg: `WIDE` of `src/identification/model.rs`.
pub(super) const WIDE_DEG: f64 = 60.0;

/// Points of a motion at which gravity is looked at.
const POINTS: usize = 65;

/// What an identification measures of the load: efforts that hold it, N m, each with its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLoad {
    /// Effort that does not change with the motion.
    pub offset: [f64; 2],
    /// Gravity as coefficients of sine and cosine of the position, if it was found.
    pub gravity: Option<[[f64; 2]; 2]>,
    /// Whether gravity was looked for.
    pub looked: bool,
    /// Ends of the motion, rad.
    pub range: [f64; 2],
    /// Least error bar that is believed.
    pub least: f64,
}

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
    measured: &MeasuredLoad,
    of: &Document,
    sheet: &DataSheet,
    difference: f64,
) -> FoundLoad {
    let mut load = FoundLoad::default();
    let [offset, off] = measured.offset;
    let bar = off.max(measured.least);
    let constant = of.get("load.constant_nm").map(|_| sheet.load.constant_nm);
    let (weight, hangs) = (sheet.load.unbalance_nm, sheet.hangs_at().unwrap_or(0.0));
    let rest = offset - 0.5 * difference;
    if let Some([[sine, off_sine], [cosine, off_cosine]]) = measured.gravity {
        let found = [sine.hypot(cosine), off_sine.max(off_cosine)];
        load.gravity(found, (-cosine).atan2(sine));
        if of.get("load.unbalance_nm").is_some() {
            let apart = [
                (sine - weight * hangs.cos(), off_sine),
                (cosine + weight * hangs.sin(), off_cosine),
            ];
            if apart.iter().any(|(apart, off)| apart.abs() > off.max(measured.least)) {
                let key = "load.unbalance_nm";
                load.contradicted.push(Contradiction::new(key, weight, found));
            }
        }
        load.constant(constant, rest, bar);
        return load;
    }
    if weight == 0.0 {
        load.constant(constant, rest, bar);
        return load;
    }
    // What of the file's gravity is in the offset, and by how much it changes over the motion.
    let [from, to] = measured.range;
    let at = |i: usize| from + (to - from) * i as f64 / (POINTS - 1) as f64;
    let gravity: Vec<f64> = (0..POINTS).map(|i| weight * (at(i) - hangs).sin()).collect();
    let held = gravity.iter().sum::<f64>() / POINTS as f64;
    let off_held = |of: &f64| (of - held).abs();
    let changes = gravity.iter().map(off_held).fold(0.0, f64::max);
    let varies = gravity.iter().map(|of| off_held(of).powi(2)).sum::<f64>() / POINTS as f64;
    let is_seen = measured.looked && varies.sqrt() > bar;
    let agrees = |held: f64, bar: f64| (rest - held + constant.unwrap_or(0.0)).abs() <= bar;
    if !is_seen && agrees(held, bar + changes) {
        return load;
    }
    if is_seen || agrees(0.0, bar) {
        load.removed.extend(["unbalance_nm", "hangs_at_deg", "hangs_at_rad"]);
        load.contradicted.push(Contradiction::new("load.unbalance_nm", weight, [0.0, bar]));
        load.constant(constant, rest, bar);
    } else {
        load.constant(constant, rest - held, bar + changes);
    }
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
