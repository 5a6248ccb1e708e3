//! The equation of a step whose frictions are functions of the velocities at its end, each never
//! falling:
//!
//! ```text
//! M v + h F(v) = p
//! ```
//!
//! It has one solution. Newton's method finds it in a few turns where the frictions are nearly
//! linear; across their kinks it may cycle. Then a sweep of coordinate descent, which always comes
//! closer, is done between: one body at a time, the others fixed, which is the same equation in one
//! unknown with a bracket around its solution.
//!
//! Guarantees: each body's momentum is right to rounding, or the step has no solution here. Nothing
//! less is taken.

use super::dot;
use dynamics::solver::linear::solve as solve_linear;

/// Turns before it is given up.
const MAX_TURNS: u32 = 1000;

/// Rounding of a residual, relative to the sum of what it is computed from: some forty units of the
/// last place, of which the products and sums of a row and the friction's own formula take a few
/// each. If it always had the same sign it would add up to 1e-14/h of the momenta a second, 1e-9
/// with steps of 10 us, where the method's own error, of the order of h, is 1e-5.
const ROUNDING: f64 = 1e-14;

/// A friction in the equation.
#[derive(Clone, Copy, Debug)]
pub struct Reaction {
    /// Friction F(v), N or N m.
    pub force: f64,
    /// Slope of F over v.
    pub slope: f64,
    /// Typical magnitude of F: a force far below it counts as zero.
    pub scale: f64,
}

/// The velocities; `law(i, v)` is the friction of body i. None if they are not found.
pub fn solve<const N: usize>(
    mass: &[[f64; N]; N],
    momentum: &[f64; N],
    h: f64,
    law: impl Fn(usize, f64) -> Reaction,
    guess: &[f64; N],
) -> Option<[f64; N]> {
    let residual = |v: &[f64; N]| -> [f64; N] {
        std::array::from_fn(|i| momentum[i] - dot(&mass[i], v) - h * law(i, v[i]).force)
    };
    // What a residual is the difference of.
    let parts = |i: usize, v: &[f64; N]| -> f64 {
        let inertia: f64 = mass[i].iter().zip(v).map(|(m, v)| (m * v).abs()).sum();
        let reaction = law(i, v[i]);
        momentum[i].abs() + inertia + h * (reaction.force.abs() + reaction.scale)
    };
    // By how much the friction differs between the doubles next to v, kinks included: the solution
    // may be between them.
    let between = |i: usize, v: f64| h * (law(i, v.next_up()).force - law(i, v.next_down()).force);
    let size = |r: &[f64; N]| -> f64 { (0..N).map(|i| r[i] * r[i] / mass[i][i]).sum() };
    let mut v = *guess;
    let mut r = residual(&v);
    for _ in 0..MAX_TURNS {
        let solved = |i: usize| {
            let rounding = ROUNDING * parts(i, &v);
            r[i].abs() <= rounding || r[i].abs() <= rounding + between(i, v[i])
        };
        if (0..N).all(solved) {
            return Some(v);
        }
        let mut tangent = *mass;
        for i in 0..N {
            tangent[i][i] += h * law(i, v[i]).slope;
        }
        let step = solve_linear(&tangent, &r, &[false; N]);
        let newton: [f64; N] = std::array::from_fn(|i| v[i] + step[i]);
        let left = residual(&newton);
        if size(&left) < 0.25 * size(&r) {
            (v, r) = (newton, left);
            continue;
        }
        let before = v;
        for i in 0..N {
            let others = dot(&mass[i], &v) - mass[i][i] * v[i];
            v[i] = alone(mass[i][i], momentum[i] - others, h, |v| law(i, v), v[i]);
        }
        if v == before {
            // Nothing moves any more.
            return None;
        }
        r = residual(&v);
    }
    None
}

/// The solution of `mass v + h F(v) = momentum`. As the left side grows at least like `mass v`, it
/// is no farther from any v than the residual there over the mass.
fn alone(mass: f64, momentum: f64, h: f64, law: impl Fn(f64) -> Reaction, guess: f64) -> f64 {
    let mut v = guess;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for _ in 0..200 {
        let Reaction { force, slope, .. } = law(v);
        let r = momentum - mass * v - h * force;
        if r > 0.0 {
            (low, high) = (v, high.min(v + r / mass));
        } else {
            (low, high) = (low.max(v + r / mass), v);
        }
        let mut next = v + r / (mass + h * slope);
        if !(low < next && next < high) {
            next = 0.5 * (low + high);
        }
        if next == v || next == low || next == high || r == 0.0 {
            return v;
        }
        v = next;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steep steps, far apart from each other and strongly coupled: Newton alone cycles between
    /// their flanks.
    #[test]
    fn steep_steps_are_solved_to_rounding() {
        let mass = [[5.0, 2.0], [2.0, 1.0]];
        let law = |i: usize, v: f64| {
            let steep = [1e6, 1e9][i];
            let part = (steep * (v - 0.1)).clamp(-1.0, 1.0);
            Reaction { force: part, slope: if part.abs() < 1.0 { steep } else { 0.0 }, scale: 1.0 }
        };
        for (momentum, guess) in
            [([0.7, 0.3], [0.0; 2]), ([3.0, -1.0], [9.0; 2]), ([-1.0, 5.0], [-1e3, 1e3])]
        {
            let v = solve(&mass, &momentum, 1.0, law, &guess).unwrap();
            for i in 0..2 {
                let left = momentum[i] - dot(&mass[i], &v) - law(i, v[i]).force;
                // Two doubles with one between them are 2.78e-17 apart at v = 0.1: 2.78e-8 on a
                // slope of 1e9. The rounding of the rest is less than 1e-12.
                assert!(left.abs() < 2.8e-8, "{v:?} leaves {left:e} for {i}");
            }
        }
    }

    /// Free up to v = 0.1, steep from there: the doubles on both sides of the solution leave
    /// something, 5e-9 the one on the flat side, where by its slope none should be left, and
    /// 1.39e-8 less than that the other.
    #[test]
    fn a_solution_at_a_kink_between_two_doubles_is_one_of_the_two() {
        let law = |_, v: f64| {
            let (force, slope) = if v > 0.1 { (1e9 * (v - 0.1), 1e9) } else { (0.0, 0.0) };
            Reaction { force, slope, scale: 1.0 }
        };
        for guess in [0.0, 0.1, 0.1_f64.next_up(), 5.0] {
            let [v] = solve(&[[1.0]], &[0.1 + 5e-9], 1.0, law, &[guess]).unwrap();
            assert!(v == 0.1 || v == 0.1_f64.next_up(), "{v:?} from {guess}");
        }
    }
}
