//! Mechanisms: what friction acts on.
//!
//! A mechanism has `N` coordinates and is in SI. It says what multiplies its
//! accelerations and what drives them; friction and the way of solving come from elsewhere:
//!
//! ```text
//! M(q) q'' = f(t, q, q') - friction
//! ```
//!
//! The coordinates are chosen so that each friction acts on exactly one of them: a joint's angle
//! relative to the link before it, a block's position relative to what it slides on. The friction
//! lab of the thesis has more mechanisms.
//!
//! The robot's axis is apart: one degree of freedom in degrees and volts, with solvers of its own.

mod robot_axis;
mod two_link_arm;

pub use robot_axis::RobotAxis;
pub use two_link_arm::TwoLinkArm;

/// Acceleration of gravity, m/s^2.
pub const GRAVITY: f64 = 9.81;

/// What a mechanism is at one instant: `mass * q'' = force - friction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms<const N: usize> {
    /// M(q), symmetric and positive definite.
    pub mass: [[f64; N]; N],
    /// Everything but inertia and friction: drives, springs, gravity, centrifugal and Coriolis
    /// terms.
    pub force: [f64; N],
}

/// A mechanism with `N` coordinates, on each of which one friction acts.
pub trait Mechanism<const N: usize> {
    /// Mass matrix and forces. Smooth in all arguments, but for the corners in time that
    /// [`Self::next_corner`] names.
    fn terms(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> Terms<N>;

    /// The first instant after `t` at which the forces jump or bend, s; infinite if there is none.
    /// At a jump the force at that very instant is the one after it.
    fn next_corner(&self, t: f64) -> f64 {
        let _ = t;
        f64::INFINITY
    }

    /// Where it starts, at rest.
    fn start(&self) -> [f64; N] {
        [0.0; N]
    }

    /// Positions (or velocities) of the bodies as a reader expects them, from those of the
    /// coordinates. Linear.
    fn bodies(&self, coordinates: &[f64; N]) -> [f64; N] {
        *coordinates
    }
}
