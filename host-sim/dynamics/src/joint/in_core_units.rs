//! Adapter from a joint in SI to the core's axis in degrees and volts. Only this file has the
//! conversions.
//!
//! With the effort gain G (N m of the joint for each volt of effort: torque constant, amplifier
//! and gear ratio in one):
//!
//! ```text
//! J_v = J (pi/180)/G [V s^2/deg]    B_v = B (pi/180)/G [V s/deg]    F_v = F/G [V]
//! x_deg = x 180/pi
//! ```
//!
//! J_v is 1/kappa of [`RobotAxis`]: its acceleration for each volt is `G/(J pi/180)` deg/s^2.

use super::{Joint, StribeckCurve, Turn};
use crate::friction;
use crate::mechanism::RobotAxis;
use crate::solver::{AxisSolver, Event};

/// Conversion from SI at the joint to the core's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoreUnits {
    /// Effort gain G, N m/V.
    pub effort_gain: f64,
}

impl CoreUnits {
    /// Returns the effort (N m) of a voltage (V).
    #[inline]
    pub fn effort(&self, volts: f64) -> f64 {
        volts * self.effort_gain
    }

    /// Returns the voltage (V) of a friction or any other torque (N m).
    pub fn volts(&self, torque: f64) -> f64 {
        torque / self.effort_gain
    }

    /// Returns J_v (V s^2/deg) of an inertia (kg m^2), or B_v (V s/deg) of a viscous coefficient
    /// (N m s/rad).
    pub fn per_degree(&self, si: f64) -> f64 {
        si.to_radians() / self.effort_gain
    }

    /// Returns the core's axis of a rigid joint with this inertia and curve. Its friction levels
    /// are the ends of the curve.
    pub fn axis(&self, inertia: f64, curve: &StribeckCurve) -> RobotAxis {
        RobotAxis {
            gain: 1.0 / self.per_degree(inertia),
            viscous: self.per_degree(curve.viscous),
            friction: friction::Coulomb {
                stick: self.volts(curve.stick),
                slip: self.volts(curve.coulomb),
            },
            added: friction::AddedFriction::default(),
        }
    }
}

/// Joint in SI with the interface of an axis solver, for use in a `simulator::plant::Plant`.
/// Position and velocity are those of the encoder's side of the gear.
#[derive(Clone, Debug)]
pub struct InCoreUnits<J> {
    /// The joint.
    pub joint: J,
    units: CoreUnits,
    side: super::DiscSide,
    /// Slip level of the plant's axis, V; friction above it is a brake.
    slip_v: f64,
    braked_v: f64,
}

impl<J: Joint> InCoreUnits<J> {
    /// Creates an axis from a joint, with the encoder on one side; `axis` is that of the plant. The
    /// load starts on the flank of the gear that carries it ([`Joint::wind_up`]): a load that fell
    /// through the slack would move the joint before it is armed.
    pub fn new(mut joint: J, units: CoreUnits, side: super::DiscSide, axis: &RobotAxis) -> Self {
        joint.wind_up(side);
        Self { joint, units, side, slip_v: axis.friction.slip, braked_v: 0.0 }
    }

    /// Sets position (deg) and velocity (deg/s) of the encoder's side, as if it was moved by hand.
    /// Without velocity, the load lies on a flank again.
    pub fn put(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        let (position, velocity) = (position_deg.to_radians(), velocity_deg_per_s.to_radians());
        self.joint.put(Turn { position, velocity });
        self.joint.wind_up(self.side);
    }

    #[inline]
    fn seen(&self) -> Turn {
        match self.side {
            super::DiscSide::Motor => self.joint.motor(),
            super::DiscSide::Load => self.joint.load(),
        }
    }
}

impl<J: Joint> AxisSolver for InCoreUnits<J> {
    #[inline]
    fn advance(
        &mut self,
        v: f64,
        duration_s: f64,
        friction: &friction::Coulomb,
        on: &mut impl FnMut(Event),
    ) {
        let brake_v = friction.slip - self.slip_v;
        if brake_v != self.braked_v {
            self.braked_v = brake_v;
            self.joint.set_brake(self.units.effort(brake_v));
        }
        self.joint.hold_and_report(self.units.effort(v), duration_s, on);
    }

    #[inline]
    fn position(&self) -> f64 {
        self.seen().position.to_degrees()
    }

    #[inline]
    fn measured_at_motor(&self) -> f64 {
        self.joint.motor().position.to_degrees()
    }

    #[inline]
    fn at_load(&self) -> f64 {
        self.joint.load().position.to_degrees()
    }

    #[inline]
    fn velocity(&self) -> f64 {
        self.seen().velocity.to_degrees()
    }

    #[inline]
    fn motor_velocity(&self) -> f64 {
        self.joint.motor().velocity.to_degrees()
    }

    #[inline]
    fn effort_left(&self) -> f64 {
        self.units.volts(self.joint.effort_left())
    }

    fn open_winding(&mut self, back_emf: f64) {
        self.joint.open_winding(self.units.effort(back_emf).to_degrees());
    }

    #[inline]
    fn stuck(&self) -> bool {
        self.joint.is_stuck()
    }

    /// Returns 0: the evaluations of a joint are not counted.
    fn derivative_evaluations(&self) -> u64 {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Body, Description, DiscSide, Train};
    use super::*;
    use crate::solver::ExactAxis;

    /// The thesis's axis, written in SI with an arbitrary gain, moves as the axis in degrees and
    /// volts, a brake that comes and goes included.
    #[test]
    fn a_joint_in_si_is_the_axis_in_degrees_and_volts() {
        let units = CoreUnits { effort_gain: 12.5 };
        let curve = StribeckCurve {
            coulomb: 0.38 * 12.5,
            stick: 0.5 * 12.5,
            stribeck_velocity: 0.0,
            viscous: 0.02 * 12.5 * 1.0_f64.to_degrees(),
        };
        let inertia = 12.5 * 1.0_f64.to_degrees() / 27.0;
        let axis = units.axis(inertia, &curve);
        assert!((axis.gain - 27.0).abs() < 1e-12 && (axis.viscous - 0.02).abs() < 1e-15);
        let body = Body { inertia, friction: curve.into() };
        let count = 0.00242_f64.to_radians();
        let joint = Description::of(Train::Rigid(body), count).build().unwrap();
        let mut seen = InCoreUnits::new(joint, units, DiscSide::Motor, &axis);
        let mut exact = ExactAxis::at_rest(&axis, 0.02);
        let mut farthest: f64 = 0.0;
        for sample in 0..2000 {
            let t = f64::from(sample) * 0.02;
            let volts = 1.2 * (0.9 * t).sin() + 0.7 * (3.1 * t).cos();
            let brake = if sample % 500 < 250 { 0.0 } else { 0.3 };
            let friction = axis.friction.raised(brake);
            seen.advance(volts, 0.02, &friction, &mut |_| {});
            exact.advance(volts, 0.02, &friction, &mut |_| {});
            assert!((seen.position() - exact.position()).abs() < 1e-3 * 0.00242);
            assert!((seen.velocity() - exact.velocity()).abs() < 1e-6);
            assert_eq!(seen.stuck(), exact.stuck());
            farthest = farthest.max(exact.position().abs());
        }
        assert!(farthest > 10.0);
    }
}
