//! Forward selection of the terms of an operator, by orthogonal least squares.
//!
//! ```text
//! error reduction ratio of term k = g_k^2 / (h_kk y'y),    h and g after all selected terms are eliminated
//! ```
//! The terms are the columns of the free-run error, behind creep and linear block, so they need no measured z. The term
//! with the largest ratio is selected, until none takes a hundredth of what is left.
//!
//! S. Chen, S. A. Billings & W. Luo, Int. J. Control 50, 1873 (1989), DOI 10.1080/00207178908953472.

use super::estimate::Estimate;
use super::iterate::Iterate;
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use nalgebra::{DMatrix, DVector};

/// Least share of the remaining sum of squares that a further term takes.
const LEAST_SHARE: f64 = 0.01;

/// Share of its sum of squares that a term must have beside those selected: less is rounding.
const INDEPENDENT: f64 = 1e-11;

/// The estimate with the terms of its operator that these runs show; the same if the operator selects none.
pub(crate) fn with_selected_terms(estimate: Estimate, runs: &[TrainingRecord]) -> Estimate {
    let all: Vec<usize> = (0..estimate.weights.len()).collect();
    if estimate.basis.with_terms(&all).is_none() {
        return estimate;
    }
    let point = Iterate::at(estimate, runs, &[], FreeParameters::Weights);
    let n = all.len();
    let (h, g) = (point.normal.h.view((0, 0), (n, n)).into_owned(), point.normal.g.rows(0, n).into_owned());
    match point.estimate.basis.with_terms(&selected(h, g, point.normal.yy)) {
        Some(basis) => point.estimate.with_basis(basis),
        None => point.estimate,
    }
}

/// The numbers of the selected terms, ascending; at least one.
fn selected(mut h: DMatrix<f64>, mut g: DVector<f64>, mut left: f64) -> Vec<usize> {
    let whole = h.diagonal();
    let mut selected = Vec::new();
    loop {
        let taken = |k: usize| g[k] * g[k] / h[(k, k)];
        let others = (0..g.len()).filter(|&k| !selected.contains(&k) && h[(k, k)] > INDEPENDENT * whole[k]);
        let Some(best) = others.max_by(|&p, &q| taken(p).total_cmp(&taken(q))) else { break };
        let gain = taken(best);
        if !selected.is_empty() && gain < LEAST_SHARE * left {
            break;
        }
        let (column, step, size) = (h.column(best).into_owned(), g[best], h[(best, best)]);
        h -= &column * column.transpose() / size;
        g.axpy(-step / size, &column, 1.0);
        left = (left - gain).max(0.0);
        selected.push(best);
    }
    if selected.is_empty() {
        selected.push(0);
    }
    selected.sort_unstable();
    selected
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
        assert_eq!(selected(x.tr_mul(&x), x.tr_mul(&y), y.norm_squared()), [1, 4]);
        // Two equal columns: one suffices.
        let twice = DMatrix::from_columns(&[x.column(1), x.column(1), x.column(4)]);
        assert_eq!(selected(twice.tr_mul(&twice), twice.tr_mul(&y), y.norm_squared()).len(), 2);
        assert_eq!(selected(DMatrix::zeros(3, 3), DVector::zeros(3), 0.0), [0]);
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
        let found = with_selected_terms(start, &runs);
        assert!(found.weights.len() < all, "{} of {all}", found.weights.len());
        assert_eq!(found.basis.operator(&vec![1.0; found.weights.len()]).unwrap().operator().name, "narx");
        let plays = estimate("prandtl-ishlinskii", 5);
        let same = with_selected_terms(plays.clone(), &runs);
        assert_eq!(same.weights.len(), plays.weights.len(), "a law keeps its terms");
        assert!(Operator::find("narx").unwrap().learned);
    }
}
