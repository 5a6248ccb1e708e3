//! Rules for the gains of a first controller, from a joint's data sheet alone.
//!
//! With the joint in the core's units, `J_v q'' = u - b q' - F`, the sample time h and the angle q
//! of one count:
//!
//! ```text
//! w_n   = min(2 pi 8, 0.14 / h)                  rad/s, the loop's natural frequency
//! zeta  = 0.9
//! Kp    = J_v w_n^2
//! Kd    = max(0, 2 zeta J_v w_n - b)
//! v_ms  = F_s + |d| + U                          SRNF: what starts the joint, against its load
//! alpha = min(0.25 / q, (J_v (0.66 / h)^2 - Kp) / v_ms), not below 0
//! v_slip = 0.9 F_c, V_ff = one count a second    feedforward
//!          F_c is less and F_s more by a load |d| + U that friction holds: it is a friction that
//!          depends on the direction (constant load d) and on the place (unbalance U)
//! J_v, b, F_lo = F_c / 2, F_hi = 2 F_s           robust: what it is told
//! load   = |d| + U, if that is more than F_c holds
//! v_max  = min(0.075 U / b, 86 deg/s, 1.25 U / Kd)         [profile]: of a move, an identification
//! a_max  = 0.125 U / J_v, reached in min(0.1 s, 200 h)     all three as the core can keep them
//! ```
//!
//! Why: 0.14/h leaves two samples of delay a phase of 0.28 rad. 8 Hz is below the resonance of most
//! geared joints. Near the target SRNF adds the stiffness `v_ms alpha` to `Kp`; with 0.66/h it has
//! the natural frequency that the thesis's own gains have at 20 ms (`Kp` = 1, `v_ms` = 0.4,
//! `alpha` = 100, and there `alpha q` = 0.24). Feedforward that is more than the friction drives
//! the joint by itself, so it is a tenth less. `robust` bears any friction in the range that it is
//! told, and a data sheet says nothing of place, direction and temperature, hence the factors of
//! two. It makes its own profile of 0.15 U / b, no more than 3 rad/s, and 0.25 U / J_v, with the
//! largest effort U (`duty_max` of the full scale). A move from outside has no more than half of
//! both, so that the inner profile does nothing but land. With 1.25 U / Kd its velocity is also no
//! more than half of the speed at which the default monitor of the other controllers trips, as
//! their gains alone would give it. Without `[profile]` a device with `robust` would crawl: of Kp
//! and Kd there is nothing to derive it from. An identification at 10 deg/s tells little of a joint
//! with a coarse encoder. A joint without friction has neither `robust` nor `[profile]`.
//!
//! Guarantees: on the rigid joint of the data sheet PD has the damping ratio `zeta`. Does badly:
//! knows nothing of resonances and backlash, and is as good as the data sheet. Nothing of it has
//! been tried on a motor.

use std::f64::consts::TAU;

use stiction::ProfileLimits;

use crate::data_sheet::tables::EncoderPlace;
use crate::data_sheet::{DataSheet, Mapping};
use crate::error::rounded;

/// Damping ratio of PD on the joint.
pub const DAMPING_RATIO: f64 = 0.9;

/// Natural frequency times sample time that SRNF's stiffness may reach, as on the thesis's axis.
const STIFFEST: f64 = 0.66;

/// Gains of the controllers of a first file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstGains {
    /// w_n, rad/s.
    pub natural_frequency: f64,
    /// Kp, V/deg.
    pub kp: f64,
    /// Kd, V/(deg/s).
    pub kd: f64,
    /// v_ms, V.
    pub v_ms: f64,
    /// alpha, 1/deg.
    pub alpha: f64,
    /// v_slip, V.
    pub v_slip: f64,
    /// V_ff, deg/s.
    pub v_ff: f64,
    /// What `robust` is told.
    pub robust: Told,
    /// Limits of a move.
    pub profile: Profile,
    /// Largest effort that starts the joint, against its load, V; no more than the drive lets
    /// through.
    pub breakaway: f64,
}

/// Ends of the ranges of friction and gravity, N m; none where the data sheet has a single number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Lowest dynamic friction.
    pub slip_nm: Option<f64>,
    /// Highest static friction.
    pub stick_nm: Option<f64>,
    /// Highest torque of gravity.
    pub unbalance_nm: Option<f64>,
    /// Highest static friction of the joints that are drawn, if it is above `stick_nm`.
    pub drawn_nm: Option<f64>,
}

/// Limits of a move from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// deg/s.
    pub velocity: f64,
    /// deg/s^2.
    pub acceleration: f64,
    /// deg/s^3.
    pub jerk: f64,
    /// Why the velocity is what it is.
    pub why: &'static str,
}

