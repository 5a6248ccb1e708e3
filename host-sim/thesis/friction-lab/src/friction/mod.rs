//! Friction models, one a file.
//!
//! Two kinds, because solvers must treat them differently:
//!
//! - [`SetValued`](dynamics::friction::SetValued): at rest the friction is whatever keeps the body at
//!   rest, within a limit; in motion it is a function of the speed. It has no value of its own at
//!   zero velocity: the mechanism and the solver find it there.
//! - [`SingleValued`]: velocity and `Z` internal states give a force and the rates of those states.
//!   It stands alone, and any solver of differential equations can run it.
//!
//! Karnopp's velocity band ([`crate::solver::banded`]) is neither: it is a way to compute a
//! set-valued model.

mod dahl;
mod elastic_coulomb;
mod lugre;
mod maxwell_slip;
mod reset_integrator;
mod stribeck;
mod tanh;

pub use dahl::Dahl;
pub use elastic_coulomb::ElasticCoulomb;
pub use lugre::LuGre;
pub use maxwell_slip::MaxwellSlip;
pub use reset_integrator::ResetIntegrator;
pub use stribeck::Stribeck;
pub use tanh::Tanh;

use dynamics::friction::Coulomb;

/// Friction as a function of velocity and `Z` states of its own.
///
/// A model that is smooth but for kinks needs `force`, `rate` and `slips` only. One with jumps
/// consists of pieces, each smooth: a solver that locates switches stays in a piece until one of
/// its `ends` falls through zero, and goes to `next`; one that does not asks for the `piece` at
/// every evaluation.
pub trait SingleValued<const Z: usize> {
    /// The friction, opposing positive velocities with a positive sign.
    fn force(&self, piece: u8, v: f64, z: &[f64; Z]) -> f64;

    /// The rates of the states.
    fn rate(&self, piece: u8, v: f64, z: &[f64; Z]) -> [f64; Z];

    /// Whether the body slips, for the list of events; a model without a sharp answer takes its
    /// nearest one.
    fn slips(&self, piece: u8, v: f64, z: &[f64; Z]) -> bool;

    /// The piece that velocity and states are in.
    fn piece(&self, v: f64, z: &[f64; Z]) -> u8 {
        let _ = (v, z);
        0
    }

    /// Two functions that are positive inside the piece; it ends where one of them falls through
    /// zero.
    fn ends(&self, piece: u8, v: f64, z: &[f64; Z]) -> [f64; 2] {
        let _ = (piece, v, z);
        [f64::INFINITY; 2]
    }

    /// The piece after the end number `end` of `piece`; may set states to what they are exactly
    /// there.
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

/// Friction with an implicit step of its own, for [`crate::solver::nonsmooth::run_implicit`]: over
/// a step of `h` from velocity `v` and states `z`, as a function of the velocity `v_end` at its
/// end.
pub trait Implicit<const Z: usize>: SingleValued<Z> {
    /// The friction at the end, which never falls with `v_end`, and its slope over `v_end`. What
    /// would make it fall, such as a level that does with velocity, is taken at `v`.
    fn friction(&self, h: f64, v: f64, z: &[f64; Z], v_end: f64) -> (f64, f64);

    /// What its forces are measured by: F_s, or F_c of a model without it. A force far below is
    /// nothing.
    fn largest(&self) -> f64;

    /// The states at the end.
    fn states(&self, h: f64, v: f64, z: &[f64; Z], v_end: f64) -> [f64; Z];
}

/// The speed at which a bristle of F_s at `range` throws a mass: `range omega = sqrt(F_s range /
/// mass)`. The rules for parameters that a user leaves out measure speeds by it.
fn bristle_speed(levels: Coulomb, range: f64, mass: f64) -> f64 {
    (levels.stick * range / mass).sqrt()
}

/// `sqrt(K m)`, half of the critical damping of a spring and a mass.
fn impedance(stiffness: f64, mass: f64) -> f64 {
    (stiffness * mass).sqrt()
}
