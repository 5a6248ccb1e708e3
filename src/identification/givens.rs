//! Recursive least squares by Givens rotations: rows are added one by one, and condensed into a
//! triangle.
//!
//! ```text
//! |  R   z |        | R' z' |      for each column i:  r = sqrt(R_ii^2 + x_i^2)
//! |  x   y |   ->   | 0  e  |      c = R_ii / r,  s = x_i / r,  and the rows turn by (c, s)
//! ```
//!
//! The solution of `R p = z` is the parameters with the least sum of squares, which is the sum of
//! all `e^2` (Gentleman, *Least squares computations by Givens transformations without square
//! roots*, J. Inst. Maths Applics 12, 1973, in the form with roots; Golub and Van Loan, *Matrix
//! Computations*, section 5.2).
//!
//! Why this form: the normal equations square the condition number of the columns, for which `f32`
//! is not precise enough; a rotation keeps every length. The triangle of all columns also yields
//! the fit of each choice of them: its rows are equivalent to all rows that were added.
//!
//! Guarantees: nothing is divided by zero, and no row is kept. The cost of one row is known: `N`
//! roots, and `N (N + 3)` products and sums.
//!
//! Does badly: old rows keep their full weight. A parameter that drifts is averaged.

/// The triangle of `N` columns and a right-hand side. `P` is the number of its elements,
/// `N (N + 1) / 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle<const N: usize, const P: usize> {
    /// The rows of `R` from the diagonal on, one after the other.
    packed: [f32; P],
    rhs: [f32; N],
    /// Residual sum of squares: the part that no choice of parameters explains.
    unexplained: f32,
    /// Sum of the squares of the right-hand sides.
    total: f32,
    rows: u32,
}

/// The parameters of a triangle with their standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const N: usize> {
    /// The parameters with the least sum of squares.
    pub values: [f32; N],
    /// Their standard deviations, if the rows' errors are independent and alike.
    pub deviations: [f32; N],
    /// The rows of the inverse of `R`, times the standard deviation of a row.
    pub spread: [[f32; N]; N],
}

impl<const N: usize> Solution<N> {
    /// Returns the standard deviation of a sum of parameters with these weights.
    pub fn deviation_of(&self, weights: &[f32; N]) -> f32 {
        let mut sum = 0.0;
        for column in 0..N {
            let along: f32 = self
                .spread
                .iter()
                .zip(weights)
                .map(|(row, weight)| row.get(column).copied().unwrap_or(0.0) * weight)
                .sum();
            sum += along * along;
        }
        libm::sqrtf(sum)
    }
}

