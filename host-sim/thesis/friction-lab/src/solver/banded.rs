//! Karnopp's friction as the thesis has it: with a band of velocities that counts as rest.
//!
//! ```text
//! F_f = F_d sgn(V)          |V| >  D_v
//!     = F_i                 |V| <= D_v and |F_i| <= F_s
//!     = F_s sgn(F_i)        |V| <= D_v and |F_i| >  F_s        (eq. 1, whose third row prints sgn(V))
//! ```
//!
//! Inside the band friction balances the applied force and V is *not* set to zero: the body coasts
//! at up to `D_v` (section 2.3.1.2 says so). The solution tends to the exact one with `D_v`, under
//! ramps of force only like its root.
//!
//! With several bodies the force that friction must balance depends on what the others do. Three
//! ways ([`BandCoupling`]): decide all bodies in their bands at once; or as if each other body in
//! its band did not accelerate (eqs. 18-21, with the limit on the required value and `D_1`, `D_2`
//! for the `D_11`, `D_22` that eq. 20 has in brackets); or with all accelerations of the step
//! before (eqs. 22-25). The last as printed: the joint's own acceleration is among them, so that
//! the last acceleration is kept up and not cancelled.

use super::dynamics::{Dynamics, StateRates, direction, floor};
use super::state::BodyState;
use dynamics::friction::Coulomb;
use dynamics::mechanism::{Mechanism, Terms};
use dynamics::solver::linear::solve;

/// How the frictions of several bodies depend on each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BandCoupling {
    /// All bodies at rest are decided at once.
    #[default]
    Simultaneous,
    /// Thesis eqs. 18-21: accelerations of other bodies at rest are neglected.
    Neglected,
    /// Thesis eqs. 22-25: accelerations are those of the step before.
    PreviousStep,
}

/// A mechanism with banded Karnopp friction.
#[derive(Clone, Debug)]
pub struct Banded<'a, const N: usize, M: ?Sized> {
    /// The mechanism.
    pub mechanism: &'a M,
    /// F_s and F_d of each coordinate.
    pub levels: [Coulomb; N],
    /// D_v of each coordinate.
    pub band: [f64; N],
    /// How they depend on each other.
    pub coupling: BandCoupling,
    /// Accelerations at the last step that was kept.
    previous: [f64; N],
}

impl<'a, const N: usize, M: Mechanism<N> + ?Sized> Banded<'a, N, M> {
    /// At rest.
    pub fn new(
        mechanism: &'a M,
        levels: [Coulomb; N],
        band: [f64; N],
        coupling: BandCoupling,
    ) -> Self {
        Self { mechanism, levels, band, coupling, previous: [0.0; N] }
    }

    fn resting(&self, v: &[f64; N]) -> [bool; N] {
        std::array::from_fn(|i| v[i].abs() <= self.band[i])
    }

    /// The frictions at a state.
    fn frictions(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        terms: &Terms<N>,
        rests: &[bool; N],
    ) -> [f64; N] {
        let sliding = |i: usize| self.levels[i].slip * f64::from(direction(v[i]));
        if !rests.contains(&true) {
            return std::array::from_fn(sliding);
        }
        if self.coupling == BandCoupling::Simultaneous {
            let known: [f64; N] = std::array::from_fn(|i| if rests[i] { 0.0 } else { sliding(i) });
            return self.at_once(terms, &known, rests);
        }
        // The bodies at rest have no velocity in eqs. 18-25.
        let still = std::array::from_fn(|i| if rests[i] { 0.0 } else { v[i] });
        let terms = Terms { force: self.mechanism.terms(t, q, &still).force, ..*terms };
        let mut a = self.previous;
        if self.coupling == BandCoupling::Neglected {
            let net = std::array::from_fn(|i| terms.force[i] - sliding(i));
            a = solve(&terms.mass, &net, rests);
        }
        std::array::from_fn(|i| {
            if !rests[i] {
                return sliding(i);
            }
            let kick: f64 = terms.mass[i].iter().zip(&a).map(|(m, a)| m * a).sum();
            (terms.force[i] - kick).clamp(-self.levels[i].stick, self.levels[i].stick)
        })
    }

    /// The frictions of all bodies at rest, each within F_s and, where it is at F_s, against its
    /// acceleration: the one solution of a convex problem, found among the `3^n` modes.
    fn at_once(&self, terms: &Terms<N>, known: &[f64; N], rests: &[bool; N]) -> [f64; N] {
        let count = rests.iter().filter(|rests| **rests).count();
        let mut best = (f64::INFINITY, *known);
        for code in 0..3_usize.pow(count as u32) {
            let (mut code, mut friction, mut held) = (code, *known, [false; N]);
            for i in 0..N {
                if rests[i] {
                    held[i] = code % 3 == 0;
                    friction[i] = [0.0, 1.0, -1.0][code % 3] * self.levels[i].stick;
                    code /= 3;
                }
            }
            let net = std::array::from_fn(|i| terms.force[i] - friction[i]);
            let a = solve(&terms.mass, &net, &held);
            // By how much the mode is wrong: rounding apart, only the right one is not.
            let mut wrong = 0.0_f64;
            for i in 0..N {
                if held[i] {
                    let kick: f64 = terms.mass[i].iter().zip(&a).map(|(m, a)| m * a).sum();
                    friction[i] = terms.force[i] - kick;
                    wrong = wrong.max(friction[i].abs() - self.levels[i].stick);
                } else if rests[i] {
                    wrong = wrong.max(-a[i] * friction[i].signum() * terms.mass[i][i]);
                }
            }
            if wrong < best.0 {
                best = (wrong, friction);
            }
        }
        best.1
    }
}

impl<const N: usize, M: Mechanism<N> + ?Sized> Dynamics<N, 0> for Banded<'_, N, M> {
    fn start(&self) -> BodyState<N, 0> {
        BodyState { q: self.mechanism.start(), ..BodyState::ZERO }
    }

    fn evaluate(&self, t: f64, state: &BodyState<N, 0>) -> StateRates<N, 0> {
        let terms = self.mechanism.terms(t, &state.q, &state.v);
        let friction = self.frictions(t, &state.q, &state.v, &terms, &self.resting(&state.v));
        let net = std::array::from_fn(|i| terms.force[i] - friction[i]);
        let a = solve(&terms.mass, &net, &[false; N]);
        StateRates { rates: BodyState { q: state.v, v: a, z: [[]; N] }, friction }
    }

    fn slip(&self, state: &BodyState<N, 0>) -> [i8; N] {
        let rests = self.resting(&state.v);
        std::array::from_fn(|i| if rests[i] { 0 } else { direction(state.v[i]) })
    }

    fn next_corner(&self, t: f64) -> f64 {
        self.mechanism.next_corner(t)
    }

    fn scale(&self) -> BodyState<N, 0> {
        floor()
    }

    fn accepted(&mut self, _: &mut BodyState<N, 0>, rates: &StateRates<N, 0>) {
        self.previous = rates.rates.v;
    }
}
