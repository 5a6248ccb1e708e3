//! Mechanisms on which friction acts.
//!
//! A mechanism has `N` coordinates and is in SI. It defines its mass matrix and the forces on it;
//! friction and solver are separate:
//!
//! ```text
//! M(q) q'' = f(t, q, q') - friction
//! ```
//!
//! The coordinates are chosen so that each friction acts on exactly one of them: a joint's angle
//! relative to the link before it, a block's position relative to what it slides on. The friction
//! lab of the thesis has more mechanisms.
//!
//! The robot's axis is separate: one degree of freedom in degrees and volts, with its own solvers.

mod robot_axis;
mod two_link_arm;

pub use robot_axis::RobotAxis;
pub use two_link_arm::TwoLinkArm;

/// Acceleration of gravity, m/s^2.
pub const GRAVITY: f64 = 9.81;

/// Mass matrix and forces of a mechanism at one instant: `mass * q'' = force - friction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms<const N: usize> {
    /// Mass matrix M(q), symmetric and positive definite.
    pub mass: [[f64; N]; N],
    /// All forces except inertia and friction: drives, springs, gravity, centrifugal and Coriolis
    /// terms.
    pub force: [f64; N],
}

/// A mechanism with `N` coordinates, on each of which one friction acts.
pub trait Mechanism<const N: usize> {
    /// Returns mass matrix and forces. They are smooth in all arguments, except at the corners in
    /// time that [`Self::next_corner`] returns.
    fn terms(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> Terms<N>;

    /// Returns the first instant after `t` at which the forces jump or bend, s; infinity if there
    /// is none. At the instant of a jump, the force is that after it.
    fn next_corner(&self, t: f64) -> f64 {
        let _ = t;
        f64::INFINITY
    }

    /// Returns the coordinates at the start; the mechanism starts at rest.
    fn start(&self) -> [f64; N] {
        [0.0; N]
    }

    /// Converts coordinates to positions of the bodies, or their rates to velocities, for output.
    /// The conversion is linear.
    fn bodies(&self, coordinates: &[f64; N]) -> [f64; N] {
        *coordinates
    }
}
