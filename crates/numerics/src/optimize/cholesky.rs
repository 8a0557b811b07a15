//! The Cholesky factor of a matrix, A = L L'.
//!
//! ```text
//! l_ij = (a_ij - sum_k l_ik l_jk) / l_jj,   l_jj = sqrt(a_jj - sum_k l_jk^2),   k < j <= i
//! ```
//! Sums run over k in their order, without fused multiply-add, so that the factor is the same to the bit on every
//! machine. Strips of rows of a few columns stay in registers over all k.
//!
//! Reference: G. H. Golub, C. F. Van Loan, Matrix Computations (2013), section 4.2.5.

use multiversion::multiversion;
use nalgebra::DMatrix;

/// Columns that are computed together, and rows of a strip: as many as registers hold.
const COLUMNS: usize = if cfg!(target_arch = "wasm32") { 4 } else { 8 };
const ROWS: usize = COLUMNS;

/// Smallest pivot, over the diagonal of A.
pub(super) const MIN_PIVOT: f64 = 1e-14;

/// The lower triangle L of A = L L'; above it are other numbers. `None` if A is not positive definite.
pub(super) fn cholesky(mut a: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (n, diagonal) = (a.nrows(), a.diagonal());
    for from in (0..n).step_by(COLUMNS) {
        let (done, rest) = a.as_mut_slice().split_at_mut(from * n);
        let panel = &mut rest[..COLUMNS.min(n - from) * n];
        subtract(done, panel, n, from);
        for j in 0..panel.len() / n {
            let (before, column) = panel.split_at_mut(j * n);
            let row = from + j;
            for before in before.chunks_exact(n) {
                let factor = before[row];
                column[row..n].iter_mut().zip(&before[row..]).for_each(|(y, l)| *y -= factor * l);
            }
            let pivot = column[row];
            if pivot.is_nan() || pivot <= MIN_PIVOT * diagonal[row] {
                return None;
            }
            column[row..n].iter_mut().for_each(|y| *y /= pivot.sqrt());
        }
    }
    Some(a)
}

/// Subtracts the terms of the `done` columns from the rows `from..n` of a panel, which begins at column `from`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn subtract(done: &[f64], panel: &mut [f64], n: usize, from: usize) {
    let whole = if panel.len() == COLUMNS * n { from + (n - from) / ROWS * ROWS } else { from };
    for i in (from..whole).step_by(ROWS) {
        let mut sums = [[0.0; ROWS]; COLUMNS];
        for (sums, column) in sums.iter_mut().zip(panel.chunks_exact(n)) {
            sums.copy_from_slice(&column[i..i + ROWS]);
        }
        for column in done.chunks_exact(n) {
            let (mut strip, mut factors) = ([0.0; ROWS], [0.0; COLUMNS]);
            strip.copy_from_slice(&column[i..i + ROWS]);
            factors.copy_from_slice(&column[from..from + COLUMNS]);
            for c in 0..COLUMNS {
                for r in 0..ROWS {
                    sums[c][r] -= factors[c] * strip[r];
                }
            }
        }
        for (sums, column) in sums.iter().zip(panel.chunks_exact_mut(n)) {
            column[i..i + ROWS].copy_from_slice(sums);
        }
    }
    for (c, column) in panel.chunks_exact_mut(n).enumerate() {
        for before in done.chunks_exact(n) {
            let factor = before[from + c];
            column[whole..].iter_mut().zip(&before[whole..]).for_each(|(y, l)| *y -= factor * l);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_factor_gives_the_matrix_for_every_size() {
        for n in 1..40 {
            let x = DMatrix::from_fn(n + 3, n, |i, j| ((i * i + 3 * i * j + 7 * j) as f64).sin());
            let a = x.tr_mul(&x) + DMatrix::identity(n, n);
            let mut l = cholesky(a.clone()).unwrap();
            l.fill_upper_triangle(0.0, 1);
            assert_close((&l * l.transpose()).as_slice(), a.as_slice(), 1e-13, 1e-13);
        }
    }

    #[test]
    fn the_factor_is_the_sum_in_order_to_the_bit() {
        let n = 37;
        let x = DMatrix::from_fn(n, n, |i, j| ((5 * i + i * j) as f64).cos());
        let a = x.tr_mul(&x) + DMatrix::identity(n, n);
        let l = cholesky(a.clone()).unwrap();
        let mut plain = a;
        for j in 0..n {
            let sum = |plain: &DMatrix<f64>, i: usize| {
                (0..j).fold(plain[(i, j)], |sum, k| sum - plain[(j, k)] * plain[(i, k)])
            };
            let root = sum(&plain, j).sqrt();
            for i in j..n {
                plain[(i, j)] = sum(&plain, i) / root;
                assert_eq!(plain[(i, j)].to_bits(), l[(i, j)].to_bits(), "{i} {j}");
            }
        }
    }
}
