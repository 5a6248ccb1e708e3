//! Statistics of an ensemble: the interval of a success, and quantiles.
//!
//! The interval is Wilson's score interval (E. B. Wilson, *JASA* 22 (1927), 209), for 95 %:
//!
//! ```text
//! (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)      p = k/n, z = 1.959964
//! ```
//!
//! Why this one: it is useful also where all cases succeed or none does, and its coverage is near
//! 95 % on average over p (L. D. Brown, T. T. Cai and A. DasGupta, *Statistical Science* 16 (2001),
//! 101). Clopper and Pearson's covers at least 95 % for every p, and is wider.
//!
//! A quantile is the smallest value that at least that share of the cases does not exceed (nearest
//! rank): it is always the value of a case, and infinity is a value like any other.

/// The 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// Returns Wilson's 95 % interval of the share of `k` in `n` cases; without cases it is 0 to 1.
pub fn wilson(k: usize, n: usize) -> [f64; 2] {
    if n == 0 {
        return [0.0, 1.0];
    }
    let n_cases = n as f64;
    let p = k as f64 / n_cases;
    let z2n = Z * Z / n_cases;
    let middle = p + 0.5 * z2n;
    let half = Z * (p * (1.0 - p) / n_cases + 0.25 * z2n / n_cases).sqrt();
    // The ends are exact where the square root is that of a square, but for its rounding.
    let low = if k == 0 { 0.0 } else { (middle - half) / (1.0 + z2n) };
    let high = if k >= n { 1.0 } else { (middle + half) / (1.0 + z2n) };
    [low, high]
}

/// Sorted values, for quantiles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SortedValues(Vec<f64>);

impl SortedValues {
    /// Sorts values. NaN counts as infinite, which is the worst value.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> =
            values.into_iter().map(|x| if x.is_nan() { f64::INFINITY } else { x }).collect();
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    /// Returns the smallest value that the share `p` of all does not exceed; `None` without values.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let rank = (p * self.0.len() as f64).ceil() as usize;
        self.0.get(rank.max(1) - 1).copied()
    }

    /// Returns the number of finite values.
    pub fn finite(&self) -> usize {
        self.0.iter().filter(|value| value.is_finite()).count()
    }

    /// Returns the largest value.
    pub fn max(&self) -> Option<f64> {
        self.0.last().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_published_tables() {
        // R. G. Newcombe, Statistics in Medicine 17 (1998), 857, table I, method 3.
        for (k, n, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(k, n);
            assert!((found[0] - low).abs() < 5e-5 && (found[1] - high).abs() < 5e-5, "{found:?}");
            // The share of failures has the mirrored interval.
            let mirrored = wilson(n - k, n);
            assert!((mirrored[0] + found[1] - 1.0).abs() < 1e-12, "{mirrored:?}");
            assert!((mirrored[1] + found[0] - 1.0).abs() < 1e-12, "{mirrored:?}");
        }
        assert_eq!((wilson(0, 0), wilson(20, 20)[1]), ([0.0, 1.0], 1.0));
    }

    #[test]
    fn the_ends_are_the_shares_that_the_score_test_just_does_not_refuse() {
        for (k, n) in [(3, 10), (492, 500), (999, 1000), (1, 200)] {
            for end in wilson(k, n) {
                let score = (k as f64 / n as f64 - end) / (end * (1.0 - end) / n as f64).sqrt();
                assert!((score.abs() - Z).abs() < 1e-9, "{k} of {n}: {score}");
            }
        }
    }

    #[test]
    fn a_quantile_is_the_value_of_a_case_and_infinity_is_one() {
        let ten = SortedValues::new((1..=10).rev().map(f64::from));
        let quantiles = [0.0, 0.1, 0.11, 0.5, 0.51, 0.95, 1.0].map(|p| ten.quantile(p));
        assert_eq!(quantiles, [1.0, 1.0, 2.0, 5.0, 6.0, 10.0, 10.0].map(Some));
        let never = SortedValues::new([1.0, f64::INFINITY, f64::NAN, 2.0]);
        assert_eq!(never.quantile(0.5), Some(2.0));
        assert_eq!([never.quantile(0.75), never.max()], [Some(f64::INFINITY); 2]);
        assert_eq!(
            (SortedValues::default().quantile(0.5), SortedValues::default().max()),
            (None, None)
        );
    }
}
