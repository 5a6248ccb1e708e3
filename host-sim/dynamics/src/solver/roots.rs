//! Finds the first place in a step where a polynomial falls below zero.

/// A polynomial of degree 4 in the part of the step that is done, lowest power first.
pub type Quartic = [f64; 5];

/// Number of sampled places of the step; between two of them at most one minimum is searched for.
const PLACES: usize = 8;

/// Returns the value at a place.
pub fn value(p: &Quartic, x: f64) -> f64 {
    p[0] + x * (p[1] + x * (p[2] + x * (p[3] + x * p[4])))
}

/// Returns the slope at a place.
pub fn slope(p: &Quartic, x: f64) -> f64 {
    p[1] + x * (2.0 * p[2] + x * (3.0 * p[3] + x * 4.0 * p[4]))
}

/// Returns the first place in [0, 1] at which the polynomial falls from above zero to zero or
/// below. Dips between two sampled places are found, too. A polynomial that starts at zero and
/// rises does not fall there.
pub fn first_falling_zero(p: &Quartic) -> Option<f64> {
    // Rounding can tilt a polynomial that starts at zero with slope zero: it must continue to fall.
    if p[0] < 0.0 || (p[0] == 0.0 && p[1] < 0.0 && value(p, 1.0 / 64.0) < 0.0) {
        return Some(0.0);
    }
    let mut left = 0.0;
    let mut falling = p[1] < 0.0;
    for i in 1..=PLACES {
        let right = i as f64 / PLACES as f64;
        let steep = slope(p, right);
        if value(p, right) <= 0.0 {
            return Some(bisect(left, right, |x| value(p, x)));
        }
        if falling && steep > 0.0 {
            let lowest = bisect(left, right, |x| -slope(p, x));
            if value(p, lowest) <= 0.0 {
                return Some(bisect(left, lowest, |x| value(p, x)));
            }
        }
        falling = steep < 0.0;
        left = right;
    }
    None
}

/// Returns the place at which a function changes that is above zero on the left and not on the
/// right. Later refinement corrects the small error of the place.
fn bisect(mut left: f64, mut right: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (left + right);
        if f(middle) > 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    0.5 * (left + right)
}

/// Returns the polynomial through five values at 0, 1/4, 1/2, 3/4 and 1.
pub fn through(y: &[f64; 5]) -> Quartic {
    let [a, b, c, d, e] = *y;
    [
        a,
        (-25.0 * a + 48.0 * b - 36.0 * c + 16.0 * d - 3.0 * e) / 3.0,
        (70.0 * a - 208.0 * b + 228.0 * c - 112.0 * d + 22.0 * e) / 3.0,
        (-80.0 * a + 288.0 * b - 384.0 * c + 224.0 * d - 48.0 * e) / 3.0,
        (32.0 * a - 128.0 * b + 192.0 * c - 128.0 * d + 32.0 * e) / 3.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_goes_through_its_values() {
        let p: Quartic = [0.3, -1.0, 2.0, 0.7, -1.9];
        let y = [0.0, 0.25, 0.5, 0.75, 1.0].map(|x| value(&p, x));
        assert!(through(&y).iter().zip(&p).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn the_first_fall_is_found_and_only_that() {
        // (x - 0.3)(x - 0.32): a dip between two places; (x - 0.3)^2 + 1e-6 does not reach zero.
        let near = |p: &Quartic, x: f64| {
            first_falling_zero(p).is_some_and(|found| (found - x).abs() < 1e-9)
        };
        assert!(near(&[0.096, -0.62, 1.0, 0.0, 0.0], 0.3));
        assert_eq!(first_falling_zero(&[0.090001, -0.6, 1.0, 0.0, 0.0]), None);
        assert!(near(&[1.0, -2.0, 0.0, 0.0, 0.0], 0.5));
        assert_eq!(first_falling_zero(&[0.0, 1.0, 0.0, 0.0, 0.0]), None);
        assert_eq!(first_falling_zero(&[0.0, -1.0, 5.0, 0.0, 0.0]), Some(0.0));
        assert_eq!(first_falling_zero(&[0.0, -1e-17, 5.0, 0.0, 0.0]), None);
        assert!(near(&[0.0, 1.0, -2.0, 0.0, 0.0], 0.5));
    }
}
