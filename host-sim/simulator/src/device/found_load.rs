//! Load of an identified joint, merged with the load of its machine's file.
//!
//! An identification measures one number for the constant load, `off`, and gravity only if the
//! joint has moved through 60 deg (from a log: if the model has the term). `off` is the sum of all
//! efforts that do not change with the motion:
//!
//! ```text
//! off = D/2 + mean U_f sin(q - q_h) - T_f
//! ```
//!
//! with the difference D of the friction between both directions, the constant load T_f, and the
//! mean over the motion of the unbalance U_f that hangs at q_h. If the right side, with the numbers
//! of the file, is within the error bar of the left side, the measurement agrees with the file, and
//! the file's load stays. The bar includes the change of gravity over the motion. If the
//! identification looked for gravity and found none, though the file's gravity would vary by more
//! than the bar (root mean square), the unbalance is contradicted. Otherwise the rest is the
//! constant load.
//!
//! Limit: an unbalance and a constant load that are both wrong, but cancel out, are not detected.

use super::contradiction::Contradiction;
use files::data_sheet::DataSheet;
use files::document::Document;

/// Least range of motion in which the sequence identifies gravity, deg: `WIDE` of
/// `src/identification/model.rs`.
pub(super) const WIDE_DEG: f64 = 60.0;

/// Points of a motion at which gravity is evaluated.
const POINTS: usize = 65;

/// Measured load: the efforts that hold it, N m, each with its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredLoad {
    /// Effort that does not change with the motion.
    pub offset: [f64; 2],
    /// Gravity as coefficients of sine and cosine of the position, if it was found.
    pub gravity: Option<[[f64; 2]; 2]>,
    /// Whether the model of the identification has gravity.
    pub looked: bool,
    /// Ends of the motion, rad.
    pub range: [f64; 2],
    /// Narrowest credible error bar, N m.
    pub least: f64,
}

/// Load of an identified joint, N m and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FoundLoad {
    /// Keys of `[load]` with a new value.
    pub set: Vec<(&'static str, f64)>,
    /// Keys of `[load]` that are removed.
    pub removed: Vec<&'static str>,
    /// Measured keys with value and range.
    pub ranges: Vec<(&'static str, f64, [f64; 2])>,
    /// Keys of the file that the measurement contradicts.
    pub contradicted: Vec<Contradiction>,
}

/// Returns the load of an identified joint, merged with that of a data sheet; `difference` is the
/// difference of the friction between both directions, N m.
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
    // Mean of the file's gravity over the motion (a part of the offset), and its largest change.
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
    /// Sets the measured gravity: amplitude with its bar, N m, and hanging position, rad.
    fn gravity(&mut self, [weight, off]: [f64; 2], hangs: f64) {
        self.removed.extend(["hangs_at_deg"]);
        self.set.extend([("unbalance_nm", weight), ("hangs_at_rad", hangs)]);
        self.ranges.push(("load.unbalance_nm", weight, [(weight - off).max(0.0), weight + off]));
    }

    /// Sets the measured constant load from the effort that holds it, with its bar, N m. The load
    /// has the opposite sign. A load within its bar counts as none.
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