impl<const N: usize, const P: usize> Default for Triangle<N, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Returns a triangle without rows.
    pub const fn new() -> Self {
        const { assert!(2 * P == N * (N + 1)) };
        Self { packed: [0.0; P], rhs: [0.0; N], unexplained: 0.0, total: 0.0, rows: 0 }
    }

    /// Returns the number of rows.
    pub const fn rows(&self) -> u32 {
        self.rows
    }

    /// Returns the relative residual: the root of the ratio of the residual sum of squares to that
    /// of the right-hand sides.
    pub fn relative_residual(&self) -> f32 {
        if self.total > 0.0 { libm::sqrtf(self.unexplained / self.total) } else { 1.0 }
    }

    /// Returns the residual sum of squares.
    pub const fn unexplained(&self) -> f32 {
        self.unexplained
    }

    /// Sets another residual sum of squares, from which the standard deviations follow.
    pub const fn suppose_unexplained(&mut self, sum: f32) {
        self.unexplained = sum;
    }

    /// Adds a row `x p = y`.
    pub fn add(&mut self, x: [f32; N], y: f32) {
        self.rows = self.rows.saturating_add(1);
        self.total += y * y;
        self.rotate(x, y);
    }

    // Once for each size of triangle, and not in every caller.
    #[inline(never)]
    fn rotate(&mut self, mut x: [f32; N], mut y: f32) {
        let mut rest = &mut self.packed[..];
        let mut of_x = &mut x[..];
        for z in &mut self.rhs {
            let Some((row, below)) = rest.split_at_mut_checked(of_x.len()) else { break };
            rest = below;
            let (Some(diagonal), Some(&head)) = (row.first(), of_x.first()) else { break };
            // An element whose square underflows counts as zero.
            let length = libm::sqrtf(diagonal * diagonal + head * head);
            if head != 0.0 && length > 0.0 {
                let (c, s) = (diagonal / length, head / length);
                for (r, x) in row.iter_mut().zip(of_x.iter_mut()) {
                    (*r, *x) = (c * *r + s * *x, c * *x - s * *r);
                }
                (*z, y) = (c * *z + s * y, c * y - s * *z);
            }
            of_x = of_x.get_mut(1..).unwrap_or_default();
        }
        self.unexplained += y * y;
    }

    /// Returns the triangle of the same rows with other columns, which `choose` computes from a
    /// row.
    pub fn chosen<const M: usize, const Q: usize>(
        &self,
        choose: impl Fn(&[f32; N]) -> [f32; M],
    ) -> Triangle<M, Q> {
        let mut chosen = Triangle::new();
        let mut rest = &self.packed[..];
        for (index, z) in self.rhs.iter().enumerate() {
            let Some((row, below)) = rest.split_at_checked(N - index) else { break };
            rest = below;
            let mut whole = [0.0; N];
            whole.iter_mut().skip(index).zip(row).for_each(|(to, from)| *to = *from);
            chosen.rotate(choose(&whole), *z);
        }
        chosen.unexplained += self.unexplained;
        (chosen.total, chosen.rows) = (self.total, self.rows);
        chosen
    }

    /// Holds a parameter at zero. Its column must be zero in every row.
    pub fn hold_at_zero(&mut self, column: usize) {
        let mut x = [0.0; N];
        if let Some(one) = x.get_mut(column) {
            *one = 1.0;
        }
        self.rotate(x, 0.0);
    }

    /// Returns the element of `R` in a row and a column, on or right of the diagonal.
    #[inline(never)]
    fn element(&self, row: usize, column: usize) -> f32 {
        // The rows before this one have N, N - 1 .. elements.
        let begin = row * N - row * (row.saturating_sub(1)) / 2;
        self.packed.get(begin + column.saturating_sub(row)).copied().unwrap_or(0.0)
    }

    /// Returns the parameters with the least sum of squares; none if there are no more rows than
    /// columns, or if a column is a combination of others to within `tolerance` of its own length.
    #[inline(never)]
    pub fn values(&self, tolerance: f32) -> Option<[f32; N]> {
        if self.rows <= N as u32 {
            return None;
        }
        // Not N, for which the compiler would write out every turn.
        for column in 0..core::hint::black_box(N) {
            let length: f32 =
                (0..=column).map(|row| self.element(row, column)).map(|r| r * r).sum();
            let own = self.element(column, column).abs();
            let is_one = own > tolerance * libm::sqrtf(length);
            if !is_one {
                return None;
            }
        }
        Some(self.back(&self.rhs))
    }

    // A function of its own in an image: more than one fit calls it.
    /// Returns the parameters with their standard deviations; none if [`values`](Self::values)
    /// returns none. This needs ten times as long.
    #[inline(never)]
    pub fn solve(&self, tolerance: f32) -> Option<Solution<N>> {
        let values = self.values(tolerance)?;
        let freedom = self.rows.saturating_sub(N as u32);
        let of_row = libm::sqrtf(self.unexplained / freedom as f32);
        // The inverse of R: its columns are the solutions of R x = unit vectors.
        let mut spread = [[0.0; N]; N];
        for column in 0..core::hint::black_box(N) {
            let mut unit = [0.0; N];
            if let Some(one) = unit.get_mut(column) {
                *one = of_row;
            }
            let solved = self.back(&unit);
            for (row, value) in spread.iter_mut().zip(solved) {
                if let Some(place) = row.get_mut(column) {
                    *place = value;
                }
            }
        }
        let deviations = spread.map(|row| libm::sqrtf(row.iter().map(|v| v * v).sum()));
        Some(Solution { values, deviations, spread })
    }

    /// Solves `R x = z` from the last row up.
    // Once in an image, and not eight times unrolled for each column.
    #[inline(never)]
    fn back(&self, z: &[f32; N]) -> [f32; N] {
        let mut x = *z;
        for row in (0..core::hint::black_box(N)).rev() {
            let known: f32 = x
                .iter()
                .enumerate()
                .skip(row + 1)
                .map(|(column, value)| self.element(row, column) * value)
                .sum();
            if let Some(place) = x.get_mut(row) {
                *place = (*place - known) / self.element(row, row);
            }
        }
        x
    }
}

#[cfg(test)]
// A matrix reads best by its indices.
#[allow(clippy::needless_range_loop)]
mod tests {
    use super::*;

