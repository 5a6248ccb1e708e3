//! Conditions that the joints of any family can be run under, and that no law knows.
//!
//! ```text
//! drift                 friction x 0.6 to 1.6 and back: levels and viscous friction move from one
//!                       to the other with a time constant of 5 s
//! uneven-40, -200       friction x (1 + 0.3 sin(n theta + phi)), n = 40 and 200 periods a turn
//! dwell                 stick friction x (1 + 0.5 (1 - exp(-t / 1 s))) after a rest of t
//! slow-winding-1, -5    the effort lags by the winding's L/R = 1 ms and 5 ms
//! hot-winding           R x 1.4: effort / 1.4
//! sag                   the supply sags by 30 % for 0.1 s in each second: effort x 0.7
//! sampling-jitter       each tick comes up to 5 % of the sample time early or late
//! eccentric             the disc is 20 um off its centre, at a radius of 15 mm: the reading is
//!                       theta + 1.33 mrad sin(theta + phi)
//! ```
//!
//! Of each pair the joints have a half: friction that rises, and friction that falls. With an
//! eccentric disc a joint is judged where its disc shows it. The back-EMF of a hot winding is part
//! of the viscous friction and stays. A bristle has no such friction, and arms have no conditions.

use std::f64::consts::TAU;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::distribution::{Draws, Purpose};
use super::drawn_case::Case;
use super::family::Family;
use dynamics::joint::{CountNoise, Dwell, Ripple, SetValuedFriction, Thermal, Train};

/// A condition of a joint and its drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// As the family is drawn.
    #[default]
    Nominal,
    /// Friction drifts from 0.6 to 1.6 times its levels, or back.
    Drift,
    /// Friction varies by 30 % with the angle, 40 periods a turn.
    #[value(name = "uneven-40")]
    #[serde(rename = "uneven-40")]
    Uneven40,
    /// Friction varies by 30 % with the angle, 200 periods a turn.
    #[value(name = "uneven-200")]
    #[serde(rename = "uneven-200")]
    Uneven200,
    /// Stick friction grows by half while the joint rests.
    Dwell,
    /// The winding's L/R is 1 ms.
    #[value(name = "slow-winding-1")]
    #[serde(rename = "slow-winding-1")]
    SlowWinding1,
    /// The winding's L/R is 5 ms.
    #[value(name = "slow-winding-5")]
    #[serde(rename = "slow-winding-5")]
    SlowWinding5,
    /// The winding's resistance is 1.4 times the configured one.
    HotWinding,
    /// The supply sags by 30 % for 0.1 s in each second.
    Sag,
    /// Ticks come up to 5 % of the sample time early or late.
    SamplingJitter,
    /// The encoder's disc is off its centre.
    Eccentric,
}

/// Friction at the start and at the end of a drift.
const DRIFT: [f64; 2] = [0.6, 1.6];
/// Its time constant, s.
const DRIFT_S: f64 = 5.0;
/// Relative amplitude of uneven friction.
const DEPTH: f64 = 0.3;
/// Growth of the stick friction at rest, and its time constant.
const GROWTH: Dwell = Dwell { growth: 0.5, time_s: 1.0 };
/// Resistance of a hot winding, relative.
const HOT: f64 = 1.4;
/// Effort while the supply sags, relative; its length and its period, s.
const SAG: (f64, [f64; 2]) = (0.7, [0.1, 1.0]);
/// Largest shift of a tick, in sample times.
const SHIFT: f64 = 0.05;
/// Eccentricity of a disc over its radius.
const ECCENTRICITY: f64 = 0.02 / 15.0;

