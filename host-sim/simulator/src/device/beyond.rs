//! Effects that an identification found and `[joint]` of a machine's file has no keys for: a
//! constant load, gravity, a Stribeck curve.
//!
//! A data sheet has keys for all of them. If the machine has a data sheet, and one of them was
//! found, the joint is written as a data sheet:
//!
//! | in the effort | written |
//! |---|---|
//! | off | `load.constant_nm` = -G off: the effort holds a load of opposite sign |
//! | g_s sin q + g_c cos q | `load.unbalance_nm`, `load.hangs_at_rad` |
//! | S sgn v exp(-(v / v_s)^2) | `friction.stribeck_rad_per_s` = v_s, from stick to slip friction |
//!
//! with g_s sin q + g_c cos q = U sin(q - q_h): U is the unbalance, and q_h the position in which
//! it hangs. `merged_sheet.rs` writes that data sheet. Without one, the file lists in a comment
//! what it leaves out, and the command prints the list.

use super::identified::IdentifiedJoint;
use super::spread::deviations;
use files::error;

/// Share of the slip friction below which a constant load counts as none: the narrowest credible
/// error bar of a friction level.
pub(super) const LEAST: f64 = 0.02;

/// Identified effects beyond `[joint]`, each value with the width of its error bar, V.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnmodelledEffects {
    pub(super) constant: Option<[f64; 2]>,
    /// Coefficients of sine and cosine of the position.
    pub(super) gravity: Option<[[f64; 2]; 2]>,
    /// Level, and speed in deg/s.
    pub(super) stribeck: Option<[f64; 2]>,
}

impl UnmodelledEffects {
    /// Returns the effects in an identification.
    pub fn of(found: &IdentifiedJoint) -> Self {
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

    /// Returns whether no such effect was found.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Returns a list such as "a load of 0.1 V, gravity of 0.2 V".
    fn words(&self) -> String {
        let shown = error::rounded;
        let load = self.constant.map(|[load, _]| format!("a load of {} V", shown(load.abs())));
        let gravity = self.gravity.map(|_| format!("gravity of {} V", shown(self.amplitude()[0])));
        let stribeck = self.stribeck.map(|[level, speed]| {
            format!("a Stribeck curve of {} V at {} deg/s", shown(level), shown(speed))
        });
        load.into_iter().chain(gravity).chain(stribeck).collect::<Vec<_>>().join(", ")
    }

    /// Returns the sentence about effects that a file leaves out, and why.
    pub fn left_out(&self, why: &str) -> String {
        format!(
            "{} was found. This file has no key for it, so predictions (`tune`, `device selftest`, \
             `report`, the studio's) leave it out: {why}.",
            capital(&self.words())
        )
    }

    /// Returns the amplitude of gravity with its error bar, V.
    pub(super) fn amplitude(&self) -> [f64; 2] {
        self.gravity
            .map_or([0.0; 2], |[[sine, off], [cosine, other]]| [sine.hypot(cosine), off.max(other)])
    }
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
