//! The stick problem of a step: the minimiser of a strictly convex function.
//!
//! ```text
//! minimise  1/2 v' M v - p' v + sum_i L_i |v_i|
//! ```
//!
//! Its condition is `p - M v` in `L_i Sgn(v_i)`: momenta p, impulses of friction of at most L_i = h
//! F_i. Coordinate descent,
//!
//! ```text
//! v_i = soft(p_i - sum_(j != i) M_ij v_j, L_i) / M_ii,    soft(x, L) = sgn(x) max(|x| - L, 0)
//! ```
//!
//! converges for every M that is symmetric and positive definite, with strong coupling slowly (by a
//! factor of 0.8 a sweep for the thesis's arm). But who sticks and who slips is settled long
//! before; so the linear system of that mode is tried first, and its solution is exact.

use super::dot;
use dynamics::solver::linear::solve;
use dynamics::solver::modes::BodyMode;

/// Sweeps before it is given up.
const MAX_SWEEPS: u32 = 10_000;

/// By how much rounding may take a stuck body's impulse beyond its limit.
const SLACK: f64 = 1e-12;

/// The minimiser; bodies with an infinite limit are held. `guess` is where the search starts.
pub fn minimise<const N: usize>(
    mass: &[[f64; N]; N],
    momentum: &[f64; N],
    limit: &[f64; N],
    guess: &[f64; N],
) -> Option<[f64; N]> {
    let mut v = *guess;
    for _ in 0..MAX_SWEEPS {
        let mode = v.map(super::super::dynamics::direction);
        if let Some(v) = in_mode(mass, momentum, limit, &mode) {
            return Some(v);
        }
        for i in 0..N {
            let others = dot(&mass[i], &v) - mass[i][i] * v[i];
            v[i] = soft(momentum[i] - others, limit[i]) / mass[i][i];
        }
    }
    None
}

/// The velocities if who sticks and who slips is known, or none if it is not so.
fn in_mode<const N: usize>(
    mass: &[[f64; N]; N],
    momentum: &[f64; N],
    limit: &[f64; N],
    mode: &BodyMode<N>,
) -> Option<[f64; N]> {
    let net = std::array::from_fn(|i| match mode[i] {
        0 => 0.0,
        sign => momentum[i] - f64::from(sign) * limit[i],
    });
    let v = solve(mass, &net, &mode.map(|sign| sign == 0));
    let right = (0..N).all(|i| match mode[i] {
        0 => (momentum[i] - dot(&mass[i], &v)).abs() <= limit[i] * (1.0 + SLACK),
        sign => f64::from(sign) * v[i] > 0.0,
    });
    right.then_some(v)
}

fn soft(x: f64, limit: f64) -> f64 {
    if x.abs() <= limit { 0.0 } else { x - limit.copysign(x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dense positive definite mass matrix, momenta and limits, from a fixed sequence.
    fn problem<const N: usize>(
        next: &mut impl FnMut() -> f64,
    ) -> ([[f64; N]; N], [f64; N], [f64; N]) {
        let root: [[f64; N]; N] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        let mass = std::array::from_fn(|i| {
            std::array::from_fn(|j| dot(&root[i], &root[j]) + if i == j { 0.05 } else { 0.0 })
        });
        (mass, std::array::from_fn(|_| next()), std::array::from_fn(|_| 1.2 * next().abs()))
    }

    /// By enumeration of all modes, of which exactly one is right.
    #[test]
    fn coordinate_descent_finds_what_enumeration_finds() {
        let mut seed = 1_u64;
        let mut next = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut stuck = [0; 5];
        for _ in 0..500 {
            let (mass, momentum, limit) = problem::<4>(&mut next);
            let consistent: Vec<[f64; 4]> = (0..81)
                .filter_map(|code: i32| {
                    let mode = std::array::from_fn(|i| (code / 3_i32.pow(i as u32) % 3 - 1) as i8);
                    in_mode(&mass, &momentum, &limit, &mode)
                })
                .collect();
            assert_eq!(consistent.len(), 1, "{consistent:?}");
            let found = minimise(&mass, &momentum, &limit, &[0.0; 4]).unwrap();
            let far = minimise(&mass, &momentum, &limit, &[1e3, -1e3, 1e3, -1e3]).unwrap();
            assert_eq!((found, far), (consistent[0], consistent[0]));
            stuck[found.iter().filter(|v| **v == 0.0).count()] += 1;
        }
        assert!(
            stuck.iter().all(|count| *count > 0),
            "every number of stuck bodies was tried: \
            {stuck:?}"
        );
    }

    /// The minimiser has no better neighbour: a check that knows nothing of modes.
    #[test]
    fn no_neighbour_of_the_minimiser_is_lower() {
        let mut seed = 7_u64;
        let mut next = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for _ in 0..100 {
            let (mass, momentum, limit) = problem::<3>(&mut next);
            let value = |v: &[f64; 3]| -> f64 {
                let sum = |i: usize| {
                    (0.5 * dot(&mass[i], v) - momentum[i]) * v[i] + limit[i] * v[i].abs()
                };
                (0..3).map(sum).sum()
            };
            let best = minimise(&mass, &momentum, &limit, &[0.0; 3]).unwrap();
            for _ in 0..100 {
                let away = std::array::from_fn(|i| best[i] + 1e-3 * next());
                assert!(value(&away) > value(&best), "{away:?} is below {best:?}");
            }
        }
    }
}
