//! Dense output: the motion inside of a step, as polynomials between its two ends.
// One index goes through several arrays of bodies at once.
#![allow(clippy::needless_range_loop)]

use super::state::BodyState;
use dynamics::solver::roots::{Quartic, value};

/// A step between its two ends, in parts of its length.
pub struct DenseOutput<const N: usize> {
    /// Length of the step.
    pub h: f64,
    q0: [f64; N],
    /// Velocities.
    pub v: [Quartic; N],
}

impl<const N: usize> DenseOutput<N> {
    /// From positions, velocities and accelerations at both ends.
    pub fn new(h: f64, (q0, v0, a0): Instant<'_, N>, (q1, v1, a1): Instant<'_, N>) -> Self {
        let v = std::array::from_fn(|i| {
            // Cubic Hermite from velocities and accelerations, and a fourth power that makes the
            // way right.
            let rise = v1[i] - v0[i];
            let (c2, c3) =
                (3.0 * rise - h * (2.0 * a0[i] + a1[i]), h * (a0[i] + a1[i]) - 2.0 * rise);
            let way = (q1[i] - q0[i]) / h - 0.5 * (v0[i] + v1[i]) - h * (a0[i] - a1[i]) / 12.0;
            // In a short step the way is lost in the rounding of the positions.
            let rounding = 1e3 * f64::EPSILON * (q0[i].abs() + q1[i].abs()) / h;
            let bump = if way.abs() > rounding { 30.0 * way } else { 0.0 };
            [v0[i], h * a0[i], c2 + bump, c3 - 2.0 * bump, bump]
        });
        Self { h, q0: *q0, v }
    }

    /// Positions and velocities after a part of the step.
    pub fn at(&self, part: f64) -> ([f64; N], [f64; N]) {
        let q = std::array::from_fn(|i| {
            let p = &self.v[i];
            let mean = p[0]
                + part
                    * (p[1] / 2.0 + part * (p[2] / 3.0 + part * (p[3] / 4.0 + part * p[4] / 5.0)));
            self.q0[i] + self.h * part * mean
        });
        (q, std::array::from_fn(|i| value(&self.v[i], part)))
    }
}

/// Positions, velocities and accelerations.
type Instant<'a, const N: usize> = (&'a [f64; N], &'a [f64; N], &'a [f64; N]);

/// The state after a part of a step of `h`, from states and their rates at both ends.
pub fn state_between<const N: usize, const Z: usize>(
    h: f64,
    (from, from_rates): (&BodyState<N, Z>, &BodyState<N, Z>),
    (to, to_rates): (&BodyState<N, Z>, &BodyState<N, Z>),
    part: f64,
) -> BodyState<N, Z> {
    let begin = (&from.q, &from.v, &from_rates.v);
    let (q, v) = DenseOutput::new(h, begin, (&to.q, &to.v, &to_rates.v)).at(part);
    let mut z = from.z;
    for i in 0..N {
        for j in 0..Z {
            let (z0, z1) = (from.z[i][j], to.z[i][j]);
            let (r0, r1) = (h * from_rates.z[i][j], h * to_rates.z[i][j]);
            let (c2, c3) = (3.0 * (z1 - z0) - 2.0 * r0 - r1, r0 + r1 - 2.0 * (z1 - z0));
            z[i][j] = z0 + part * (r0 + part * (c2 + part * c3));
        }
    }
    BodyState { q, v, z }
}
