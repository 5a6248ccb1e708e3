//! Set-valued friction in a step: limits for the convex problem.

use super::super::dynamics::direction;
use super::{Step, convex, dot};
use dynamics::friction::SetValued;
use dynamics::solver::modes::BodyMode;

/// What is known of a body in a step. A body at rest may start, one that moves may be held or
/// start, and that is all: a step is decided after finitely many changes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    /// At rest: friction up to F_s.
    Rests,
    /// Moving, with the friction of its speed at the begin.
    Moves,
    /// Came to zero velocity, and stays.
    Held,
    /// Breaking away, or reversing without rest: the friction of speed zero.
    Starts,
}

/// Who slips, and what a step has decided so far.
pub struct SetValuedLaw<'a, const N: usize, F> {
    friction: &'a [F; N],
    slip: BodyMode<N>,
    bodies: [Body; N],
    speeds: [f64; N],
}

impl<'a, const N: usize, F: SetValued> SetValuedLaw<'a, N, F> {
    /// All at rest.
    pub fn new(friction: &'a [F; N]) -> Self {
        Self { friction, slip: [0; N], bodies: [Body::Rests; N], speeds: [0.0; N] }
    }

    fn limit(&self, i: usize) -> f64 {
        match self.bodies[i] {
            Body::Rests => self.friction[i].stick(),
            Body::Moves => self.friction[i].slip(self.speeds[i]),
            Body::Starts => self.friction[i].slip(0.0),
            Body::Held => f64::INFINITY,
        }
    }

    fn impulses(&self, h: f64) -> [f64; N] {
        std::array::from_fn(|i| h * self.limit(i))
    }

    /// Whether body `i`, which has come to zero velocity, would stay there: 0, or the way it would
    /// go. Asked of a step in which it is at rest from the begin, as its own deceleration drives
    /// the others.
    fn leaves(&self, step: &Step<N>, i: usize, guess: &[f64; N]) -> Option<i8> {
        let momentum = std::array::from_fn(|j| step.momentum[j] - step.mass[j][i] * step.v[i]);
        let mut limits = self.impulses(step.h);
        limits[i] = f64::INFINITY;
        let v = convex::minimise(&step.mass, &momentum, &limits, guess)?;
        let holding = (momentum[i] - dot(&step.mass[i], &v)) / step.h;
        Some(if holding.abs() > self.friction[i].stick() { direction(holding) } else { 0 })
    }

    /// Whether velocities decide something that was open.
    fn decides(&mut self, step: &Step<N>, v_end: &[f64; N]) -> Option<bool> {
        let before = self.bodies;
        for i in 0..N {
            match self.bodies[i] {
                Body::Rests if v_end[i] != 0.0 => self.bodies[i] = Body::Starts,
                Body::Moves if v_end[i] * step.v[i] <= 0.0 => {
                    let stays = self.leaves(step, i, v_end)? == 0;
                    self.bodies[i] = if stays { Body::Held } else { Body::Starts };
                }
                _ => {}
            }
        }
        Some(self.bodies != before)
    }
}

impl<const N: usize, F: SetValued> super::ContactLaw<N> for SetValuedLaw<'_, N, F> {
    fn begin(&mut self, v: &[f64; N]) {
        self.speeds = v.map(f64::abs);
        self.bodies = std::array::from_fn(|i| match (self.slip[i], v[i] == 0.0) {
            (0, _) => Body::Rests,
            // It passes through zero on its way back.
            (_, true) => Body::Starts,
            (_, false) => Body::Moves,
        });
    }

    fn velocities(&mut self, step: &Step<N>, guess: &[f64; N]) -> Option<[f64; N]> {
        loop {
            let v_end =
                convex::minimise(&step.mass, &step.momentum, &self.impulses(step.h), guess)?;
            if !self.decides(step, &v_end)? {
                return Some(v_end);
            }
        }
    }

    fn keep(&mut self, step: &Step<N>, v_end: &[f64; N]) -> [f64; N] {
        let ways = v_end.map(direction);
        self.slip = std::array::from_fn(|i| match (ways[i], self.bodies[i]) {
            (0, Body::Starts) => self.leaves(step, i, v_end).unwrap_or(0),
            (sign, _) => sign,
        });
        std::array::from_fn(|i| (step.momentum[i] - dot(&step.mass[i], v_end)) / step.h)
    }

    fn at_rest(&self, force: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| force[i].clamp(-self.friction[i].stick(), self.friction[i].stick()))
    }

    fn slip(&self) -> [i8; N] {
        self.slip
    }
}
