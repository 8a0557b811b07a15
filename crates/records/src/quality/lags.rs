//! Least squares on a series and its lags, for records of any length.
//!
//! Shifting two columns by a sample drops the last product of their samples and adds one before the first, so that
//! only the products with the first lag are sums over all rows.

use nalgebra::{DMatrix, DVector};
use piezoid_numerics::series::dot_wide;

/// Columns of one series, each one sample earlier than the column before it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lags<'a> {
    /// The samples of the last column before its first row, then the rows of the first column.
    series: &'a [f64],
    count: usize,
}

impl<'a> Lags<'a> {
    /// `count` columns; they are shorter than the series by `count - 1` rows.
    pub(super) fn new(series: &'a [f64], count: usize) -> Self {
        Lags { series, count }
    }

    pub(super) fn rows(&self) -> usize {
        self.series.len() + 1 - self.count
    }

    fn column(&self, lag: usize) -> &'a [f64] {
        &self.series[self.count - 1 - lag..][..self.rows()]
    }

    /// The products of each column with `x`.
    pub(super) fn with(&self, x: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.count, |lag, _| dot_wide::<8>(self.column(lag), x))
    }

    /// The products of each column with each of `other`, which has as many rows.
    pub(super) fn products(&self, other: &Lags) -> DMatrix<f64> {
        let mut products = DMatrix::zeros(self.count, other.count);
        products.set_column(0, &self.with(other.column(0)));
        products.set_row(0, &other.with(self.column(0)).transpose());
        // The sample of a column before its first row is the first of the next column.
        let first = |lags: &Lags, lag: usize| lags.column(lag)[0];
        let last = |lags: &Lags, lag: usize| lags.column(lag)[lags.rows() - 1];
        for i in 1..self.count {
            for j in 1..other.count {
                products[(i, j)] = products[(i - 1, j - 1)] + first(self, i) * first(other, j)
                    - last(self, i - 1) * last(other, j - 1);
            }
        }
        products
    }

    /// Adds the sum of the columns with these weights.
    pub(super) fn add_to(&self, sum: &mut [f64], weights: impl Iterator<Item = f64>) {
        for (lag, weight) in weights.enumerate() {
            sum.iter_mut().zip(self.column(lag)).for_each(|(sum, x)| *sum += weight * x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn products_and_sums_are_those_of_the_shifted_columns() {
        let wave = |f: f64| (0..60).map(|t| (f * t as f64).sin() + 0.1 * f).collect::<Vec<f64>>();
        let (u, y) = (wave(0.7), wave(1.9));
        let (a, b) = (Lags::new(&u, 11), Lags::new(&y[6..], 5));
        let expected = |i: usize, j: usize| (0..50).map(|t| u[t + 10 - i] * y[t + 10 - j]).sum::<f64>();
        for (i, j) in (0..11).flat_map(|i| (0..5).map(move |j| (i, j))) {
            assert_close(&[a.products(&b)[(i, j)]], &[expected(i, j)], 0.0, 1e-12);
        }
        let sum: Vec<f64> = (0..50).map(|t| 2.0 * y[t + 10] - 3.0 * y[t + 8]).collect();
        let mut combined = vec![0.0; 50];
        b.add_to(&mut combined, [2.0, 0.0, -3.0].into_iter());
        assert_close(&combined, &sum, 0.0, 1e-12);
    }
}
