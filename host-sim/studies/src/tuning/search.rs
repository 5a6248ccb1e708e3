//! Searches the gains of least cost with Nelder and Mead's simplex ("A simplex method for function
//! minimization", *The Computer Journal* 7, 1965) of the crate `argmin`, over the logarithms of the
//! gains.
//!
//! A step of a logarithm is a factor on the gain. The cost has edges where a joint fails or a count
//! is crossed; it has no gradient there, and the method needs none. Guarantees: the same numbers on
//! any number of cores, since a seed fixes the joints. Limits: the search finds a valley near its
//! start, not the lowest one.

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;

use files::error::Error;

/// Factor on each gain in the first simplex.
const FACTOR: f64 = 1.6;

/// Largest factor between a gain and its start value, up or down.
pub const WIDEST: f64 = 16.0;

/// Largest number of steps of the simplex: a base, and an addition for each gain.
const STEPS: [u64; 2] = [12, 12];

/// Standard deviation of the cost over the simplex below which the search ends: 0.1 % of a figure.
const SAME: f64 = 1e-3;

struct Problem<'a>(&'a (dyn Fn(&[f64]) -> f64 + Sync));

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let widest = WIDEST.ln();
        let beyond: f64 = logs.iter().map(|log| (log.abs() - widest).max(0.0)).sum();
        let within: Vec<f64> = logs.iter().map(|log| log.clamp(-widest, widest).exp()).collect();
        // Outside of the range a penalty is added.
        Ok((self.0)(&within) + 100.0 * beyond)
    }
}

/// Returns the approximate number of costs that [`least`] evaluates: those of the first simplex,
/// and two for each step. The search can end sooner; a step that shrinks the simplex evaluates one
/// more for each gain.
pub const fn about(gains: usize) -> u64 {
    let gains = gains as u64;
    let [base, each] = STEPS;
    1 + gains + 2 * (base + each * gains)
}

/// Returns the factors on `gains` gains with the least `cost`. The search starts with factors of 1.
///
/// # Errors
/// Returns the error of the method.
pub fn least(gains: usize, cost: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Vec<f64>, Error> {
    let begin = vec![0.0; gains];
    let corner = |place: usize| {
        let mut corner = begin.clone();
        if let Some(log) = corner.get_mut(place) {
            *log = FACTOR.ln();
        }
        corner
    };
    let simplex = std::iter::once(begin.clone()).chain((0..gains).map(corner)).collect();
    let failed = |error: argmin::core::Error| Error::Input(format!("the search: {error}"));
    let solver = NelderMead::new(simplex).with_sd_tolerance(SAME).map_err(failed)?;
    let [base, each] = STEPS;
    let found = Executor::new(Problem(cost), solver)
        .configure(|state| state.max_iters(base + each * gains as u64))
        .run()
        .map_err(failed)?;
    let widest = WIDEST.ln();
    let best = found.state.best_param.unwrap_or(begin);
    Ok(best.into_iter().map(|log| log.clamp(-widest, widest).exp()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_bottom_of_a_bowl_in_logarithms_and_the_same_one_again() {
        let bowl = |factors: &[f64]| {
            let to = [3.0_f64, 0.5];
            factors.iter().zip(to).map(|(factor, to)| (factor / to).ln().powi(2)).sum()
        };
        let found = least(2, &bowl).unwrap();
        assert!(
            (found[0] / 3.0).ln().abs() < 0.1 && (found[1] / 0.5).ln().abs() < 0.1,
            "{found:?}"
        );
        assert_eq!(found, least(2, &bowl).unwrap());
    }

    #[test]
    fn it_stays_within_its_widest_factor() {
        let found = least(1, &|factors| -factors[0]).unwrap();
        assert!(found[0] <= WIDEST * (1.0 + 1e-9) && found[0] > 8.0, "{found:?}");
    }
}
