//! The weights of a hysteresis in feedback in the search of all parameters: hundreds, whose derivatives along the
//! records are kept while a search goes on, and which are smooth.

use super::free_run::{FreeRun, Whole};
use crate::fit::roughness;
use nalgebra::{DMatrix, DVector};
use piezoid_models::hysteresis::Basis;
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::levenberg_marquardt::NormalEquations;
use rayon::prelude::*;

/// Factor of the squared roughness, over the mean diagonal of the normal matrix of the weights.
const SMOOTHNESS: f64 = 1e-2;

/// Samples, and weights, whose products are summed at once.
const ROWS: usize = 2048;
const BLOCK: usize = 256;

/// The weights, whose derivatives are those at the start of a search.
pub(super) struct Weights {
    /// Of each record: the derivatives, by sample and weight.
    columns: Vec<DMatrix<f32>>,
    /// The penalty: its matrix.
    roughness: DMatrix<f64>,
    /// The normal matrix of the weights, with the penalty.
    normal: DMatrix<f64>,
}

impl Weights {
    /// The weights of the basis, which are the last parameters of the start of this search.
    ///
    /// # Errors
    /// Returns an error if the operator has no derivatives.
    pub(super) fn at_start(of: &FreeRun, basis: &dyn Basis) -> Result<Self, Error> {
        let (parameters, n) = (of.start.parameters().len(), basis.len());
        let column = |run: &super::Run| {
            let whole = Whole::of(run, of.gain);
            let mut columns = DMatrix::zeros(run.record.len(), n);
            // In blocks, because they take twice the memory before they are stored.
            for from in (0..n).step_by(BLOCK) {
                let which = parameters - n + from..parameters - n + n.min(from + BLOCK);
                let (_, slopes) = of.start.sensitivities(whole.run(), which)?;
                for (k, mut slope) in slopes.into_iter().enumerate() {
                    let inside = &mut slope[whole.inside.clone()];
                    run.mask(inside);
                    columns.column_mut(from + k).iter_mut().zip(inside).for_each(|(column, s)| *column = *s as f32);
                }
            }
            Ok(columns)
        };
        let columns = of.runs.iter().map(column).collect::<Result<Vec<_>, Error>>()?;
        let mut normal = DMatrix::zeros(n, n);
        for (columns, run) in columns.iter().zip(of.runs) {
            normal += products(columns) * run.weight;
        }
        let roughness = roughness(basis) * (SMOOTHNESS * normal.trace() / n as f64);
        normal += &roughness;
        Ok(Weights { columns, roughness, normal })
    }

    pub(super) fn len(&self) -> usize {
        self.normal.nrows()
    }

    /// The penalty of these weights.
    pub(super) fn penalty(&self, weights: &[f64]) -> f64 {
        let weights = DVector::from_column_slice(weights);
        weights.dot(&(&self.roughness * &weights))
    }

    /// Adds the products of their derivatives along record `k` with the error there, and with the derivatives by the
    /// parameters before them.
    pub(super) fn add(
        &self,
        k: usize,
        (others, error, weight): (&[DVector<f64>], &DVector<f64>, f64),
        sums: &mut NormalEquations,
    ) {
        let (d, first) = (sums.gradient.len(), others.len());
        let of = |j: usize| {
            let column = self.columns[k].column(j).map(f64::from);
            let with = others.iter().map(|other| weight * column.dot(other)).collect::<Vec<_>>();
            (weight * column.dot(error), with)
        };
        let products: Vec<_> = (0..self.len()).into_par_iter().map(of).collect();
        for (j, (with_error, with_others)) in products.into_iter().enumerate() {
            sums.gradient[first + j] += with_error;
            for (i, with) in with_others.into_iter().enumerate() {
                sums.hessian[i * d + first + j] += with;
                sums.hessian[(first + j) * d + i] += with;
            }
        }
    }

    /// Adds what depends on the weights alone.
    pub(super) fn add_own(&self, weights: &[f64], sums: &mut NormalEquations) {
        let (d, first) = (sums.gradient.len(), sums.gradient.len() - self.len());
        sums.cost += self.penalty(weights);
        let pull = &self.roughness * DVector::from_column_slice(weights);
        for i in 0..self.len() {
            sums.gradient[first + i] += pull[i];
            (0..self.len()).for_each(|j| sums.hessian[(first + i) * d + first + j] = self.normal[(i, j)]);
        }
    }
}

/// The products of all columns with each other.
fn products(columns: &DMatrix<f32>) -> DMatrix<f64> {
    let n = columns.ncols();
    let blocks: Vec<(usize, usize)> =
        (0..n).step_by(BLOCK).flat_map(|i| (0..=i).step_by(BLOCK).map(move |j| (i, j))).collect();
    let of = |&(i, j): &(usize, usize)| {
        let mut sum = DMatrix::zeros(BLOCK.min(n - i), BLOCK.min(n - j));
        for row in (0..columns.nrows()).step_by(ROWS) {
            let part =
                |k: usize| columns.view((row, k), (ROWS.min(columns.nrows() - row), BLOCK.min(n - k))).map(f64::from);
            sum += part(i).transpose() * part(j);
        }
        sum
    };
    let sums: Vec<DMatrix<f64>> = blocks.par_iter().map(of).collect();
    let mut all = DMatrix::zeros(n, n);
    for ((i, j), sum) in blocks.into_iter().zip(sums) {
        all.view_mut((i, j), sum.shape()).copy_from(&sum);
        all.view_mut((j, i), (sum.ncols(), sum.nrows())).copy_from(&sum.transpose());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_more_columns_and_rows_than_a_block_are_those_of_all() {
        let columns = DMatrix::from_fn(ROWS + 12, BLOCK + 14, |t, k| ((7 * t + 13 * k + t * k) % 11) as f32 - 5.0);
        let all = columns.map(f64::from);
        // Whole numbers: the order of sums does not matter.
        assert_eq!(products(&columns), all.tr_mul(&all));
    }
}