impl Condition {
    /// Returns the name in options and reports.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().into())
    }

    /// Returns the condition after the name of a family, as tables have it.
    pub(super) fn suffix(self) -> String {
        if self == Self::Nominal { String::new() } else { format!(", {}", self.name()) }
    }

    /// Returns whether the joints of a family can be run under it.
    pub const fn fits(self, family: Family) -> bool {
        let is_bristle =
            matches!(family, Family::LuGre | Family::OverhaulingLuGre | Family::EndStopLuGre);
        match self {
            Self::Nominal => true,
            Self::Drift | Self::Uneven40 | Self::Uneven200 | Self::Dwell => {
                !is_bristle && !family.is_arm()
            }
            _ => !family.is_arm(),
        }
    }

    /// Puts a joint under the condition.
    pub(super) fn apply(self, case: &mut Case, seed: u64) {
        let draws = &mut Draws::new(seed, case.family.number(), Purpose::Condition, case.number);
        let rises = draws.coin();
        let phase = draws.uniform(0.0, TAU);
        let per_turn = case.scale.angle.recip() * TAU / 360.0;
        case.condition = self;
        case.phase = phase;
        let lag_s = case.joint.lag_s;
        match self {
            Self::Drift => each_friction(case, |friction| {
                let [from, to] = if rises { DRIFT } else { [DRIFT[1], DRIFT[0]] };
                let curve = &mut friction.curve;
                for level in [&mut curve.coulomb, &mut curve.stick, &mut curve.viscous] {
                    *level *= to;
                }
                friction.thermal = Some(Thermal {
                    start_k: -libm::log(from / to),
                    heating_k_per_w: 0.0,
                    time_s: DRIFT_S,
                    levels_per_k: 1.0,
                    viscous_per_k: 1.0,
                });
            }),
            Self::Uneven40 | Self::Uneven200 => each_friction(case, |friction| {
                let periods = if self == Self::Uneven40 { 40.0 } else { 200.0 };
                friction.ripple = Some(Ripple { depth: DEPTH, cycles: periods * per_turn, phase });
            }),
            Self::Dwell => each_friction(case, |friction| friction.dwell = Some(GROWTH)),
            Self::SlowWinding1 => case.joint.lag_s = lag_s.max(1e-3),
            Self::SlowWinding5 => case.joint.lag_s = lag_s.max(5e-3),
            Self::Nominal
            | Self::HotWinding
            | Self::Sag
            | Self::SamplingJitter
            | Self::Eccentric => {}
        }
    }

    /// Returns the share of the effort that reaches the joint at a time since arming, s.
    #[inline]
    pub(super) fn share(self, time_s: f64) -> f64 {
        match self {
            Self::HotWinding => HOT.recip(),
            Self::Sag if time_s % SAG.1[1] >= SAG.1[1] - SAG.1[0] => SAG.0,
            _ => 1.0,
        }
    }
}

fn each_friction(case: &mut Case, mut change: impl FnMut(&mut SetValuedFriction)) {
    match &mut case.joint.train {
        Train::Rigid(body) => change(&mut body.friction),
        Train::Flexible { motor, load, .. } => {
            change(&mut motor.friction);
            change(&mut load.friction);
        }
        Train::LuGre { .. } => {}
    }
}

/// Times of ticks that jitter: each is early, on time or late, independently of the others.
#[derive(Clone, Debug)]
pub(super) struct JitteringTicks {
    random: CountNoise,
    shift: f64,
}

impl JitteringTicks {
    pub const fn new(seed: u64) -> Self {
        Self { random: CountNoise::new(seed), shift: 0.0 }
    }

    /// Returns the time until the next tick, in sample times.
    #[inline]
    pub fn next(&mut self) -> f64 {
        let shift = SHIFT * self.random.next() as f64;
        let until = 1.0 + shift - self.shift;
        self.shift = shift;
        until
    }
}

/// A disc that is off its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct EccentricDisc {
    /// Largest error of a reading, in the unit of the joint.
    amplitude: f64,
    /// Radians of a unit of the joint.
    per_unit: f64,
    phase: f64,
}

impl EccentricDisc {
    pub fn of(case: &Case) -> Self {
        let per_unit = case.scale.angle.recip().to_radians();
        Self { amplitude: ECCENTRICITY / per_unit, per_unit, phase: case.phase }
    }

