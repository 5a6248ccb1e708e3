//! Conditions that the joints of a family can be run under. No law is configured for them.
//!
//! ```text
//! drift                 friction x 0.6 to 1.6 and back: levels and viscous friction move from one
//!                       to the other with a time constant of 5 s
//! uneven-40, -200       friction x (1 + 0.3 sin(n theta + phi)), n = 40 and 200 periods a turn
//! dwell                 stick friction x (1 + 0.5 (1 - exp(-t / 1 s))) after a rest of t
//! slow-winding-1, -5    the effort lags by the winding's L/R = 1 ms and 5 ms
//! hot-winding           R x 1.4: effort / 1.4
//! cold-winding          R x 0.7: effort / 0.7
//! low-supply            the supply is 20 % low: effort x 0.8
//! high-supply           the supply is 20 % high: effort x 1.2
//! hot-low               both: effort x 0.8 / 1.4
//! sag                   the supply sags by 30 % for 0.1 s in each second: effort x 0.7
//! late-output           the output is two samples late; usually half of the joints have one sample
//! sampling-jitter       each tick comes up to 5 % of the sample time early or late
//! eccentric             the disc is 20 um off its centre, at a radius of 15 mm: the reading is
//!                       theta + 1.33 mrad sin(theta + phi)
//! ```
//!
//! With `drift`, friction rises on half of the joints and falls on the other half. With an
//! eccentric disc, a joint is judged by the position that its disc shows. With an ideal bridge, the
//! back-EMF of a winding is part of the viscous friction and stays the same; with
//! [electrics](super::electrics) it does not. A bristle has no drift, unevenness or dwell, and arms
//! have no conditions.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::distribution::Draws;
use super::family::Family;
use dynamics::joint::{CountNoise, Description, Dwell, Ripple, SetValuedFriction, Thermal, Train};
use files::setup::name_of;
use simulator::plant::Delay;

/// A condition of a joint and its drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "command-line", derive(clap::ValueEnum))]
pub enum Condition {
    /// As the family is drawn.
    #[default]
    Nominal,
    /// Friction drifts from 0.6 to 1.6 times its levels, or back.
    Drift,
    /// Friction varies by 30 % with the angle, 40 periods a turn.
    #[cfg_attr(feature = "command-line", value(name = "uneven-40"))]
    #[serde(rename = "uneven-40")]
    Uneven40,
    /// Friction varies by 30 % with the angle, 200 periods a turn.
    #[cfg_attr(feature = "command-line", value(name = "uneven-200"))]
    #[serde(rename = "uneven-200")]
    Uneven200,
    /// Stick friction grows by half while the joint rests.
    Dwell,
    /// The winding's L/R is 1 ms.
    #[cfg_attr(feature = "command-line", value(name = "slow-winding-1"))]
    #[serde(rename = "slow-winding-1")]
    SlowWinding1,
    /// The winding's L/R is 5 ms.
    #[cfg_attr(feature = "command-line", value(name = "slow-winding-5"))]
    #[serde(rename = "slow-winding-5")]
    SlowWinding5,
    /// The winding's resistance is 1.4 times the configured one.
    HotWinding,
    /// The winding's resistance is 0.7 times the configured one.
    ColdWinding,
    /// The supply is 20 % below its nominal voltage.
    LowSupply,
    /// The supply is 20 % above its nominal voltage.
    HighSupply,
    /// The winding's resistance is 1.4 times the configured one, and the supply is 20 % low.
    HotLow,
    /// The supply sags by 30 % for 0.1 s in each second.
    Sag,
    /// The output is two samples late.
    LateOutput,
    /// Ticks come up to 5 % of the sample time early or late.
    SamplingJitter,
    /// The encoder's disc is off its centre.
    Eccentric,
}

/// Friction at the start and at the end of a drift.
const DRIFT: [f64; 2] = [0.6, 1.6];
/// Time constant of a drift, s.
const DRIFT_S: f64 = 5.0;
/// Relative amplitude of uneven friction.
const DEPTH: f64 = 0.3;
/// Growth of the stick friction at rest, and its time constant.
const GROWTH: Dwell = Dwell { growth: 0.5, time_s: 1.0 };
/// Resistance of a hot and of a cold winding, relative.
const HOT: f64 = 1.4;
const COLD: f64 = 0.7;
/// Voltage of a low and of a high supply, relative.
const LOW: f64 = 0.8;
const HIGH: f64 = 1.2;
/// Effort while the supply sags, relative; its length and its period, s.
const SAG: (f64, [f64; 2]) = (0.7, [0.1, 1.0]);
/// Largest shift of a tick, in sample times.
pub(super) const SHIFT: f64 = 0.05;
/// Eccentricity of a disc over its radius.
const ECCENTRICITY: f64 = 0.02 / 15.0;