/// Passes at most: rounding to four digits may leave the range that the core can keep, and the next
/// pass corrects that.
const PASSES: u32 = 4;

impl Profile {
    /// Returns the limits with four digits that the core's generator can keep, at a sample time (s)
    /// and an angle of a count (deg): it counts in whole units, of which a tick has no more than so
    /// many.
    fn kept(self, [sample_time_s, count_deg]: [f64; 2]) -> Self {
        let four = |value: f64| rounded(value).parse().unwrap_or(value);
        let mut kept = Self {
            velocity: four(self.velocity),
            acceleration: four(self.acceleration),
            jerk: four(self.jerk),
            ..self
        };
        for _ in 0..PASSES {
            let asked = ProfileLimits {
                velocity: kept.velocity as f32,
                acceleration: kept.acceleration as f32,
                jerk: kept.jerk as f32,
            };
            let near = asked.nearest(sample_time_s as f32, count_deg as f32);
            if near == asked {
                break;
            }
            let change = |from: f64, asked: f32, near: f32| {
                if near == asked { from } else { four_digits(near.into(), near > asked) }
            };
            kept = Self {
                velocity: change(kept.velocity, asked.velocity, near.velocity),
                acceleration: change(kept.acceleration, asked.acceleration, near.acceleration),
                jerk: change(kept.jerk, asked.jerk, near.jerk),
                why: if near.velocity == asked.velocity { kept.why } else { "as the core counts" },
            };
        }
        kept
    }
}

/// The largest number of four digits that is no more, or the smallest one that is no less.
fn four_digits(value: f64, no_less: bool) -> f64 {
    let digit = 10f64.powf(value.abs().log10().floor() - 3.0);
    let digits = value / digit;
    let near = if no_less { digits.ceil() } else { digits.floor() } * digit;
    rounded(near).parse().unwrap_or(near)
}

/// The fastest move of a first file, deg/s: half of the inner profile's 3 rad/s.
const FASTEST: f64 = 86.0;

/// Time within which a move reaches its acceleration, s, and the same in ticks. The generator
/// averages over no more than 256.
const JERK_TIME_S: f64 = 0.1;
const JERK_TICKS: f64 = 200.0;

/// What `robust` is told of a joint, in the core's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// J_v, V s^2/deg.
    pub inertia: f64,
    /// b, V s/deg.
    pub viscous: f64,
    /// F_lo and F_hi, V.
    pub breakaway: [f64; 2],
    /// Whether the encoder sees the load behind a transmission that springs.
    pub behind_a_spring: bool,
    /// The load that drives the joint, V; 0 if its friction holds it.
    pub load: f64,
}

impl Told {
    /// Makes it of a joint with an inertia (V s^2/deg), a viscous friction (V s/deg), and a
    /// friction between the lowest and the highest one that is known of (V).
    pub const fn new(inertia: f64, viscous: f64, [lowest, highest]: [f64; 2]) -> Self {
        let breakaway = [0.5 * lowest, 2.0 * highest];
        Self { inertia, viscous, breakaway, behind_a_spring: false, load: 0.0 }
    }

    /// Tells it a load (V) as well, if a friction of `holds` (V) does not hold it.
    pub const fn with_load(self, load: f64, holds: f64) -> Self {
        Self { load: if load > holds { load } else { 0.0 }, ..self }
    }

    /// Makes it of a data sheet.
    pub fn of(sheet: &DataSheet, mapping: &Mapping) -> Self {
        let friction = either_way(sheet).map(|level| mapping.volts(level));
        let holds = mapping.volts(sheet.slip()[0].min(sheet.slip()[1]));
        let load = mapping.volts(largest_load(sheet));
        let springs = sheet.gear.stiffness_nm_per_rad.or(sheet.gear.stiffness_nm_per_deg).is_some();
        let inertia = mapping.units.per_degree(mapping.inertia);
        Self {
            behind_a_spring: springs && sheet.encoder.at == Some(EncoderPlace::Load),
            ..Self::new(inertia, mapping.viscous_v(), friction).with_load(load, holds)
        }
    }
}

/// Returns the largest torque of the load, N m: constant load and unbalance.
fn largest_load(sheet: &DataSheet) -> f64 {
    sheet.load.constant_nm.abs() + sheet.load.unbalance_nm.abs()
}

/// The least effort that keeps the joint moving slowly and the largest that starts it, N m, over
/// both directions and all places. A load that the friction holds is part of both; one that it does
/// not hold is a figure of its own.
fn either_way(sheet: &DataSheet) -> [f64; 2] {
    let slip = sheet.slip()[0].min(sheet.slip()[1]);
    let load = Some(largest_load(sheet)).filter(|load| *load < slip).unwrap_or(0.0);
    [slip - load, sheet.stick()[0].max(sheet.stick()[1]) + load]
}

