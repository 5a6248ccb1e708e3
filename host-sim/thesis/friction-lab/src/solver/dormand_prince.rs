//! One step of the Runge-Kutta pair of order 8(5,3) by Dormand and Prince, with twelve stages.
//!
//! Prince and Dormand, J. Comput. Appl. Math. 7 (1981), in the form of Hairer, Norsett and Wanner,
//! *Solving Ordinary Differential Equations I*, section II.10, whose error estimate combines one of
//! order 5 and one of order 3. Orders and the sums of the rows are tested below.

use super::state::BodyState;

/// Times of the stages as parts of the step.
const C: [f64; 12] = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
];

/// Weights of the stages in each other: (stage, weight).
const A2: [(usize, f64); 1] = [(0, 0.05260015195876773)];
const A3: [(usize, f64); 2] = [(0, 0.0197250569845379), (1, 0.0591751709536137)];
const A4: [(usize, f64); 2] = [(0, 0.02958758547680685), (2, 0.08876275643042054)];
const A5: [(usize, f64); 3] =
    [(0, 0.2413651341592667), (2, -0.8845494793282861), (3, 0.924834003261792)];
const A6: [(usize, f64); 3] =
    [(0, 0.037037037037037035), (3, 0.17082860872947386), (4, 0.12546768756682242)];
const A7: [(usize, f64); 4] =
    [(0, 0.037109375), (3, 0.17025221101954405), (4, 0.06021653898045596), (5, -0.017578125)];
const A8: [(usize, f64); 5] = [
    (0, 0.03709200011850479),
    (3, 0.17038392571223998),
    (4, 0.10726203044637328),
    (5, -0.015319437748624402),
    (6, 0.008273789163814023),
];
const A9: [(usize, f64); 6] = [
    (0, 0.6241109587160757),
    (3, -3.3608926294469414),
    (4, -0.868219346841726),
    (5, 27.59209969944671),
    (6, 20.154067550477894),
    (7, -43.48988418106996),
];
const A10: [(usize, f64); 7] = [
    (0, 0.47766253643826434),
    (3, -2.4881146199716677),
    (4, -0.590290826836843),
    (5, 21.230051448181193),
    (6, 15.279233632882423),
    (7, -33.28821096898486),
    (8, -0.020331201708508627),
];
const A11: [(usize, f64); 8] = [
    (0, -0.9371424300859873),
    (3, 5.186372428844064),
    (4, 1.0914373489967295),
    (5, -8.149787010746927),
    (6, -18.52006565999696),
    (7, 22.739487099350505),
    (8, 2.4936055526796523),
    (9, -3.0467644718982196),
];
const A12: [(usize, f64); 9] = [
    (0, 2.273310147516538),
    (3, -10.53449546673725),
    (4, -2.0008720582248625),
    (5, -17.9589318631188),
    (6, 27.94888452941996),
    (7, -2.8589982771350235),
    (8, -8.87285693353063),
    (9, 12.360567175794303),
    (10, 0.6433927460157636),
];
/// Weights of the stages in the result.
const B: [(usize, f64); 8] = [
    (0, 0.054293734116568765),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, 0.3111643669578199),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.04471061572777259),
];
/// Weights of the error estimate of order 5.
const E5: [(usize, f64); 8] = [
    (0, 0.01312004499419488),
    (5, -1.2251564463762044),
    (6, -0.4957589496572502),
    (7, 1.6643771824549864),
    (8, -0.35032884874997366),
    (9, 0.3341791187130175),
    (10, 0.08192320648511571),
    (11, -0.022355307863886294),
];
/// What the embedded result of order 3 has instead of `B`.
const B3: [(usize, f64); 3] =
    [(0, 0.2440944881889764), (8, 0.7338466882816118), (11, 0.022058823529411766)];

/// How often a step evaluates the rates: those at its begin are given, those at its end are left to
/// the caller.
pub const EVALUATIONS: u64 = 11;

/// A step that was tried.
#[derive(Clone, Copy, Debug)]
pub struct TrialStep<const N: usize, const Z: usize> {
    /// The state at its end.
    pub end: BodyState<N, Z>,
    /// The estimated error in units of the tolerance: the step is good if it is at most 1.
    pub error: f64,
}

#[inline(always)]
fn sum<const N: usize, const Z: usize, const T: usize>(
    from: &BodyState<N, Z>,
    h: f64,
    k: &[BodyState<N, Z>; 12],
    weights: &[(usize, f64); T],
) -> BodyState<N, Z> {
    let mut out = *from;
    for (stage, weight) in weights {
        out = out.plus(h * weight, &k[*stage]);
    }
    out
}

