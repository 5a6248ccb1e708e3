//! One step of the Runge-Kutta pair of order 5(4) by Dormand and Prince (J. Comput. Appl. Math. 6,
//! 1980), with seven stages, the last of which is the first of the next step.
//!
//! Within a sample a joint needs one step or a few; this pair is then cheaper than that of order 8,
//! which the friction lab uses for long stretches (`solver/dormand_prince.rs`).

/// Times of the stages, as parts of the step.
pub const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// Weights of the stages in each other.
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Order 5 minus order 4.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Result of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepAttempt<const N: usize> {
    /// State at the end of the step.
    pub end: [f64; N],
    /// Rate at the end of the step.
    pub rate: [f64; N],
    /// Estimated error.
    pub error: [f64; N],
}

/// Makes a step of `h` from `y`, where the rate is `first`. The first argument of `rate` is the
/// number of the stage; [`NODES`] has its time.
#[inline(always)]
pub fn attempt<const N: usize>(
    rate: impl Fn(usize, &[f64; N]) -> [f64; N],
    y: &[f64; N],
    first: &[f64; N],
    h: f64,
) -> StepAttempt<N> {
    let mut stages = [[0.0; N]; 7];
    stages[0] = *first;
    let mut end = *y;
    for stage in 1..7 {
        for i in 0..N {
            let mut sum = 0.0;
            for (before, weight) in A[stage][..stage].iter().enumerate() {
                sum += weight * stages[before][i];
            }
            end[i] = y[i] + h * sum;
        }
        stages[stage] = rate(stage, &end);
    }
    let error = std::array::from_fn(|i| {
        h * stages.iter().zip(&ERROR).map(|(stage, weight)| weight * stage[i]).sum::<f64>()
    });
    StepAttempt { end, rate: stages[6], error }
}

/// Returns the ratio of the next step to this one, for an error as a part of the allowed error.
pub fn growth(error: f64) -> f64 {
    // An error that is not a number shortens the step most.
    if error > 0.0 {
        (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0)
    } else if error == 0.0 {
        5.0
    } else {
        0.2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `y' = y cos t` has the solution `exp(sin t)`: the error of a step falls like h^6, that of
    /// the estimate like h^5.
    #[test]
    fn a_step_is_of_order_five_and_its_error_estimate_of_order_four() {
        let step = |h: f64| {
            let rate = |stage: usize, y: &[f64; 1]| [y[0] * (NODES[stage] * h).cos()];
            let attempt = attempt(rate, &[1.0], &[1.0], h);
            [attempt.end[0] - h.sin().exp(), attempt.error[0]]
        };
        let (coarse, fine) = (step(0.2), step(0.1));
        let orders = [0, 1].map(|i| (coarse[i] / fine[i]).abs().log2());
        assert!((5.5..6.7).contains(&orders[0]) && (4.5..5.7).contains(&orders[1]), "{orders:?}");
    }
}
