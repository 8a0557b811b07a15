//! The part of a series that a regression on the input explains, without a model.
//!
//! ```text
//! x_t = c + d t + sum over lags j of g_j u_{t-j} + r_t
//! ```
//! by least squares with a ridge. Neighbouring inputs are nearly equal; without the ridge, large weights of both signs
//! would turn transients into spikes. A few lags do not cover the decay of a resonance; its residual is smooth.

use crate::series::mean;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The part of `x` that is explained by `u` at these lags. Before and after the record the input is assumed constant.
/// The constant and the trend are fitted but not returned. `ridge` is relative to the mean square of the input.
pub(super) fn by_input(u: &[f64], x: &[f64], lags: Range<isize>, ridge: f64) -> Vec<f64> {
    let (middle, level, n) = (mean(u), mean(x), u.len());
    let last = n as isize - 1;
    let scale = (u.iter().map(|u| (u - middle).powi(2)).sum::<f64>() / n as f64).sqrt();
    let columns = 2 + lags.len();
    let fill = |row: &mut [f64], t: usize| {
        row[0] = 1.0;
        row[1] = 2.0 * t as f64 / n as f64 - 1.0;
        for (cell, lag) in row[2..].iter_mut().zip(lags.clone()) {
            *cell = (u[(t as isize - lag).clamp(0, last) as usize] - middle) / scale;
        }
    };
    let mut row = vec![0.0; columns];
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(columns, columns), DVector::<f64>::zeros(columns));
    for (t, x) in x.iter().enumerate() {
        fill(&mut row, t);
        for i in 0..columns {
            right[i] += row[i] * (x - level);
            for j in 0..=i {
                normal[(i, j)] += row[i] * row[j];
            }
        }
    }
    normal.fill_upper_triangle_with_lower_triangle();
    (0..columns).for_each(|i| normal[(i, i)] += ridge * n as f64);
    let theta = normal.cholesky().map_or_else(|| DVector::zeros(columns), |c| c.solve(&right));
    let explained = (0..n).map(|t| {
        fill(&mut row, t);
        row[2..].iter().zip(theta.iter().skip(2)).map(|(x, g)| x * g).sum()
    });
    explained.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn a_sum_of_lagged_inputs_is_explained_independently_of_the_trend() {
        let u = crate::excitation::Prbs::default().samples(1.0, 400).unwrap();
        let part = |t: usize| 2.0 * u[t - 1] - 0.5 * u[t - 3];
        let x: Vec<f64> = (0..400).map(|t| 7.0 + 0.01 * t as f64 + if t > 2 { part(t) } else { 0.0 }).collect();
        let explained = by_input(&u, &x, 0..5, 1e-9);
        let expected: Vec<f64> = (3..400).map(part).collect();
        let shift = mean(&expected) - mean(&explained[3..]);
        let explained: Vec<f64> = explained[3..].iter().map(|e| e + shift).collect();
        assert_close(&explained, &expected, 0.0, 0.1);
    }
}
