//! Exact least absolute deviations: the reference solution for searches of the same optimum.
//!
//! ```text
//! min over x of sum_i |y_i - a_i' x|   is   min sum_i t_i  subject to  -t_i <= y_i - a_i' x <= t_i
//! ```
//! An interior-point method (Clarabel) solves this linear program (Charnes, Cooper & Ferguson 1955,
//! doi:10.1287/mnsc.1.2.138). The dual problem gives a certificate: no x has a cost below the bound.

use crate::error::Error;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// The optimum and its certificate.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastAbsolute {
    /// The optimal x.
    pub x: Vec<f64>,
    /// Sum of absolute deviations at x.
    pub cost: f64,
    /// No x has a smaller cost than this (up to rounding).
    pub bound: f64,
}

/// The x that minimises sum_i |y_i - a_i' x|. `rows` are `[y_i, a_i...]` one after another, with `dimension` numbers in
/// each a_i. Returns an error if a number is not finite; [`Error::Unidentifiable`] if the solver finds no optimum.
pub fn least_absolute(rows: &[f64], dimension: usize) -> Result<LeastAbsolute, Error> {
    crate::error::finite("rows", rows)?;
    let stride = dimension + 1;
    let n = rows.len() / stride;
    // Columns are scaled to one size, so that the tolerances of the solver mean the same in each.
    let size: Vec<f64> = (0..stride)
        .map(|k| rows.iter().skip(k).step_by(stride).fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs())))
        .collect();

    // Constraints A [x; t] + s = b, s >= 0: a'x - t <= y in rows 0..n, -a'x - t <= -y in rows n..2n.
    let mut column_start = vec![0];
    let (mut row_index, mut values) = (Vec::new(), Vec::new());
    for k in 1..stride {
        for sign in [1.0, -1.0] {
            for i in 0..n {
                row_index.push(if sign > 0.0 { i } else { n + i });
                values.push(sign * rows[i * stride + k] / size[k]);
            }
        }
        column_start.push(values.len());
    }
    for i in 0..n {
        row_index.extend([i, n + i]);
        values.extend([-1.0, -1.0]);
        column_start.push(values.len());
    }
    let constraints = CscMatrix::new(2 * n, dimension + n, column_start, row_index, values);
    let y = |i: usize| rows[i * stride] / size[0];
    let right: Vec<f64> = (0..n).map(y).chain((0..n).map(|i| -y(i))).collect();
    let price: Vec<f64> = (0..dimension + n).map(|k| f64::from(u8::from(k >= dimension))).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    };
    let nothing = CscMatrix::zeros((dimension + n, dimension + n));
    let cones = [SupportedConeT::NonnegativeConeT(2 * n)];
    let failed = |why: String| Error::Unidentifiable {
        what: "the least-absolute fit".into(),
        because: format!("{why}; check that the regressors are independent"),
    };
    let mut solver = DefaultSolver::new(&nothing, &price, &constraints, &right, &cones, settings)
        .map_err(|e| failed(e.to_string()))?;
    solver.solve();

    let x: Vec<f64> = (1..stride).map(|k| solver.solution.x[k - 1] * size[0] / size[k]).collect();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    if !solved || !x.iter().all(|v| v.is_finite()) {
        return Err(failed(format!("the solver ended with {:?}", solver.solution.status)));
    }
    let deviation = |row: &[f64]| (row[0] - row[1..].iter().zip(&x).map(|(a, x)| a * x).sum::<f64>()).abs();
    let cost = rows.chunks_exact(stride).map(deviation).sum();
    Ok(LeastAbsolute { x, cost, bound: solver.solution.obj_val_dual * size[0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_optimum_meets_its_bound_and_ignores_an_outlier() {
        // A line through nine points, and an outlier that would change a least-squares fit.
        let mut rows: Vec<f64> = (0..10).flat_map(|i| [2.0 + 3.0 * f64::from(i), 1.0, f64::from(i)]).collect();
        rows[27] += 1000.0;
        let fit = least_absolute(&rows, 2).unwrap();
        piezoid_testing::assert_close(&fit.x, &[2.0, 3.0], 1e-7, 1e-7);
        piezoid_testing::assert_close(&[fit.bound], &[fit.cost], 1e-7, 1e-7);
    }

    #[test]
    fn the_fit_of_a_constant_is_the_median() {
        let fit = least_absolute(&[1.0, 1.0, 2.0, 1.0, 99.0, 1.0], 1).unwrap();
        assert!((fit.x[0] - 2.0).abs() < 1e-6);
    }
}
