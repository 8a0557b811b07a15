//! The products of columns with each other, X' X, which are most of the work of an identification.
//!
//! Each product is summed over a block of samples in their order, without fused multiply-add, so that it is the same to
//! the bit on every machine. Tiles of eight by eight columns stay in registers; for WebAssembly, of four by four.

use nalgebra::DMatrix;
use rayon::prelude::*;
use tracing::trace_span;

#[cfg(not(target_arch = "wasm32"))]
use native::{TILE, tile};
#[cfg(target_arch = "wasm32")]
use simd128::{TILE, tile};

/// Columns of the largest tile of all machines.
const LARGEST_TILE: usize = 8;

/// Panels beside each other that one thread computes.
const GROUP: usize = 8;

/// A block of rows, in panels of [`TILE`] columns that are beside each other for all rows.
pub(crate) struct Rows {
    size: usize,
    capacity: usize,
    len: usize,
    panels: Vec<[f64; TILE]>,
}

impl Rows {
    /// No rows yet, of at most `capacity`, with `size` columns.
    pub(crate) fn new(size: usize, capacity: usize) -> Self {
        let panels = vec![[0.0; TILE]; size.div_ceil(TILE) * capacity];
        Rows { size, capacity, len: 0, panels }
    }

    /// The number of the first `columns` that fill panels, the same on every machine.
    pub(crate) fn whole(columns: usize) -> usize {
        columns - columns % LARGEST_TILE
    }

    /// The number of further rows.
    pub(crate) fn room(&self) -> usize {
        self.capacity - self.len
    }

    /// Appends `n` rows of any content; returns the index of the first.
    pub(crate) fn extend(&mut self, n: usize) -> usize {
        assert!(n <= self.room(), "a block has at most {} rows", self.capacity);
        self.len += n;
        self.len - n
    }

    /// Sets the value in one column of a row.
    fn set(&mut self, row: usize, column: usize, value: f64) {
        self.panels[column / TILE * self.capacity + row][column % TILE] = value;
    }

    /// Sets the values in one column from a row on.
    pub(crate) fn set_column(&mut self, first: usize, column: usize, values: impl Iterator<Item = f64>) {
        let panel = &mut self.panels[column / TILE * self.capacity..][first..self.len];
        panel.iter_mut().zip(values).for_each(|(row, value)| row[column % TILE] = value);
    }

    /// The value in one column of a row.
    #[cfg(test)]
    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.panels[column / TILE * self.capacity + row][column % TILE]
    }

    /// Sets the values from a column on, each multiplied by `scale`.
    pub(crate) fn set_scaled(&mut self, row: usize, from: usize, values: &[f64], scale: f64) {
        let (unaligned, aligned) = values.split_at((from.next_multiple_of(TILE) - from).min(values.len()));
        let (whole, rest) = aligned.as_chunks::<TILE>();
        let single = |k: usize, value: &f64| (k, value * scale);
        for (column, value) in unaligned.iter().enumerate().map(|(k, value)| single(from + k, value)) {
            self.set(row, column, value);
        }
        let first = from + unaligned.len();
        for (k, values) in whole.iter().enumerate() {
            let panel = &mut self.panels[(first / TILE + k) * self.capacity + row];
            (0..TILE).for_each(|l| panel[l] = values[l] * scale);
        }
        for (column, value) in rest.iter().enumerate().map(|(k, value)| single(first + whole.len() * TILE + k, value)) {
            self.set(row, column, value);
        }
    }

    /// Adds the products of the rows to the lower triangle of `gram`, and empties the block. Those of the first `known`
    /// columns with each other are not added; their number is one of [`Rows::whole`].
    pub(crate) fn add_to(&mut self, gram: &mut DMatrix<f64>, known: usize) {
        let _span = trace_span!("products").entered();
        let (size, rows) = (self.size, std::mem::take(&mut self.len));
        let panels: Vec<&[[f64; TILE]]> = self.panels.chunks_exact(self.capacity).map(|panel| &panel[..rows]).collect();
        let of_group = |(group, columns): (usize, &mut [f64])| {
            for (i, below) in panels.iter().enumerate().skip((GROUP * group).max(known / TILE)) {
                let rows = TILE * i..size.min(TILE * (i + 1));
                for (right, columns) in panels[GROUP * group..=i].iter().zip(columns.chunks_mut(size * TILE)) {
                    for (column, sums) in columns.chunks_exact_mut(size).zip(tile(below, right)) {
                        column[rows.clone()].iter_mut().zip(sums).for_each(|(product, sum)| *product += sum);
                    }
                }
            }
        };
        gram.as_mut_slice().par_chunks_mut(size * TILE * GROUP).enumerate().for_each(of_group);
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use multiversion::{multiversion, target::target_cfg_f};

    /// Columns of a tile.
    pub(super) const TILE: usize = 8;

    /// The products of each column of `below` with each of `right`, by the columns of `right`. The sums have names so
    /// that they stay in registers; where there are 16, four columns fit at a time.
    #[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
    pub(super) fn tile(below: &[[f64; TILE]], right: &[[f64; TILE]]) -> [[f64; TILE]; TILE] {
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
mod simd128 {
    use wide::f64x4;

    /// Columns of a tile.
    pub(super) const TILE: usize = 4;

    /// The products of each column of `below` with each of `right`, by the columns of `right`. The sums have names so
    /// that they stay in registers.
    pub(super) fn tile(below: &[[f64; TILE]], right: &[[f64; TILE]]) -> [[f64; TILE]; TILE] {
        let zero = f64x4::ZERO;
        let (mut a, mut b, mut c, mut d) = (zero, zero, zero, zero);
        for (column, by) in below.iter().zip(right) {
            let column = f64x4::from(*column);
            a += column * f64x4::splat(by[0]);
            b += column * f64x4::splat(by[1]);
            c += column * f64x4::splat(by[2]);
            d += column * f64x4::splat(by[3]);
        }
        [a, b, c, d].map(f64x4::to_array)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_summed_in_the_order_of_samples_to_the_bit() {
        for (size, samples) in [(1, 3), (4, 1), (8, 20), (9, 64), (23, 100), (71, 256)] {
            let value = |row: usize, k: usize| ((row * size + k) as f64 * 0.37).sin();
            let mut rows = Rows::new(size, samples + 3);
            let mut gram = DMatrix::from_element(size, size, 0.5);
            // The second time with other rows, which are the only ones in the block.
            for (from, times) in [(0, 1.0), (5, 2.0)] {
                let first = rows.extend(samples);
                for row in 0..samples {
                    let values: Vec<f64> = (0..size).map(|k| value(from + row, k)).collect();
                    let (single, others) = values.split_at(size.min(3));
                    single.iter().enumerate().for_each(|(k, value)| rows.set(first + row, k, times * value));
                    rows.set_scaled(first + row, single.len(), others, times);
                }
                rows.add_to(&mut gram, 0);
            }
            for (k, i) in (0..size).flat_map(|k| (k..size).map(move |i| (k, i))) {
                let product = |from: usize, times: f64| {
                    let of = |row: usize| times * value(from + row, i) * (times * value(from + row, k));
                    (0..samples).fold(0.0, |sum, row| sum + of(row))
                };
                assert_eq!(gram[(i, k)], 0.5 + product(0, 1.0) + product(5, 2.0), "{size} columns: {i}, {k}");
            }
        }
    }

    #[test]
    fn known_products_end_with_a_panel_of_every_machine() {
        assert_eq!([0, 7, 8, 21, 64].map(Rows::whole), [0, 0, 8, 16, 64]);
    }
}
