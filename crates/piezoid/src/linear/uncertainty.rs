//! todo

use super::free_run::{FreeRunError, dot};
use crate::optimize::levenberg_marquardt::SumOfSquares;
use nalgebra::DMatrix;

/// Covariance of theta: inv(H) S inv(H), H = sum w J'J and S = sum w^2 J' R J.
pub(super) fn covariance(problem: &FreeRunError, theta: &[f64]) -> Vec<f64> {
    let d = problem.dimension();
    let Some(inverse) = problem.normal(theta).inverse() else { return vec![f64::INFINITY; d * d] };
    let inverse = DMatrix::from_row_slice(d, d, &inverse);
    let mut middle = DMatrix::zeros(d, d);
    for (run, weight) in problem.runs(theta) {
        let n = run.e.len();
        let columns = run.jacobian();
        let lags = (2.0 * (n as f64).cbrt()).ceil() as usize;
        // Samples less what was fitted to them.
        let share = n as f64 / (n - (n / 2).min(d + 1)) as f64;
        let kernel: Vec<f64> = (0..=lags.min(n - 1))
            .map(|l| share * (1.0 - l as f64 / (lags + 1) as f64) * dot(&run.e[l..], &run.e[..n - l]) / n as f64)
            .collect();
        let smoothed: Vec<Vec<f64>> = columns.iter().map(|c| banded(&kernel, c)).collect();
        middle += weight * weight * DMatrix::from_fn(d, d, |i, j| dot(&columns[i], &smoothed[j]));
    }
    let covariance = &inverse * middle * &inverse;
    covariance.transpose().iter().copied().collect()
}

/// R x, for the symmetric band matrix R with `kernel` on its diagonals.
fn banded(kernel: &[f64], x: &[f64]) -> Vec<f64> {
    let mut sum: Vec<f64> = x.iter().map(|x| kernel[0] * x).collect();
    for (l, k) in kernel.iter().enumerate().skip(1) {
        sum[l..].iter_mut().zip(x).for_each(|(s, x)| *s += k * x);
        sum.iter_mut().zip(&x[l..]).for_each(|(s, x)| *s += k * x);
    }
    sum
}
