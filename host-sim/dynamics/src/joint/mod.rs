//! Joints in SI units (rad, N m, kg m^2, s), moved by an effort that the amplifier holds.
//!
//! A [`Description`] is plain data; [`Description::build`] makes an [`AnyJoint`] of it, with the
//! solver for its friction:
//!
//! | joint | friction | solver |
//! |---|---|---|
//! | [`RigidJoint`] | set-valued Stribeck curve | Runge-Kutta 5(4) between located switches |
//! | [`LuGreJoint`] | a bristle | linearly implicit, error-controlled; frozen at rest |
//! | [`FlexibleJoint`] | set-valued on motor and load | Runge-Kutta 5(4) between located switches |
//! | [`GearedArm`] | set-valued on both joints, coupled | Runge-Kutta 5(4), both decided at once |
//!
//! A stuck joint needs almost no computation while its effort is constant. [`InCoreUnits`] makes an
//! axis in the core's degrees and volts of a joint. `docs/explanation/simulator.md` has the tests,
//! the error and the speed of each plant.

mod arm;
mod description;
mod encoder;
mod flexible;
mod in_core_units;
mod lag;
mod lugre;
mod of_a_run;
mod open_lines;
pub mod presets;
mod push;
mod random;
mod rigid;
mod runge_kutta;
mod shaft;
mod shaft_end;
mod step;
mod surface;
#[cfg(test)]
mod tests;

pub use arm::{ArmDescription, GearedArm};
pub use description::{
    Body, Bristle, Description, Dwell, Gravity, LoadTorque, Ripple, SetValuedFriction,
    ShaftDescription, Stops, StribeckCurve, Thermal, TorquePulse, Train,
};
pub use encoder::{CountNoise, DiscSide, JointEncoder};
pub use flexible::FlexibleJoint;
pub use in_core_units::{CoreUnits, InCoreUnits};
pub use lugre::LuGreJoint;
pub use of_a_run::{RunJoint, Substitute};
pub use open_lines::{OpenLineDecoder, OpenLines};
pub use rigid::RigidJoint;

use crate::solver::Event;

/// Angle and speed of one end of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// Angle, rad.
    pub position: f64,
    /// Speed, rad/s.
    pub velocity: f64,
}

/// A joint that moves under a held effort.
pub trait Joint {
    /// Moves the joint for a time (s) under a held effort (N m), and reports breaks, sticks and
    /// reversals of the motor.
    fn hold_and_report(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event));

    /// Moves the joint for a time (s) under a held effort (N m).
    #[inline]
    fn hold(&mut self, effort: f64, duration_s: f64) {
        self.hold_and_report(effort, duration_s, &mut |_| {});
    }

    /// Returns angle and speed of the motor, behind the gear.
    fn motor(&self) -> Turn;

    /// Returns angle and speed of the load.
    fn load(&self) -> Turn;

    /// Returns the rest of the former effort behind the lag of the winding (N m): the present
    /// effort minus the held one.
    fn effort_left(&self) -> f64 {
        0.0
    }

    /// Returns whether the whole joint is at rest, and stays so while nothing changes.
    fn is_stuck(&self) -> bool;

    /// Returns the time (s) that was skipped because its switches did not end. It is zero for a
    /// valid simulation; otherwise do not use the motion.
    fn unfollowed_s(&self) -> f64;

    /// Sets the friction (N m) that a brake or a hand adds to both levels of the motor, until the
    /// next call.
    fn set_brake(&mut self, torque: f64);

    /// Takes a part of the motor's viscous friction (N m s/rad) away: that of the back-EMF of an
    /// open winding. 0 closes the winding.
    fn open_winding(&mut self, viscous: f64);

    /// Sets angle and speed of the whole joint, as if it was moved by hand.
    fn put(&mut self, turn: Turn);

    /// Winds up a joint at rest until its gear carries the load: the load lies on a flank of the
    /// slack. The end with the encoder does not move. Does nothing to a joint of one body, or if
    /// the friction cannot hold the load.
    fn wind_up(&mut self, _seen: DiscSide) {}
}

/// Any of the joints, without dynamic dispatch in the inner loop.
#[derive(Clone, Debug)]
pub enum AnyJoint {
    /// One inertia, set-valued friction.
    Rigid(RigidJoint),
    /// One inertia, LuGre friction.
    LuGre(LuGreJoint),
    /// Two inertias and a shaft.
    Flexible(Box<FlexibleJoint>),
}

/// Calls the same method of any of the joints.
macro_rules! each {
    ($joint:expr, $inner:ident => $does:expr) => {
        match $joint {
            Self::Rigid($inner) => $does,
            Self::LuGre($inner) => $does,
            Self::Flexible($inner) => $does,
        }
    };
}

impl Joint for AnyJoint {
    #[inline]
    fn hold_and_report(&mut self, effort: f64, duration_s: f64, on: &mut impl FnMut(Event)) {
        each!(self, joint => joint.hold_and_report(effort, duration_s, on));
    }

    #[inline]
    fn motor(&self) -> Turn {
        each!(self, joint => joint.motor())
    }

    #[inline]
    fn load(&self) -> Turn {
        each!(self, joint => joint.load())
    }

    fn effort_left(&self) -> f64 {
        each!(self, joint => joint.effort_left())
    }

    #[inline]
    fn is_stuck(&self) -> bool {
        each!(self, joint => joint.is_stuck())
    }

    fn unfollowed_s(&self) -> f64 {
        each!(self, joint => joint.unfollowed_s())
    }

    fn set_brake(&mut self, torque: f64) {
        each!(self, joint => joint.set_brake(torque));
    }

    fn open_winding(&mut self, viscous: f64) {
        each!(self, joint => joint.open_winding(viscous));
    }

    fn put(&mut self, turn: Turn) {
        each!(self, joint => joint.put(turn));
    }

    fn wind_up(&mut self, seen: DiscSide) {
        each!(self, joint => joint.wind_up(seen));
    }
}
