//! Linear least squares by Givens rotations, one row at a time. The standard deviations do not
//! assume independent residuals.
//!
//! ```text
//! min |y - W b|      Q^T [W y] = [R z; 0 r]      b = R^-1 z
//! cov b = A sum_m (W_m^T e_m)(W_m^T e_m)^T A M/(M-1)      A = (R^T R)^-1
//! ```
//!
//! The rows of the log are cut into M blocks in time; e_m are the residuals of a block. Source: the
//! sandwich of clusters (K.-Y. Liang and S. L. Zeger, *Biometrika* 73 (1986), 13). It includes any
//! correlation of the residuals inside a block; with independent residuals it is the usual
//! covariance. It does not include correlation over more than a block. So the largest of the
//! variances of 10, 20 and 40 blocks is used, each widened by the ratio of Student's t at 95 % to
//! the normal distribution's 1.96.

/// Largest number of columns.
pub const MOST: usize = 10;

/// Row of a regression; entries after its columns are 0.
pub type RegressionRow = [f64; MOST];

/// Numbers of blocks M, and the ratio of Student's t with M - 1 degrees of freedom at 95 %
/// (two-sided) to 1.96.
const BLOCKS: [(usize, f64); 3] = [(10, 1.154), (20, 1.068), (40, 1.032)];

/// Least sine of the angle between a column and the ones before it. Below this sine, the column
/// counts as a sum of them.
const SINGULAR: f64 = 1e-6;

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Number of columns.
    pub columns: usize,
    /// Coefficients b.
    pub values: RegressionRow,
    /// Covariance of the coefficients.
    pub covariance: [RegressionRow; MOST],
    /// Ratio of each coefficient's uncertainty to that without the other columns.
    pub inflation: RegressionRow,
    /// Sum of the squares of the residuals.
    pub residual: f64,
    /// Sum of the squares of y.
    pub total: f64,
}

impl Fit {
    /// Fits rows of columns and y.
    ///
    /// # Errors
    /// Returns the index of the first column that is a sum of columns before it, or zero.
    pub fn of<R>(columns: usize, rows: impl Fn() -> R) -> Result<Self, usize>
    where
        R: Iterator<Item = (RegressionRow, f64)>,
    {
        let columns = columns.min(MOST);
        let mut triangle = [[0.0; MOST + 1]; MOST + 1];
        let (mut total, mut norms, mut count) = (0.0, [0.0f64; MOST], 0usize);
        for (row, y) in rows() {
            let mut line = [0.0; MOST + 1];
            line[..columns].copy_from_slice(&row[..columns]);
            line[columns] = y;
            rotate(&mut triangle, line, columns + 1);
            (total, count) = (total + y * y, count + 1);
            for (norm, value) in norms.iter_mut().zip(row) {
                *norm += value * value;
            }
        }
        for i in 0..columns {
            if triangle[i][i].abs() <= SINGULAR * norms[i].sqrt() {
                return Err(i);
            }
        }
        let inverse = inverse(&triangle, columns);
        let mut values = [0.0; MOST];
        for i in 0..columns {
            values[i] = (i..columns).map(|j| inverse[i][j] * triangle[j][columns]).sum();
        }
        // (R^T R)^-1 = R^-1 R^-T.
        let mut bread = [[0.0; MOST]; MOST];
        for i in 0..columns {
            for j in 0..columns {
                bread[i][j] = (i.max(j)..columns).map(|k| inverse[i][k] * inverse[j][k]).sum();
            }
        }
        let mut inflation = [0.0; MOST];
        for i in 0..columns {
            inflation[i] = (bread[i][i] * norms[i]).sqrt();
        }
        let mut fit = Self {
            columns,
            values,
            covariance: [[0.0; MOST]; MOST],
            inflation,
            residual: triangle[columns][columns].powi(2),
            total,
        };
        fit.covariance = fit.clustered(&bread, count, rows());
        Ok(fit)
    }