/// Returns the largest effort that starts the joint against its load, V; no more than the drive
/// lets through.
fn breakaway(sheet: &DataSheet, mapping: &Mapping) -> f64 {
    mapping.volts(sheet.resting_torque()).min(mapping.full_scale_v * mapping.duty_max)
}

impl FirstGains {
    /// Finds the gains for a joint; `count_deg` is the angle of one count.
    pub fn of(sheet: &DataSheet, mapping: &Mapping, [sample_time_s, count_deg]: [f64; 2]) -> Self {
        let inertia = mapping.units.per_degree(mapping.inertia);
        let natural_frequency = (TAU * 8.0).min(0.14 / sample_time_s);
        let kp = inertia * natural_frequency.powi(2);
        let kd = 2.0 * DAMPING_RATIO * inertia * natural_frequency - mapping.viscous_v();
        let [slip, _] = either_way(sheet).map(|level| mapping.volts(level));
        let v_ms = mapping.volts(sheet.resting_torque());
        let stiffest = inertia * (STIFFEST / sample_time_s).powi(2) - kp;
        let largest_v = mapping.full_scale_v * mapping.duty_max;
        // Of a joint without viscous friction, or a loop without Kd, a share is infinite.
        let of_kd = if kd > 0.0 { 1.25 * largest_v / kd } else { f64::INFINITY };
        let (velocity, why) = [
            (FASTEST, "half of the 3 rad/s of robust at most"),
            (0.075 * largest_v / mapping.viscous_v(), "half of the inner profile of robust"),
            (of_kd, "half of what trips the other controllers"),
        ]
        .into_iter()
        .fold((f64::INFINITY, ""), |least, one| if one.0 < least.0 { one } else { least });
        let acceleration = 0.125 * largest_v / inertia;
        let jerk_time_s = JERK_TIME_S.min(JERK_TICKS * sample_time_s);
        let jerk = 2.0 * acceleration / jerk_time_s;
        let profile = Profile { velocity, acceleration, jerk, why };
        let alpha = if v_ms > 0.0 { (0.25 / count_deg).min(stiffest / v_ms) } else { 0.0 };
        Self {
            natural_frequency,
            kp,
            kd: kd.max(0.0),
            v_ms,
            alpha: alpha.max(0.0),
            v_slip: 0.9 * slip,
            v_ff: count_deg,
            robust: Told::of(sheet, mapping),
            profile: profile.kept([sample_time_s, count_deg]),
            breakaway: breakaway(sheet, mapping),
        }
    }

    /// Sets what follows from the ends of ranges: the friction and the load of `robust`, and the
    /// largest breakaway effort.
    #[must_use]
    pub fn within(self, sheet: &DataSheet, mapping: &Mapping, worst: Worst) -> Self {
        let mut sheet = sheet.clone();
        for (value, end) in [
            (&mut sheet.friction.slip_nm, worst.slip_nm),
            (&mut sheet.friction.stick_nm, worst.stick_nm),
            (&mut sheet.load.unbalance_nm, worst.unbalance_nm),
        ] {
            *value = end.unwrap_or(*value);
        }
        let robust = Told::of(&sheet, mapping);
        let drawn = worst.drawn_nm.unwrap_or(0.0);
        sheet.friction.stick_nm = sheet.friction.stick_nm.max(drawn);
        Self { robust, breakaway: breakaway(&sheet, mapping), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slow limits are raised to what the core counts, and fast ones lowered.
    #[test]
    fn limits_of_a_first_file_are_ones_that_the_core_keeps_as_they_are_written() {
        let mut changed = [0; 2];
        let velocities = (-6..4).map(|power| 3.7 * 10f64.powi(power));
        for velocity in velocities {
            for (sample_time_s, count_deg) in [(1e-4, 1e-3), (1e-3, 3.6e-3), (0.02, 1.8e-4)] {
                for (a, j) in [(2.0, 10.0), (40.0, 20.0)] {
                    let (acceleration, jerk) = (a * velocity, j * a * velocity);
                    let asked = Profile { velocity, acceleration, jerk, why: "" };
                    let Profile { velocity: v, acceleration: a, jerk: j, .. } =
                        asked.kept([sample_time_s, count_deg]);
                    let kept = ProfileLimits {
                        velocity: v as f32,
                        acceleration: a as f32,
                        jerk: j as f32,
                    };
                    let near = kept.nearest(sample_time_s as f32, count_deg as f32);
                    assert_eq!(near, kept, "{asked:?} at {sample_time_s} s, {count_deg} deg");
                    changed[0] += u32::from(v > 1.001 * velocity);
                    changed[1] += u32::from(v < 0.999 * velocity);
                }
            }
        }
        assert!(changed.iter().all(|cases| *cases > 0), "raised and lowered: {changed:?}");
    }
}
