//! The products of columns with each other, X' X, which are most of the work of an identification.
//!
//! Matrices of nalgebra are multiplied by kernels for the vectors of the processor. There is none for WebAssembly:
//! there the products are summed in tiles of four by four columns, in vectors of two.

/// Adds the products of `rows`, one sample after the other, to the lower triangle of `gram`.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn add(gram: &mut nalgebra::DMatrix<f64>, rows: &[f64]) {
    use nalgebra::{DMatrixView, DMatrixViewMut};
    use rayon::prelude::*;

    /// Columns that are multiplied with all later ones at a time.
    const PANEL: usize = 64;

    let size = gram.nrows();
    let block = DMatrixView::from_slice(rows, size, rows.len() / size);
    gram.as_mut_slice().par_chunks_mut(size * PANEL).enumerate().for_each(|(k, columns)| {
        let (from, width) = (k * PANEL, columns.len() / size);
        let (below, panel) = (block.rows_range(from..), block.rows(from, width).transpose());
        let mut columns = DMatrixViewMut::from_slice(columns, size, width);
        columns.rows_range_mut(from..).gemm(1.0, &below, &panel, 1.0);
    });
}

#[cfg(target_arch = "wasm32")]
pub(super) use tiles::add;

#[cfg(target_arch = "wasm32")]
mod tiles {
    use core::arch::wasm32::{f64x2, f64x2_add, f64x2_extract_lane, f64x2_mul, f64x2_splat, v128};
    use nalgebra::DMatrix;

    /// Columns of a tile.
    const TILE: usize = 4;

    pub(in super::super) fn add(gram: &mut DMatrix<f64>, rows: &[f64]) {
        let size = gram.nrows();
        // Four columns beside each other, filled up by zeros.
        let panel = |from: usize| -> Vec<[v128; 2]> {
            let at = |row: &[f64], k: usize| row.get(from + k).copied().unwrap_or(0.0);
            rows.chunks_exact(size).map(|row| [0, 2].map(|k| f64x2(at(row, k), at(row, k + 1)))).collect()
        };
        let panels: Vec<_> = (0..size).step_by(TILE).map(panel).collect();
        for (k, right) in panels.iter().enumerate() {
            for (i, below) in panels.iter().enumerate().skip(k) {
                for (c, column) in tile(below, right).iter().enumerate().take(size - TILE * k) {
                    for (r, sum) in column.iter().enumerate().take(size - TILE * i) {
                        gram[(TILE * i + r, TILE * k + c)] += sum;
                    }
                }
            }
        }
    }

    /// The products of each column of `below` with each of `right`, by the columns of `right`. The sums have names so
    /// that they stay in registers.
    fn tile(below: &[[v128; 2]], right: &[[v128; 2]]) -> [[f64; TILE]; TILE] {
        let zero = f64x2_splat(0.0);
        let (mut a0, mut a1, mut b0, mut b1) = (zero, zero, zero, zero);
        let (mut c0, mut c1, mut d0, mut d1) = (zero, zero, zero, zero);
        for ([upper, lower], [ab, cd]) in below.iter().zip(right) {
            let a = f64x2_splat(f64x2_extract_lane::<0>(*ab));
            a0 = f64x2_add(a0, f64x2_mul(*upper, a));
            a1 = f64x2_add(a1, f64x2_mul(*lower, a));
            let b = f64x2_splat(f64x2_extract_lane::<1>(*ab));
            b0 = f64x2_add(b0, f64x2_mul(*upper, b));
            b1 = f64x2_add(b1, f64x2_mul(*lower, b));
            let c = f64x2_splat(f64x2_extract_lane::<0>(*cd));
            c0 = f64x2_add(c0, f64x2_mul(*upper, c));
            c1 = f64x2_add(c1, f64x2_mul(*lower, c));
            let d = f64x2_splat(f64x2_extract_lane::<1>(*cd));
            d0 = f64x2_add(d0, f64x2_mul(*upper, d));
            d1 = f64x2_add(d1, f64x2_mul(*lower, d));
        }
        let two = |v: v128| [f64x2_extract_lane::<0>(v), f64x2_extract_lane::<1>(v)];
        [(a0, a1), (b0, b1), (c0, c1), (d0, d1)].map(|(upper, lower)| {
            let ([p, q], [r, s]) = (two(upper), two(lower));
            [p, q, r, s]
        })
    }
}
