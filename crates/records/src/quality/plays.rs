//! How well one signal follows another by hysteresis, without a model: a sum of plays and a curve.
//!
//! ```text
//! y_{t+d} = c + e t + sum over k of w_k P_k[u]_t + a u_t^2 + b u_t^3,   w_k >= 0
//! ```
//! by least squares for each delay d, with fixed thresholds. Weights of plays are not negative, so the loops turn as
//! those of ceramics do: y stays behind u. A signal that runs ahead is only fitted by a negative delay. Slow drives
//! show this at their turning points; the fit has no dynamics and means nothing near a resonance, where it leaves much.

use super::runs::standardised;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::number;
use piezoid_numerics::optimize::non_negative;
use piezoid_numerics::series::{dot_wide, ends, mean};

/// Number of plays. Their thresholds divide half the range of the input.
const PLAY_COUNT: usize = 8;

/// Number of columns: the square and the cube, with weights of any sign, and the plays.
const COLUMN_COUNT: usize = 2 + PLAY_COUNT;

/// Ridge, relative to the trace of the normal equations.
const RIDGE: f64 = 1e-9;

/// The rms residual, relative to the rms of `y`, for each delay from `-reach` to `reach` samples. `None` if one of the
/// signals is constant.
pub(super) fn residuals(u: &[f64], y: &[f64], reach: usize) -> Option<Vec<f64>> {
    let columns = columns(&u[..u.len() - reach], reach)?;
    let n = columns[0].len();
    let gram = DMatrix::from_fn(COLUMN_COUNT, COLUMN_COUNT, |i, j| dot(&columns[i], &columns[j]) / n as f64);
    let damped = &gram + DMatrix::identity(COLUMN_COUNT, COLUMN_COUNT) * (RIDGE * gram.trace());
    let share = |delay: usize| {
        let y = detrended(&standardised(&y[delay..delay + n])?);
        let right = DVector::from_fn(COLUMN_COUNT, |i, _| dot(&columns[i], &y) / n as f64);
        let w = weights(&damped, &right);
        Some((dot(&y, &y) / n as f64 - 2.0 * right.dot(&w) + (&gram * &w).dot(&w)).max(0.0).sqrt())
    };
    (0..=2 * reach).map(share).collect()
}

/// The part of `y` that hysteresis of `u` explains. The line over time is fitted but not returned. `None` if `u` is
/// constant.
pub(super) fn explained(u: &[f64], y: &[f64]) -> Option<Vec<f64>> {
    let columns = responses(u)?;
    let flat: Vec<Vec<f64>> = columns.iter().map(|column| detrended(column)).collect();
    let n = u.len() as f64;
    let gram = DMatrix::from_fn(COLUMN_COUNT, COLUMN_COUNT, |i, j| dot(&flat[i], &flat[j]) / n);
    let damped = &gram + DMatrix::identity(COLUMN_COUNT, COLUMN_COUNT) * (RIDGE * gram.trace());
    let y = detrended(y);
    // The first play has no width: it is the input itself.
    let sign = if dot(&flat[COLUMN_COUNT - PLAY_COUNT], &y) < 0.0 { -1.0 } else { 1.0 };
    let y: Vec<f64> = y.iter().map(|y| sign * y).collect();
    let w = weights(&damped, &DVector::from_fn(COLUMN_COUNT, |i, _| dot(&flat[i], &y) / n));
    Some((0..u.len()).map(|t| columns.iter().zip(&w).map(|(column, w)| sign * w * column[t]).sum()).collect())
}

/// The responses to `u` from sample `from` on, without their lines over time.
fn columns(u: &[f64], from: usize) -> Option<Vec<Vec<f64>>> {
    Some(responses(u)?.iter().map(|column| detrended(&column[from..])).collect())
}

/// The responses to `u`, which is at rest before: the square, the cube, and the plays.
fn responses(u: &[f64]) -> Option<Vec<Vec<f64>>> {
    let (low, high) = ends(u.iter().copied());
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    if half <= 0.0 {
        return None;
    }
    let v: Vec<f64> = u.iter().map(|u| (u - middle) / half).collect();
    let power = |p: i32| v.iter().map(|v| number::power(*v, p)).collect();
    let play = |k: usize| {
        let r = k as f64 / PLAY_COUNT as f64;
        v.iter().scan(v[0], move |s, v| {
            *s = s.clamp(v - r, v + r);
            Some(*s)
        })
    };
    Some([power(2), power(3)].into_iter().chain((0..PLAY_COUNT).map(|k| play(k).collect())).collect())
}

/// Least squares with weights that are not negative, except the first two.
fn weights(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let signed: Vec<bool> = (0..COLUMN_COUNT).map(|k| k >= COLUMN_COUNT - PLAY_COUNT).collect();
    non_negative(gram, right, &signed, &mut [true; COLUMN_COUNT]).unwrap_or_else(|| DVector::zeros(COLUMN_COUNT))
}

/// A series without its regression line over time.
fn detrended(x: &[f64]) -> Vec<f64> {
    let (mean, n) = (mean(x), x.len() as f64);
    let time = |t: usize| t as f64 - 0.5 * (n - 1.0);
    let slope = x.iter().enumerate().map(|(t, x)| time(t) * x).sum::<f64>() / (n * (n * n - 1.0) / 12.0).max(1.0);
    x.iter().enumerate().map(|(t, x)| x - mean - slope * time(t)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot_wide::<8>(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A random path and the sum of two plays of it.
    fn pair() -> (Vec<f64>, Vec<f64>) {
        let u: Vec<f64> = (0..3000).map(|t| f64::from(t) * 0.01).map(|t| t.sin() + (0.37 * t).sin()).collect();
        let (low, high) = ends(u.iter().copied());
        let half = 0.5 * (high - low);
        let play = |r: f64| {
            u.iter().scan(u[0], move |s, u| {
                *s = s.clamp(u - r, u + r);
                Some(*s)
            })
        };
        let y = play(0.0).zip(play(0.25 * half)).map(|(a, b)| a + 0.5 * b).collect();
        (u, y)
    }

    #[test]
    fn the_best_delay_is_that_of_the_output_and_plays_are_found_exactly() {
        let (u, y) = pair();
        for delay in [0, 3, 5] {
            let residuals = residuals(&u[delay..], &y[..y.len() - delay], 8).unwrap();
            let best = (0..residuals.len()).min_by(|a, b| residuals[*a].total_cmp(&residuals[*b])).unwrap();
            assert_eq!(best, 8 + delay);
            // The threshold of the second play differs a little after the cut.
            assert!(residuals[best] < 5e-3, "{}", residuals[best]);
        }
    }

    #[test]
    fn loops_that_turn_the_other_way_are_not_fitted() {
        let (u, y) = pair();
        let least = |x: Vec<f64>| x[8..].iter().copied().fold(f64::INFINITY, f64::min);
        let (right, wrong) = (least(residuals(&u, &y, 8).unwrap()), least(residuals(&y, &u, 8).unwrap()));
        assert!(wrong > 20.0 * right && wrong > 0.05, "{right} {wrong}");
        assert_eq!(residuals(&[1.0; 100], &y[..100], 8), None);
    }
}
