//! The part of a series that a regression on the input explains, without a model.
//!
//! ```text
//! x_t = c + d t + sum over lags j of g_j u_{t-j} + r_t
//! ```
//! by least squares with a ridge. Neighbouring inputs are nearly equal; without the ridge, large weights of both signs
//! would turn transients into spikes. A few lags do not cover the decay of a resonance; its residual is smooth.

use super::lags::Lags;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::series::{dot_wide, mean, scatter};
use std::ops::Range;

/// The part of `x` that is explained by `u` at these lags. Before and after the record the input is assumed constant.
/// The constant and the trend are fitted but not returned. `ridge` is relative to the mean square of the input.
pub(super) fn by_input(u: &[f64], x: &[f64], lags: Range<isize>, ridge: f64) -> Vec<f64> {
    let (middle, n) = (mean(u), u.len());
    let scale = (scatter(u) / n as f64).sqrt();
    let held = |t: isize| (u[t.clamp(0, n as isize - 1) as usize] - middle) / scale;
    // From the input of the largest lag at the first row to that of the smallest at the last.
    let input: Vec<f64> = (1 - lags.end..n as isize - lags.start).map(held).collect();
    let lagged = Lags::new(&input, lags.len());
    let line: [fn(f64) -> f64; 2] = [|_| 1.0, |part| 2.0 * part - 1.0];
    let part = |t: usize| t as f64 / n as f64;
    let columns = line.len() + lags.len();
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(columns, columns), DVector::<f64>::zeros(columns));
    for (i, of) in line.iter().enumerate() {
        // A column at a time: a record may have a hundred million samples.
        let column: Vec<f64> = (0..n).map(|t| of(part(t))).collect();
        right[i] = dot_wide::<8>(&column, x);
        (0..=i).for_each(|j| normal[(i, j)] = column.iter().zip(0..).map(|(c, t)| c * line[j](part(t))).sum());
        normal.view_mut((line.len(), i), (lags.len(), 1)).copy_from(&lagged.with(&column));
    }
    right.rows_mut(line.len(), lags.len()).copy_from(&lagged.with(x));
    // The products with the series about its mean: the first column is constant.
    right -= normal.column(0) * mean(x);
    normal.view_mut((line.len(), line.len()), (lags.len(), lags.len())).copy_from(&lagged.products(&lagged));
    normal.fill_upper_triangle_with_lower_triangle();
    (0..columns).for_each(|i| normal[(i, i)] += ridge * n as f64);
    let theta = normal.cholesky().map_or_else(|| DVector::zeros(columns), |c| c.solve(&right));
    let mut explained = vec![0.0; n];
    lagged.add_to(&mut explained, theta.iter().skip(line.len()).copied());
    explained
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

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
