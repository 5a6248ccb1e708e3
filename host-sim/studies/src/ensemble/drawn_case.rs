//! A drawn case: the joint with its loop and moves, and the figures that several draws share.

use dynamics::joint::{ArmDescription, Description, JointEncoder, Stops};
use simulator::plant::Delay;
use simulator::rules::{ControllerGains, GainRule, JointBounds, SampledLoop};

use super::bridge::{Bridge, Electrics};
use super::condition::Condition;
use super::family::Family;

/// Nominal inertia of the SI families, kg m^2, and viscous friction, N m s/rad.
pub(super) const NOMINAL: [f64; 2] = [0.34, 1.3];

/// Effort limit of the SI families and its step, N m.
pub(super) const EFFORT: [f64; 2] = [60.0, 0.06];

/// Bounds of the breakaway effort of the SI families, N m: F_c U(2, 6) times U(1.05, 2).
pub(super) const BREAKAWAY: [f64; 2] = [2.0, 12.0];

/// Bounds of the breakaway effort of a hard joint, N m: F_c U(2, 6) times U(2, 4).
pub(super) const HARD_BREAKAWAY: [f64; 2] = [2.0, 24.0];

/// Range of the backlash of a real gear at the joint, deg.
pub(super) const GEAR_BACKLASH_DEG: [f64; 2] = [0.1, 1.0];

/// Distance of a wall before the target, counts.
const WALL: f64 = 5.0;

/// Options of the draw beside the seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawOptions {
    /// Stick friction of 2 to 4 times the slip friction, instead of 1.05 to 2 times.
    pub hard: bool,
    /// Samples per second of the SI families.
    pub rate_hz: f64,
    /// Condition of the joint and its drive.
    pub condition: Condition,
    /// What the bridge makes of an effort.
    pub bridge: Bridge,
}

impl DrawOptions {
    /// Ordinary joints at 1 kHz, as their family is drawn.
    pub const ORDINARY: Self =
        Self { hard: false, rate_hz: 1000.0, condition: Condition::Nominal, bridge: Bridge::Ideal };

    /// Returns the suffix that tables append to the name of a family; empty for an ideal bridge
    /// and no condition.
    pub(super) fn suffix(&self) -> String {
        self.condition.suffix() + &self.bridge.suffix()
    }
}

/// Factors from the core's units to those of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitScale {
    /// Effort of one volt of the core, in the unit of the joint.
    pub effort: f64,
    /// Angle of one degree of the core, in the unit of the joint.
    pub angle: f64,
}

/// A trapezoid of speed to a place and back, with parabolic blends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trapezoid {
    /// Distance to the place, in the unit of the joint.
    pub distance: f64,
    /// Speed, in the unit of the joint per s.
    pub speed: f64,
    /// Rest between there and back, s.
    pub dwell_s: f64,
    /// Half the time of a blend, s.
    pub half_blend_s: f64,
}

/// One joint with its loop and its moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Family of the joint.
    pub family: Family,
    /// Number of the case in its family.
    pub number: u64,
    /// The joint.
    pub joint: Description,
    /// Encoder of the joint.
    pub encoder: JointEncoder,
    /// Encoder of the motor beside it, if there are two.
    pub motor_encoder: Option<JointEncoder>,
    /// Computation delay.
    pub delay: Delay,
    /// Factors from the core's units to those of the joint.
    pub scale: UnitScale,
    /// Bounds from which the laws have their gains.
    pub bounds: JointBounds,
    /// Distance of the step, in the unit of the joint.
    pub step: f64,
    /// The trajectory.
    pub trapezoid: Trapezoid,
    /// Whether a brake holds the joint until the move begins.
    pub is_braked: bool,
    /// Distance that the load jumps when it breaks away behind a flexible gear, counts. `None`
    /// unless the encoder is on the load.
    pub jump_counts: Option<f64>,
    /// Condition of the joint and its drive.
    pub condition: Condition,
    /// Phase of uneven friction or of an eccentric disc, rad.
    pub phase: f64,
    /// Winding and current loop of the motor; `None` with an ideal bridge.
    pub electrics: Option<Electrics>,
    /// Both joints of an arm; `joint` is then the first one, without the motion of the links.
    pub arm: Option<Box<ArmCase>>,
}

/// Additional data of an arm's case: the arm and its second joint.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmCase {
    /// The arm.
    pub arm: ArmDescription,
    /// Whether the motion of one joint acts on the other.
    pub is_coupled: bool,
    /// Bounds of the second joint.
    pub bounds: JointBounds,
    /// Distance of the second joint's step, rad.
    pub step: f64,
    /// Trajectory of the second joint.
    pub trapezoid: Trapezoid,
    /// Computation delay of the second joint.
    pub delay: Delay,
}

impl Case {
    /// Returns the gains of a law for each of its joints.
    pub fn gains(&self, rule: &GainRule) -> Vec<ControllerGains> {
        self.each(|bounds| rule.gains(bounds))
    }

    /// Calls a function with the bounds of each of its joints.
    pub(super) fn each<T>(&self, does: impl Fn(&JointBounds) -> T) -> Vec<T> {
        let second = self.arm.as_deref().map(|arm| &arm.bounds);
        std::iter::once(&self.bounds).chain(second).map(does).collect()
    }

    /// Returns the angle of a count, in the unit of the joint.
    pub const fn count(&self) -> f64 {
        self.encoder.count
    }
}

impl UnitScale {
    /// Returns the bounds of a joint, in the core's units: inertia and viscous friction, breakaway,
    /// largest load, effort limit and its step, count (all in the unit of the joint) and sample
    /// time (s).
    pub(super) fn bounds(
        self,
        [inertia, viscous]: [f64; 2],
        breakaway: [f64; 2],
        load: f64,
        [full_scale, lsb]: [f64; 2],
        [count, sample_time]: [f64; 2],
    ) -> JointBounds {
        // A torque of a N m is 1/G volts, and an acceleration of a rad/s^2 is 180/pi deg/s^2.
        let per_angle = self.angle / self.effort;
        JointBounds {
            inertia: inertia * per_angle,
            viscous: viscous * per_angle,
            breakaway: breakaway.map(|torque| torque / self.effort),
            load: load / self.effort,
            induced: 0.0,
            hold_effort: 0.0,
            encoder_at_load: false,
            jitter: 0.0,
            motor_encoder: None,
            sampled: SampledLoop {
                largest_effort: full_scale / self.effort,
                lsb: lsb / self.effort,
                count: count / self.angle,
                sample_time,
            },
        }
    }
}

/// Returns a wall before the target of a step.
pub(super) fn wall(step: f64, count: f64) -> Stops {
    let at = step - step.signum() * WALL * count;
    if step > 0.0 {
        Stops { upper: at, ..Stops::default() }
    } else {
        Stops { lower: at, ..Stops::default() }
    }
}