    /// Returns the prediction for a row.
    pub fn predict(&self, row: &RegressionRow) -> f64 {
        row.iter().zip(&self.values).map(|(column, value)| column * value).sum()
    }

    /// Returns the standard deviation of a coefficient.
    pub fn deviation(&self, column: usize) -> f64 {
        self.covariance[column][column].sqrt()
    }

    /// Returns the covariance by the block sums of the gradients: for each coefficient the largest
    /// variance over the block numbers, with the correlations of the finest blocks.
    fn clustered(
        &self,
        bread: &[RegressionRow; MOST],
        count: usize,
        rows: impl Iterator<Item = (RegressionRow, f64)>,
    ) -> [RegressionRow; MOST] {
        let n = self.columns;
        let finest = BLOCKS[BLOCKS.len() - 1].0;
        let mut sums = vec![[0.0; MOST]; finest];
        for (i, (row, y)) in rows.enumerate() {
            let error = y - self.predict(&row);
            let block = &mut sums[(i * finest / count.max(1)).min(finest - 1)];
            for (sum, value) in block.iter_mut().zip(row) {
                *sum += value * error;
            }
        }
        let mut widest = [0.0f64; MOST];
        let mut covariance = [[0.0; MOST]; MOST];
        for (blocks, t) in BLOCKS {
            let mut meat = [[0.0; MOST]; MOST];
            for several in sums.chunks(finest / blocks) {
                let mut sum = [0.0; MOST];
                for one in several {
                    sum.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
                }
                for i in 0..n {
                    for j in 0..n {
                        meat[i][j] += sum[i] * sum[j];
                    }
                }
            }
            let factor = t * t * blocks as f64 / (blocks - 1) as f64;
            covariance = sandwich(bread, &meat, n, factor);
            for i in 0..n {
                widest[i] = widest[i].max(covariance[i][i]);
            }
        }
        // Correlations stay, with the largest variances.
        let scale: RegressionRow = std::array::from_fn(|i| match covariance[i][i] {
            variance if variance > 0.0 => (widest[i] / variance).sqrt(),
            _ => 1.0,
        });
        for i in 0..n {
            for j in 0..n {
                covariance[i][j] *= scale[i] * scale[j];
            }
        }
        covariance
    }
}

/// Rotates a line with the given number of entries into the triangle.
fn rotate(triangle: &mut [[f64; MOST + 1]; MOST + 1], mut line: [f64; MOST + 1], entries: usize) {
    for i in 0..entries {
        if line[i] == 0.0 {
            continue;
        }
        let length = triangle[i][i].hypot(line[i]);
        let (c, s) = (triangle[i][i] / length, line[i] / length);
        for j in i..entries {
            let (upper, lower) = (triangle[i][j], line[j]);
            triangle[i][j] = c * upper + s * lower;
            line[j] = c * lower - s * upper;
        }
    }
}

/// Returns the inverse of the upper left part of a triangle.
fn inverse(triangle: &[[f64; MOST + 1]; MOST + 1], n: usize) -> [RegressionRow; MOST] {
    let mut inverse = [[0.0; MOST]; MOST];
    for j in 0..n {
        inverse[j][j] = 1.0 / triangle[j][j];
        for i in (0..j).rev() {
            let sum: f64 = (i + 1..=j).map(|k| triangle[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -sum / triangle[i][i];
        }
    }
    inverse
}

fn sandwich(
    bread: &[RegressionRow; MOST],
    meat: &[RegressionRow; MOST],
    n: usize,
    factor: f64,
) -> [RegressionRow; MOST] {
    let product = |a: &[RegressionRow; MOST], b: &[RegressionRow; MOST]| {
        let mut product = [[0.0; MOST]; MOST];
        for i in 0..n {
            for j in 0..n {
                product[i][j] = (0..n).map(|k| a[i][k] * b[k][j]).sum();
            }
        }
        product
    };
    let mut all = product(&product(bread, meat), bread);
    all.iter_mut().flatten().for_each(|value| *value *= factor);
    all
}
