//! Solves small symmetric systems with some unknowns held at zero.
// One index goes through several arrays of bodies at once.
#![allow(clippy::needless_range_loop)]

/// Solves `matrix x = rhs`, with the `held` unknowns at zero. `matrix` is symmetric and positive
/// definite, so that elimination needs no pivoting.
#[inline(always)]
pub fn solve<const N: usize>(matrix: &[[f64; N]; N], rhs: &[f64; N], held: &[bool; N]) -> [f64; N] {
    let (mut a, mut x) = (*matrix, *rhs);
    for i in 0..N {
        if held[i] {
            for k in 0..N {
                a[i][k] = 0.0;
                a[k][i] = 0.0;
            }
            a[i][i] = 1.0;
            x[i] = 0.0;
        }
    }
    for i in 0..N {
        for row in i + 1..N {
            let factor = a[row][i] / a[i][i];
            for k in i + 1..N {
                a[row][k] -= factor * a[i][k];
            }
            x[row] -= factor * x[i];
        }
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] -= a[i][k] * x[k];
        }
        x[i] /= a[i][i];
    }
    x
}
