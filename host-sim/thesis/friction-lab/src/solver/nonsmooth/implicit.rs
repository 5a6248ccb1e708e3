//! Friction with an implicit step of its own, in a step.

use super::super::dynamics::direction;
use super::Step;
use super::monotone::{self, Reaction};
use crate::friction::Implicit;

/// The frictions and their states.
pub struct ImplicitLaw<'a, const N: usize, const Z: usize, F> {
    friction: &'a [F; N],
    z: [[f64; Z]; N],
    slip: [i8; N],
}

impl<'a, const N: usize, const Z: usize, F: Implicit<Z>> ImplicitLaw<'a, N, Z, F> {
    /// All at rest, with no deflection.
    pub fn new(friction: &'a [F; N]) -> Self {
        Self { friction, z: [[0.0; Z]; N], slip: [0; N] }
    }
}

impl<const N: usize, const Z: usize, F: Implicit<Z>> super::ContactLaw<N>
    for ImplicitLaw<'_, N, Z, F>
{
    fn begin(&mut self, _: &[f64; N]) {}

    fn velocities(&mut self, step: &Step<N>, guess: &[f64; N]) -> Option<[f64; N]> {
        let law = |i: usize, v_end: f64| {
            let (force, slope) = self.friction[i].friction(step.h, step.v[i], &self.z[i], v_end);
            Reaction { force, slope, scale: self.friction[i].largest() }
        };
        monotone::solve(&step.mass, &step.momentum, step.h, law, guess)
    }

    fn keep(&mut self, step: &Step<N>, v_end: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| {
            let (law, v) = (&self.friction[i], v_end[i]);
            let (force, _) = law.friction(step.h, step.v[i], &self.z[i], v);
            self.z[i] = law.states(step.h, step.v[i], &self.z[i], v);
            let slips = law.slips(law.piece(v, &self.z[i]), v, &self.z[i]);
            self.slip[i] = if slips { direction(v) } else { 0 };
            force
        })
    }

    fn at_rest(&self, _: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| self.friction[i].force(0, 0.0, &self.z[i]))
    }

    fn slip(&self) -> [i8; N] {
        self.slip
    }

    fn deflections(&self) -> [f64; N] {
        self.z.map(|z| z.first().copied().unwrap_or(0.0))
    }
}
