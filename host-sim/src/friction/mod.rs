//! Friction models, one a file.
//!
//! Two kinds, because solvers must treat them differently:
//!
//! - [`SetValued`]: at rest the friction is whatever keeps the body at rest, within a limit; in motion it is a function
//!   of the speed. It has no value of its own at zero velocity: the mechanism and the solver find it there.
//! - [`SingleValued`]: velocity and `Z` internal states give a force and the rates of those states. It stands alone, and
//!   any solver of differential equations can run it.
//!
//! Karnopp's velocity band ([`crate::solver::banded`]) is neither: it is a way to compute a set-valued model.

mod coulomb;
mod reset_integrator;

pub use coulomb::{AddedFriction, Coulomb};
pub use reset_integrator::ResetIntegrator;

/// Friction that holds a body at rest up to a limit.
pub trait SetValued {
    /// Largest friction at rest F_s.
    fn stick(&self) -> f64;

    /// Friction in motion at a `speed` >= 0, its limit from above at zero included. Not above [`Self::stick`].
    fn slip(&self, speed: f64) -> f64;
}

/// Friction as a function of velocity and `Z` states of its own.
///
/// A model that is smooth but for kinks needs `force`, `rate` and `slips` only. One with jumps consists of pieces, each
/// smooth: a solver that locates switches stays in a piece until one of its `ends` falls through zero, and goes to `next`;
/// one that does not asks for the `piece` at every evaluation.
pub trait SingleValued<const Z: usize> {
    /// The friction, opposing positive velocities with a positive sign.
    fn force(&self, piece: u8, v: f64, z: &[f64; Z]) -> f64;

    /// The rates of the states.
    fn rate(&self, piece: u8, v: f64, z: &[f64; Z]) -> [f64; Z];

    /// Whether the body slips, for the list of events; a model without a sharp answer takes its nearest one.
    fn slips(&self, piece: u8, v: f64, z: &[f64; Z]) -> bool;

    /// The piece that velocity and states are in.
    fn piece(&self, v: f64, z: &[f64; Z]) -> u8 {
        let _ = (v, z);
        0
    }

    /// Two functions that are positive inside the piece; it ends where one of them falls through zero.
    fn ends(&self, piece: u8, v: f64, z: &[f64; Z]) -> [f64; 2] {
        let _ = (piece, v, z);
        [f64::INFINITY; 2]
    }

    /// The piece after the end number `end` of `piece`; may set states to what they are exactly there.
    fn next(&self, piece: u8, end: usize, v: f64, z: &mut [f64; Z]) -> u8 {
        let _ = (end, v, z);
        piece
    }

    /// Puts states back into their range after a step that did not locate its end.
    fn settle(&self, z: &mut [f64; Z]) {
        let _ = z;
    }

    /// What a state is measured by, for error control: errors far below it do not matter.
    fn state_scale(&self) -> [f64; Z];
}
