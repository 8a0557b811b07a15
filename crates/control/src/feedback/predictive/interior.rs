//! The quadratic program of [`Condensed`] by an interior-point method, as its reference solution.
//!
//! ```text
//! min over x, e of  1/2 x' H x - g' x + 1/2 sigma sum e_i^2     low_i <= a_i' x - e_i <= high_i, e_i = 0 on hard rows
//! ```
//! Reference: P. J. Goulart, Y. Chen, arXiv:2405.12762 (2024) (Clarabel). It does not do: warm starts, which do not
//! help interior-point methods, and buffers of fixed size.

use super::condensed::Condensed;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// The x for `g` and the limits `low` and `high` of the rows; `None` if the solver finds no optimum.
pub(super) fn solve(program: &Condensed, g: &[f64], low: &[f64], high: &[f64]) -> Option<Vec<f64>> {
    let n = g.len();
    let soft: Vec<usize> = (0..program.sigma.len()).filter(|&i| program.sigma[i].is_finite()).collect();
    // Each finite limit is a row a' x - e + s = limit of the cone s >= 0; rows of lower limits have the opposite sign.
    let ends = [(1.0, high), (-1.0, low)].into_iter();
    let rows: Vec<(usize, f64, f64)> = ends
        .flat_map(|(sign, limit)| limit.iter().enumerate().map(move |(i, limit)| (i, sign, sign * limit)))
        .filter(|(.., limit)| limit.is_finite())
        .collect();

    let columns = n + soft.len();
    let (mut start, mut index, mut values) = (vec![0], Vec::new(), Vec::new());
    for k in 0..columns {
        for (row, &(i, sign, _)) in rows.iter().enumerate() {
            let value = if k < n { program.a[(i, k)] } else { -f64::from(u8::from(soft[k - n] == i)) };
            if value != 0.0 {
                index.push(row);
                values.push(sign * value);
            }
        }
        start.push(values.len());
    }
    let constraints = CscMatrix::new(rows.len(), columns, start, index, values);

    let (mut start, mut index, mut values) = (vec![0], Vec::new(), Vec::new());
    for k in 0..columns {
        let from = if k < n { 0 } else { k };
        for i in from..=k {
            index.push(i);
            values.push(if k < n { program.h[(i, k)] } else { program.sigma[soft[k - n]] });
        }
        start.push(values.len());
    }
    let curvature = CscMatrix::new(columns, columns, start, index, values);

    let mut price: Vec<f64> = g.iter().map(|g| -g).collect();
    price.resize(columns, 0.0);
    let right: Vec<f64> = rows.iter().map(|(.., limit)| *limit).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        ..Default::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(rows.len())];
    let mut solver = DefaultSolver::new(&curvature, &price, &constraints, &right, &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    let x = &solver.solution.x[..n];
    (solved && x.iter().all(|v| v.is_finite())).then(|| x.to_vec())
}
