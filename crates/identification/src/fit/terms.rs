//! Forward selection of the terms of an operator, by orthogonal least squares.
//!
//! ```text
//! error reduction ratio of term k = g_k^2 / (h_kk y'y),    h and g after all selected terms are eliminated
//! ```
//! The terms are the columns of the free-run error, behind creep and linear block, so they need no measured z. The term
//! with the largest ratio is selected, until none takes a hundredth of what is left. Terms are selected twice: with the
//! operator's own shape, and with the shape that fits best with all terms, where the columns of creep and shape are
//! eliminated first, so that no term stands for another shape. Held-out errors decide between the two.
//!
//! S. Chen, S. A. Billings & W. Luo, Int. J. Control 50, 1873 (1989), DOI 10.1080/00207178908953472.

use super::estimate::Estimate;
use super::iterate::Iterate;
use super::layout::ColumnLayout;
use super::refine::{StepCallback, refine_from_unknown};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::error::Error;

/// Least share of the remaining sum of squares that a further term takes.
const LEAST_SHARE: f64 = 0.01;

/// Share of its sum of squares that a term must have beside those selected: less is rounding.
const INDEPENDENT: f64 = 1e-11;

/// The estimate with the terms of its operator that these runs show, with its own shape, and with that of a fit; the
/// same alone if the operator selects none.
///
/// # Errors
/// The errors of `watch`.
pub(crate) fn with_selected_terms(
    estimate: Estimate,
    runs: &[TrainingRecord],
    watch: StepCallback,
) -> Result<Vec<Estimate>, Error> {
    let n = estimate.weights.len();
    let all: Vec<usize> = (0..n).collect();
    if estimate.basis.with_terms(&all).is_none() {
        return Ok(vec![estimate]);
    }
    let fit = refine_from_unknown(estimate.clone(), 0.0, &mut runs.to_vec(), FreeParameters::Shape, watch)?;
    let own = Iterate::at(estimate.clone(), runs, &[], FreeParameters::Weights);
    let fitted = Iterate::known(fit.estimate, runs, FreeParameters::Shape);
    let with_terms = |point: &Iterate, end: usize| {
        let (h, g) = (point.normal.h.view((0, 0), (end, end)).into_owned(), point.normal.g.rows(0, end).into_owned());
        let basis = point.estimate.basis.with_terms(&selected(h, g, point.normal.yy, n))?;
        Some(estimate.with_basis(basis))
    };
    let end = ColumnLayout::of(&fitted.estimate).shape.end;
    Ok([with_terms(&own, n), with_terms(&fitted, end)].into_iter().flatten().collect())
}

/// The numbers of the terms that are selected among the first `n` columns after the others are eliminated, ascending;
/// at least one.
fn selected(mut h: DMatrix<f64>, mut g: DVector<f64>, mut left: f64, n: usize) -> Vec<usize> {
    let whole = h.diagonal();
    let is_independent = |h: &DMatrix<f64>, k: usize| h[(k, k)] > INDEPENDENT * whole[k];
    for k in n..g.len() {
        if is_independent(&h, k) {
            left = eliminated(&mut h, &mut g, left, k);
        }
    }
    let mut selected = Vec::new();
    loop {
        let taken = |k: usize| g[k] * g[k] / h[(k, k)];
        let others = (0..n).filter(|k| !selected.contains(k) && is_independent(&h, *k));
        let Some(best) = others.max_by(|&p, &q| taken(p).total_cmp(&taken(q))) else { break };
        if !selected.is_empty() && taken(best) < LEAST_SHARE * left {
            break;
        }
        left = eliminated(&mut h, &mut g, left, best);
        selected.push(best);
    }
    if selected.is_empty() {
        selected.push(0);
    }
    selected.sort_unstable();
    selected
}

/// Eliminates the column `k`; returns what is `left` of the sum of squares.
fn eliminated(h: &mut DMatrix<f64>, g: &mut DVector<f64>, left: f64, k: usize) -> f64 {
    let (column, step, size) = (h.column(k).into_owned(), g[k], h[(k, k)]);
    *h -= &column * column.transpose() / size;
    g.axpy(-step / size, &column, 1.0);
    (left - step * step / size).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::runs::training_records;
    use super::super::testing::estimate;
    use super::*;
    use piezoid_models::hysteresis::Operator;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;

    #[test]
    fn the_terms_of_the_truth_are_selected_and_terms_without_effect_are_not() {
        let column = |k: usize, t: usize| (0.7 * (k + 1) as f64 * t as f64 + k as f64).sin();
        let x = DMatrix::from_fn(400, 6, |t, k| column(k, t));
        let noise = DVector::from_fn(400, |t, _| 0.01 * column(9, t));
        let y = 2.0 * x.column(4) - 0.5 * x.column(1) + noise;
        assert_eq!(selected(x.tr_mul(&x), x.tr_mul(&y), y.norm_squared(), 6), [1, 4]);
        // The last column is no term, and what it explains needs none.
        let others = x.columns_range(0..5).into_owned();
        let z = 2.0 * x.column(4) - 0.5 * x.column(1);
        assert_eq!(selected(others.tr_mul(&others), others.tr_mul(&z), z.norm_squared(), 4), [1]);
        // Two equal columns: one suffices.
        let twice = DMatrix::from_columns(&[x.column(1), x.column(1), x.column(4)]);
        assert_eq!(selected(twice.tr_mul(&twice), twice.tr_mul(&y), y.norm_squared(), 3).len(), 2);
        assert_eq!(selected(DMatrix::zeros(3, 3), DVector::zeros(3), 0.0, 3), [0]);
    }

    #[test]
    fn records_of_few_terms_leave_few_terms() {
        let u: Vec<f64> = (0..3000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let start = estimate("narx", 5);
        // f_1 and k_0 alone.
        let all = start.weights.len();
        let weights: Vec<f64> = (0..all).map(|k| if k == 0 || k == 5 { 1.0 } else { 0.0 }).collect();
        let z = start.basis.operator(&weights).unwrap().simulate(&u);
        let records = [Record::new(5e-4, u, start.linear.simulate(&z)).unwrap()];
        let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let found = with_selected_terms(start, &runs, &mut |_| Ok(())).unwrap();
        assert_eq!(found.len(), 2);
        for found in found {
            assert!(found.weights.len() < all, "{} of {all}", found.weights.len());
            assert_eq!(found.basis.operator(&vec![1.0; found.weights.len()]).unwrap().operator().name, "narx");
        }
        let plays = estimate("prandtl-ishlinskii", 5);
        let same = with_selected_terms(plays.clone(), &runs, &mut |_| Ok(())).unwrap();
        assert!(same.len() == 1 && same[0].weights.len() == plays.weights.len(), "a law keeps its terms");
        assert!(Operator::find("narx").unwrap().is_learned());
    }
}