/// A step of length `h` from `from`, whose rates are `first`. `scale` is what an error of each
/// component is measured by. The rates at the end are not evaluated.
#[inline]
pub fn step<const N: usize, const Z: usize>(
    mut rates: impl FnMut(f64, &BodyState<N, Z>) -> BodyState<N, Z>,
    t: f64,
    from: &BodyState<N, Z>,
    first: &BodyState<N, Z>,
    h: f64,
    scale: &BodyState<N, Z>,
) -> TrialStep<N, Z> {
    let mut k = [BodyState::ZERO; 12];
    k[0] = *first;
    k[1] = rates(t + C[1] * h, &sum(from, h, &k, &A2));
    k[2] = rates(t + C[2] * h, &sum(from, h, &k, &A3));
    k[3] = rates(t + C[3] * h, &sum(from, h, &k, &A4));
    k[4] = rates(t + C[4] * h, &sum(from, h, &k, &A5));
    k[5] = rates(t + C[5] * h, &sum(from, h, &k, &A6));
    k[6] = rates(t + C[6] * h, &sum(from, h, &k, &A7));
    k[7] = rates(t + C[7] * h, &sum(from, h, &k, &A8));
    k[8] = rates(t + C[8] * h, &sum(from, h, &k, &A9));
    k[9] = rates(t + C[9] * h, &sum(from, h, &k, &A10));
    k[10] = rates(t + C[10] * h, &sum(from, h, &k, &A11));
    k[11] = rates(t + C[11] * h, &sum(from, h, &k, &A12));
    let gain = sum(&BodyState::ZERO, 1.0, &k, &B);
    let fifth = sum(&BodyState::ZERO, 1.0, &k, &E5);
    let third = sum(&gain, -1.0, &k, &B3);
    let square = |estimate: &BodyState<N, Z>| -> f64 {
        let relative = estimate.zip(scale, |error, scale| error / scale);
        let total: f64 = relative.components().map(|ratio| ratio * ratio).sum();
        total / ((2 + Z) * N) as f64
    };
    let (fifth, third) = (square(&fifth), square(&third));
    let both = fifth + 0.01 * third;
    // Not a number stays one.
    let error = if both == 0.0 { 0.0 } else { h.abs() * fifth / both.sqrt() };
    TrialStep { end: from.plus(h, &gain), error }
}

/// What the next step should be, as a multiple of one with this error.
pub fn growth(error: f64) -> f64 {
    if error.is_nan() {
        return 1.0 / 3.0;
    }
    (0.9 * error.max(1e-30).powf(-1.0 / 8.0)).clamp(1.0 / 3.0, 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_sums_to_the_time_of_its_stage() {
        let sum = |row: &[(usize, f64)]| row.iter().map(|(_, weight)| weight).sum::<f64>();
        let rows = [&A2[..], &A3, &A4, &A5, &A6, &A7, &A8, &A9, &A10, &A11, &A12];
        for (row, c) in rows.iter().zip(&C[1..]) {
            assert!((sum(row) - c).abs() < 1e-13, "{c}: {row:?}");
        }
        for (weights, expected) in [(&B[..], 1.0), (&E5, 0.0), (&B3, 1.0)] {
            assert!((sum(weights) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn the_error_falls_with_the_eighth_power_of_the_step() {
        // x'' = -sin x - t x' has all the terms that a wrong weight would show in; halving the step
        // must cost eight binary digits of the error.
        let rates = |t: f64, s: &BodyState<1, 0>| BodyState {
            q: s.v,
            v: [-s.q[0].sin() - t * s.v[0]],
            z: [[]],
        };
        let scale = BodyState { q: [1.0], v: [1.0], z: [[]] };
        let end = |steps: u32| {
            let (mut state, h) =
                (BodyState { q: [1.5], v: [0.3], z: [[]] }, 2.0 / f64::from(steps));
            for i in 0..steps {
                let t = f64::from(i) * h;
                state = step(rates, t, &state, &rates(t, &state), h, &scale).end;
            }
            state.q[0]
        };
        let exact = end(256);
        let orders = [4, 8].map(|n| ((end(n) - exact) / (end(2 * n) - exact)).abs().log2());
        assert!(orders.iter().all(|order| (7.5..9.5).contains(order)), "{orders:?}");
    }
}