    /// A generator of numbers in [-1, 1) (Marsaglia, *Xorshift RNGs*, 2003).
    fn random(state: &mut u32) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 17;
        *state ^= *state << 5;
        f64::from(*state as i32) / f64::from(1u32 << 31)
    }

    /// The second method: the normal equations in f64, by Gauss and Jordan. Returns parameters, the
    /// diagonal of the inverse, and the residual sum of squares.
    fn normal_equations(rows: &[([f64; 4], f64)]) -> ([f64; 4], [f64; 4], f64) {
        let mut a = [[0.0f64; 9]; 4];
        for (x, y) in rows {
            for i in 0..4 {
                for j in 0..4 {
                    a[i][j] += x[i] * x[j];
                }
                a[i][8] += x[i] * y;
            }
        }
        for i in 0..4 {
            a[i][4 + i] = 1.0;
        }
        for i in 0..4 {
            let pivot = a[i][i];
            a[i].iter_mut().for_each(|v| *v /= pivot);
            let row = a[i];
            for (j, other) in a.iter_mut().enumerate().filter(|(j, _)| *j != i) {
                let factor = other[i];
                let _ = j;
                other.iter_mut().zip(row).for_each(|(v, r)| *v -= factor * r);
            }
        }
        let p = [0, 1, 2, 3].map(|i| a[i][8]);
        let left = |(x, y): &([f64; 4], f64)| y - (0..4).map(|i| x[i] * p[i]).sum::<f64>();
        let rss = rows.iter().map(|row| left(row).powi(2)).sum();
        (p, [0, 1, 2, 3].map(|i| a[i][4 + i]), rss)
    }

    fn rows<const COUNT: usize>(noise: f64) -> [([f64; 4], f64); COUNT] {
        let mut state = 7;
        let truth = [0.0005, 0.002, 0.4, -0.03];
        core::array::from_fn(|_| {
            // Columns of a joint: acceleration, velocity, its sign, one.
            let [a, v] = [300.0, 40.0].map(|size| size * random(&mut state));
            let x = [a, v, v.signum(), 1.0];
            let y = (0..4).map(|i| x[i] * truth[i]).sum::<f64>() + noise * random(&mut state);
            (x, y)
        })
    }

    fn triangle(rows: &[([f64; 4], f64)]) -> Triangle<4, 10> {
        let mut triangle = Triangle::new();
        rows.iter().for_each(|(x, y)| triangle.add(x.map(|x| x as f32), *y as f32));
        triangle
    }

    #[test]
    fn parameters_deviations_and_residual_are_those_of_the_normal_equations_in_double_precision() {
        for rows in [&rows::<300>(0.02)[..], &rows::<12>(0.1), &rows::<3000>(1e-3)] {
            let count = rows.len();
            let (p, inverse, rss) = normal_equations(rows);
            let found = triangle(rows);
            let solution = found.solve(1e-4).unwrap();
            let total: f64 = rows.iter().map(|(_, y)| y * y).sum();
            let share = (rss / total).sqrt();
            assert!((f64::from(found.relative_residual()) / share - 1.0).abs() < 1e-3, "{share}");
            for i in 0..4 {
                let sd = (inverse[i] * rss / (count as f64 - 4.0)).sqrt();
                let off = (f64::from(solution.values[i]) - p[i]).abs();
                // The rounding of f32, over 3000 rows, is below a tenth of the noise of 1e-3.
                assert!(off < 0.1 * sd, "{i}: {off} {sd}");
                let ratio = f64::from(solution.deviations[i]) / sd;
                assert!((ratio - 1.0).abs() < 2e-3, "{i}: {ratio}");
            }
        }
    }

    #[test]
    fn a_choice_of_columns_is_fitted_as_if_the_others_had_never_been_there() {
        let rows = rows::<200>(0.02);
        let whole = triangle(&rows);
        let mut alone = Triangle::<2, 3>::new();
        for (x, y) in &rows {
            alone.add([x[2] as f32, (x[1] + 10.0 * x[3]) as f32], *y as f32);
        }
        let chosen: Triangle<2, 3> = whole.chosen(|x| [x[2], x[1] + 10.0 * x[3]]);
        let [expected, found] = [alone, chosen].map(|fit| fit.solve(1e-4).unwrap());
        assert_eq!(chosen.rows(), 200);
        let close = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-3;
        assert!(close(chosen.unexplained(), alone.unexplained()));
        for i in 0..2 {
            assert!(close(found.values[i], expected.values[i]), "{found:?} {expected:?}");
            assert!(close(found.deviations[i], expected.deviations[i]));
        }
        // A sum of parameters: with one weight, it is that parameter.
        assert!(close(found.deviation_of(&[0.0, -2.0]), 2.0 * found.deviations[1]));
    }

    #[test]
    fn elements_too_small_to_square_are_none() {
        let mut fit = Triangle::<2, 3>::new();
        for (tiny, x) in [(1e-30, 1.0), (1e-38, 2.0), (0.0, 3.0)] {
            fit.add([tiny, x], 0.5 * x);
        }
        let mut chosen: Triangle<2, 3> = fit.chosen(|[_, x]| [0.0, *x]);
        assert_eq!(chosen.solve(1e-4), None);
        chosen.hold_at_zero(0);
        let found = chosen.solve(1e-4).unwrap();
        assert!(found.values[0] == 0.0 && (found.values[1] - 0.5).abs() < 1e-6, "{found:?}");
        assert!(fit.relative_residual() < 1e-3);
    }

    #[test]
    fn a_fit_without_freedom_or_with_a_column_that_others_make_up_is_none() {
        let rows = rows::<20>(0.02);
        assert_eq!(triangle(&rows[..4]).solve(1e-4), None);
        assert!(triangle(&rows[..5]).solve(1e-4).is_some());
        let twice = triangle(&rows).chosen::<2, 3>(|x| [x[1], 3.0 * x[1]]);
        assert_eq!(twice.solve(1e-4), None);
        // One sense of motion alone: Coulomb friction and offset are the same column.
        let mut one_way = Triangle::<2, 3>::new();
        (0..50).for_each(|i| one_way.add([1.0, 1.0], 0.4 + 0.01 * (i % 3) as f32));
        assert_eq!(one_way.solve(1e-4), None);
        assert_eq!(Triangle::<2, 3>::new().solve(1e-4), None);
    }
}