impl Condition {
    /// Every condition.
    pub const ALL: [Self; 16] = [
        Self::Nominal,
        Self::Drift,
        Self::Uneven40,
        Self::Uneven200,
        Self::Dwell,
        Self::SlowWinding1,
        Self::SlowWinding5,
        Self::HotWinding,
        Self::ColdWinding,
        Self::LowSupply,
        Self::HighSupply,
        Self::HotLow,
        Self::Sag,
        Self::LateOutput,
        Self::SamplingJitter,
        Self::Eccentric,
    ];

    /// Returns the name in options and reports.
    pub fn name(self) -> String {
        name_of(&self)
    }

    /// Returns the suffix that tables append to the name of a family; empty for `Nominal`.
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

    /// Applies the condition to a joint, with two draws; `degree` is the angle of a degree in the
    /// unit of the joint. Returns the phase of uneven friction and of an eccentric disc, rad.
    pub(super) fn apply(self, joint: &mut Description, degree: f64, draws: &mut Draws) -> f64 {
        let rises = draws.coin();
        let phase = draws.uniform(0.0, TAU);
        let per_turn = TAU / (360.0 * degree);
        let lag_s = joint.lag_s;
        match self {
            Self::Drift => each_friction(joint, |friction| {
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
            Self::Uneven40 | Self::Uneven200 => each_friction(joint, |friction| {
                let periods = if self == Self::Uneven40 { 40.0 } else { 200.0 };
                friction.ripple = Some(Ripple { depth: DEPTH, cycles: periods * per_turn, phase });
            }),
            Self::Dwell => each_friction(joint, |friction| friction.dwell = Some(GROWTH)),
            Self::SlowWinding1 | Self::SlowWinding5 => joint.lag_s = lag_s.max(self.winding_s()),
            Self::Nominal
            | Self::HotWinding
            | Self::ColdWinding
            | Self::LowSupply
            | Self::HighSupply
            | Self::HotLow
            | Self::Sag
            | Self::LateOutput
            | Self::SamplingJitter
            | Self::Eccentric => {}
        }
        phase
    }

    /// Returns the delay of the output; `drawn` is the joint's own.
    pub(super) fn delay(self, drawn: Delay) -> Delay {
        if self == Self::LateOutput { Delay::TwoSamples } else { drawn }
    }

    /// Returns the least time constant L/R of the winding, s.
    pub(super) const fn winding_s(self) -> f64 {
        match self {
            Self::SlowWinding1 => 1e-3,
            Self::SlowWinding5 => 5e-3,
            _ => 0.0,
        }
    }

    /// Returns the supply over its nominal voltage at a time since arming (s), and the resistance
    /// of the winding over the configured one.
    #[inline]
    pub(super) fn ratios(self, time_s: f64) -> [f64; 2] {
        match self {
            Self::HotWinding => [1.0, HOT],
            Self::ColdWinding => [1.0, COLD],
            Self::LowSupply => [LOW, 1.0],
            Self::HighSupply => [HIGH, 1.0],
            Self::HotLow => [LOW, HOT],
            Self::Sag if time_s % SAG.1[1] >= SAG.1[1] - SAG.1[0] => [SAG.0, 1.0],
            _ => [1.0; 2],
        }
    }

    /// Returns the share of the effort that reaches the joint at a time since arming (s), if the
    /// bridge is ideal.
    #[inline]
    pub(super) fn share(self, time_s: f64) -> f64 {
        let [supply, ohm] = self.ratios(time_s);
        supply / ohm
    }
}

fn each_friction(joint: &mut Description, mut change: impl FnMut(&mut SetValuedFriction)) {
    match &mut joint.train {
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
    /// Angle of a unit of the joint, rad.
    per_unit: f64,
    phase: f64,
}

impl EccentricDisc {
    /// Creates a disc with a phase, rad; `degree` is the angle of a degree in the unit of the
    /// joint.
    pub fn new(degree: f64, phase: f64) -> Self {
        let per_unit = degree.recip().to_radians();
        Self { amplitude: ECCENTRICITY / per_unit, per_unit, phase }
    }

    /// Returns the position that the disc shows.
    #[inline]
    pub fn shows(&self, position: f64) -> f64 {
        position + self.amplitude * libm::sin(self.per_unit * position + self.phase)
    }
}
