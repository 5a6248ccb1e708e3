//! Interface for solvers without located events: rates of a state, and slipping bodies.

pub use dynamics::solver::modes::direction;

use super::state::BodyState;
use crate::friction::SingleValued;
use dynamics::mechanism::Mechanism;

/// What positions and velocities are measured by near zero, in SI: the size of the thesis's own D_v
/// and p_o.
pub const FLOOR: f64 = 1e-5;

/// The floor of coordinates and velocities.
pub fn floor<const N: usize, const Z: usize>() -> BodyState<N, Z> {
    BodyState { q: [FLOOR; N], v: [FLOOR; N], z: [[FLOOR; Z]; N] }
}

/// Rates of a state, with its frictions.
#[derive(Clone, Copy, Debug)]
pub struct StateRates<const N: usize, const Z: usize> {
    /// Velocities, accelerations, rates of the frictions' states.
    pub rates: BodyState<N, Z>,
    /// Frictions.
    pub friction: [f64; N],
}

/// A mechanism and its frictions as one differential equation.
pub trait Dynamics<const N: usize, const Z: usize> {
    /// The state at time zero.
    fn start(&self) -> BodyState<N, Z>;

    /// The rates at a time and state.
    fn evaluate(&self, t: f64, state: &BodyState<N, Z>) -> StateRates<N, Z>;

    /// 0 where a body sticks, else the sign of its slip.
    fn slip(&self, state: &BodyState<N, Z>) -> [i8; N];

    /// The first instant after `t` at which the forces jump or bend, s.
    fn next_corner(&self, t: f64) -> f64;

    /// Errors far below these do not matter (see [`super::step_doubling`]).
    fn scale(&self) -> BodyState<N, Z>;

    /// Called after each accepted step; can limit states to their range.
    fn accepted(&mut self, state: &mut BodyState<N, Z>, rates: &StateRates<N, Z>) {
        let _ = (state, rates);
    }
}

/// A mechanism with single-valued frictions.
#[derive(Clone, Debug)]
pub struct SingleValuedDynamics<'a, const N: usize, M: ?Sized, F> {
    /// The mechanism.
    pub mechanism: &'a M,
    /// The friction of each coordinate.
    pub friction: [F; N],
}

impl<const N: usize, const Z: usize, M, F> Dynamics<N, Z> for SingleValuedDynamics<'_, N, M, F>
where
    M: Mechanism<N> + ?Sized,
    F: SingleValued<Z>,
{
    fn start(&self) -> BodyState<N, Z> {
        BodyState { q: self.mechanism.start(), ..BodyState::ZERO }
    }

    fn evaluate(&self, t: f64, state: &BodyState<N, Z>) -> StateRates<N, Z> {
        let pieces = std::array::from_fn(|i| self.friction[i].piece(state.v[i], &state.z[i]));
        rates_in(self.mechanism, &self.friction, &pieces, t, state)
    }

    fn slip(&self, state: &BodyState<N, Z>) -> [i8; N] {
        std::array::from_fn(|i| {
            let (v, z) = (state.v[i], &state.z[i]);
            let slips = self.friction[i].slips(self.friction[i].piece(v, z), v, z);
            if slips { direction(v) } else { 0 }
        })
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.mechanism.next_corner(t)
    }

    fn scale(&self) -> BodyState<N, Z> {
        BodyState { z: std::array::from_fn(|i| self.friction[i].state_scale()), ..floor() }
    }

    fn accepted(&mut self, state: &mut BodyState<N, Z>, _: &StateRates<N, Z>) {
        for (friction, z) in self.friction.iter().zip(&mut state.z) {
            friction.settle(z);
        }
    }
}

/// The rates of a mechanism whose frictions are each in a piece.
#[inline]
pub fn rates_in<const N: usize, const Z: usize, M: Mechanism<N> + ?Sized, F: SingleValued<Z>>(
    mechanism: &M,
    friction: &[F; N],
    pieces: &[u8; N],
    t: f64,
    state: &BodyState<N, Z>,
) -> StateRates<N, Z> {
    let terms = mechanism.terms(t, &state.q, &state.v);
    let mut force = terms.force;
    let mut forces = [0.0; N];
    let mut z = [[0.0; Z]; N];
    for i in 0..N {
        forces[i] = friction[i].force(pieces[i], state.v[i], &state.z[i]);
        z[i] = friction[i].rate(pieces[i], state.v[i], &state.z[i]);
        force[i] -= forces[i];
    }
    let a = dynamics::solver::linear::solve(&terms.mass, &force, &[false; N]);
    StateRates { rates: BodyState { q: state.v, v: a, z }, friction: forces }
}
