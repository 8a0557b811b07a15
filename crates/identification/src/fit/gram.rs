//! The products of columns with each other, X' X, which are most of the work of an identification.
//!
//! Each product is summed over a block of samples in their order, without fused multiply-add, so that it is the same to
//! the bit on every machine. Tiles of eight by eight columns stay in registers; for WebAssembly, of four by four.

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use native::add;

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use multiversion::{multiversion, target::target_cfg_f};
    use nalgebra::DMatrix;
    use rayon::prelude::*;

    /// Columns of a tile, and tiles beside each other that one thread computes.
    const TILE: usize = 8;
    const GROUP: usize = 8;

    /// Adds the products of `rows`, one sample after the other, to the lower triangle of `gram`.
    pub(crate) fn add(gram: &mut DMatrix<f64>, rows: &[f64]) {
        let size = gram.nrows();
        // Eight columns beside each other, filled up by zeros.
        let panel = |from: usize| -> Vec<[f64; TILE]> {
            let width = TILE.min(size - from);
            let eight = |row: &[f64]| {
                let mut eight = [0.0; TILE];
                eight[..width].copy_from_slice(&row[from..from + width]);
                eight
            };
            rows.chunks_exact(size).map(eight).collect()
        };
        let panels: Vec<_> = (0..size).step_by(TILE).map(panel).collect();
        gram.as_mut_slice().par_chunks_mut(size * TILE * GROUP).enumerate().for_each(|(group, columns)| {
            for (i, below) in panels.iter().enumerate().skip(GROUP * group) {
                let rows = TILE * i..size.min(TILE * (i + 1));
                for (right, columns) in panels[GROUP * group..=i].iter().zip(columns.chunks_mut(size * TILE)) {
                    for (column, sums) in columns.chunks_exact_mut(size).zip(tile(below, right)) {
                        column[rows.clone()].iter_mut().zip(sums).for_each(|(product, sum)| *product += sum);
                    }
                }
            }
        });
    }

    /// The products of each column of `below` with each of `right`, by the columns of `right`. The sums have names so
    /// that they stay in registers; where there are 16, four columns fit at a time.
    #[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
    fn tile(below: &[[f64; TILE]], right: &[[f64; TILE]]) -> [[f64; TILE]; TILE] {
        let zero = [0.0; TILE];
        let (mut a, mut b, mut c, mut d) = (zero, zero, zero, zero);
        let (mut e, mut f, mut g, mut h) = (zero, zero, zero, zero);
        if target_cfg_f!(target_feature = "avx512f") {
            for (column, by) in below.iter().zip(right) {
                add_scaled(&mut a, column, by[0]);
                add_scaled(&mut b, column, by[1]);
                add_scaled(&mut c, column, by[2]);
                add_scaled(&mut d, column, by[3]);
                add_scaled(&mut e, column, by[4]);
                add_scaled(&mut f, column, by[5]);
                add_scaled(&mut g, column, by[6]);
                add_scaled(&mut h, column, by[7]);
            }
        } else {
            for (column, by) in below.iter().zip(right) {
                add_scaled(&mut a, column, by[0]);
                add_scaled(&mut b, column, by[1]);
                add_scaled(&mut c, column, by[2]);
                add_scaled(&mut d, column, by[3]);
            }
            for (column, by) in below.iter().zip(right) {
                add_scaled(&mut e, column, by[4]);
                add_scaled(&mut f, column, by[5]);
                add_scaled(&mut g, column, by[6]);
                add_scaled(&mut h, column, by[7]);
            }
        }
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn add_scaled(sums: &mut [f64; TILE], column: &[f64; TILE], by: f64) {
        for r in 0..TILE {
            sums[r] += column[r] * by;
        }
    }
}

#[cfg(target_arch = "wasm32")]
pub(crate) use tiles::add;

#[cfg(target_arch = "wasm32")]
mod tiles {
    use core::arch::wasm32::{f64x2, f64x2_add, f64x2_extract_lane, f64x2_mul, f64x2_splat, v128};
    use nalgebra::DMatrix;

    /// Columns of a tile.
    const TILE: usize = 4;

    /// Adds the products of `rows`, one sample after the other, to the lower triangle of `gram`.
    pub(crate) fn add(gram: &mut DMatrix<f64>, rows: &[f64]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn products_are_summed_in_the_order_of_samples_to_the_bit() {
        for (size, samples) in [(1, 3), (4, 1), (8, 20), (9, 64), (23, 100), (71, 256)] {
            let rows: Vec<f64> = (0..size * samples).map(|k| (k as f64 * 0.37).sin()).collect();
            let mut gram = DMatrix::from_element(size, size, 0.5);
            add(&mut gram, &rows);
            for (k, i) in (0..size).flat_map(|k| (k..size).map(move |i| (k, i))) {
                let sum = rows.chunks_exact(size).fold(0.0, |sum, row| sum + row[i] * row[k]);
                assert_eq!(gram[(i, k)], 0.5 + sum, "{size} columns: {i}, {k}");
            }
        }
    }
}