    /// Returns the position that the disc shows.
    #[inline]
    pub fn shows(&self, position: f64) -> f64 {
        position + self.amplitude * libm::sin(self.per_unit * position + self.phase)
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawn_case::DrawOptions;
    use super::*;

    fn drawn(family: Family, condition: Condition) -> Case {
        Case::draw(3, family, 4, DrawOptions { condition, ..DrawOptions::ORDINARY })
    }

    fn friction(case: &Case) -> SetValuedFriction {
        let Train::Rigid(body) = case.joint.train else { panic!("{case:?}") };
        body.friction
    }

    #[test]
    fn a_condition_is_the_only_difference_to_the_joint_of_its_family() {
        for family in [Family::Rigid, Family::FlexibleMotor, Family::ThesisAxis] {
            let nominal = drawn(family, Condition::Nominal);
            for condition in Condition::value_variants() {
                let case = drawn(family, *condition);
                assert!(case.joint.build().is_ok(), "{condition:?}");
                let same = Case { joint: nominal.joint, condition: Condition::Nominal, ..case };
                assert_eq!(Case { phase: 0.0, ..same }, Case { phase: 0.0, ..nominal.clone() });
            }
        }
    }

    /// exp(-T) times the levels at the end.
    #[test]
    fn friction_drifts_from_three_fifths_to_eight_fifths_of_its_levels_or_back() {
        let (mut rising, cases) = (0, 200);
        for number in 0..cases {
            let of = |condition| {
                let options = DrawOptions { condition, ..DrawOptions::ORDINARY };
                friction(&Case::draw(3, Family::Rigid, number, options))
            };
            let (nominal, drifts) = (of(Condition::Nominal), of(Condition::Drift));
            let end = drifts.curve.stick / nominal.curve.stick;
            let start = end * (-drifts.thermal.unwrap().start_k).exp();
            let is_rising = end > 1.0;
            let [from, to] = if is_rising { [0.6, 1.6] } else { [1.6, 0.6] };
            assert!((start - from).abs() < 1e-9 && (end - to).abs() < 1e-9, "{start} {end}");
            rising += u64::from(is_rising);
        }
        // Five standard deviations of a fair coin.
        assert!(rising.abs_diff(cases / 2) < 36, "{rising}");
    }

    /// A turn is 2 pi rad of one and 360 deg of the other.
    #[test]
    fn uneven_friction_has_its_periods_in_a_turn() {
        for (family, turn) in [(Family::Rigid, TAU), (Family::ThesisAxis, 360.0)] {
            for (condition, periods) in [(Condition::Uneven40, 40.0), (Condition::Uneven200, 200.0)]
            {
                let ripple = friction(&drawn(family, condition)).ripple.unwrap();
                assert!((ripple.cycles * turn / TAU - periods).abs() < 1e-9, "{ripple:?}");
            }
        }
    }

    #[test]
    fn the_supply_sags_for_a_tenth_of_the_time() {
        let low = (0..10_000).filter(|k| Condition::Sag.share(f64::from(*k) * 1e-3) < 0.8).count();
        assert!(low.abs_diff(1000) <= 10, "{low}");
        assert!((Condition::HotWinding.share(0.0) * 1.4 - 1.0).abs() < 1e-12);
    }

    /// Jitter of a timer does not add up: after any number of ticks it is at most a shift off.
    #[test]
    fn ticks_that_jitter_stay_near_their_time() {
        let (mut ticks, mut time, mut extremes) = (JitteringTicks::new(7), 0.0, [1.0f64; 2]);
        for k in 1..=1000 {
            let until = ticks.next();
            extremes = [extremes[0].min(until), extremes[1].max(until)];
            time += until;
            assert!((time - f64::from(k)).abs() < SHIFT + 1e-9, "{k}: {time}");
        }
        assert!((extremes[0] - 0.9).abs() < 1e-9 && (extremes[1] - 1.1).abs() < 1e-9);
    }

    /// 1.33 mrad are 21 counts of 100 000 a turn.
    #[test]
    fn an_eccentric_disc_is_off_by_the_same_angle_in_every_unit() {
        for family in [Family::Rigid, Family::ThesisAxis] {
            let case = drawn(family, Condition::Eccentric);
            let disc = EccentricDisc::of(&case);
            let turn = 360.0 * case.scale.angle;
            let worst = (0..1000)
                .map(|k| f64::from(k) * turn / 1000.0)
                .map(|position| (disc.shows(position) - position).abs())
                .fold(0.0, f64::max);
            assert!((worst / turn * 1e5 - 21.2).abs() < 0.1, "{worst}");
        }
    }

    #[test]
    fn a_bristle_and_an_arm_are_refused_where_they_have_no_such_friction() {
        assert!(!Condition::Drift.fits(Family::LuGre) && Condition::Sag.fits(Family::LuGre));
        assert!(!Condition::Sag.fits(Family::Arm) && Condition::Nominal.fits(Family::Arm));
    }
}
