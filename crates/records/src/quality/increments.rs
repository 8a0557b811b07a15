//! Regression of the increments of one signal on those of another, before and after.
//!
//! ```text
//! y_t - y_{t-1} = sum over lags j of g_j (u_{t-j} - u_{t-j-1}) + r_t
//! ```
//! If u drives y, later inputs (j < 0) explain nothing that earlier ones do not (Sims 1972, American Economic Review
//! 62). Before the record, the signals are assumed constant.

use super::lags::Lags;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::series::dot_wide;
use std::ops::Range;

/// The largest lead and the largest lag [samples].
pub(super) const MAX_LEAD_LAGS: isize = 8;
pub(super) const MAX_LAGS: isize = 64;

/// Ridge, relative to the power of the increments of the input: increments of smooth inputs are nearly equal.
const RIDGE: f64 = 1e-3;

/// The normal equations of the regression.
pub(super) struct Increments {
    gram: DMatrix<f64>,
    right: DVector<f64>,
}

impl Increments {
    /// `None` if a signal is constant or too short.
    pub(super) fn of(u: &[f64], y: &[f64]) -> Option<Self> {
        let increments = |x: &[f64]| x.windows(2).map(|w| w[1] - w[0]).collect::<Vec<f64>>();
        let (u, y) = (increments(u), increments(y));
        let (ahead, lags) = (MAX_LEAD_LAGS as usize, (MAX_LEAD_LAGS + MAX_LAGS) as usize);
        let end = y.len().checked_sub(ahead).filter(|end| *end > 4 * lags)?;
        let (u, y) = (over_rms(&u)?, over_rms(&y[..end])?);
        // The first column is the input MAX_LEAD_LAGS samples later; before the record it is zero.
        let padded: Vec<f64> = std::iter::repeat_n(0.0, lags - 1 - ahead).chain(u).collect();
        let columns = Lags::new(&padded[..end + lags - 1], lags);
        let right = columns.with(&y) / end as f64;
        let mut gram = columns.products(&columns) / end as f64;
        (0..lags).for_each(|i| gram[(i, i)] += RIDGE);
        Some(Increments { gram, right })
    }

    /// The share of the power of the output's increments that the input's explain at these lags.
    pub(super) fn explained(&self, lags: Range<isize>) -> f64 {
        let (first, n) = ((lags.start + MAX_LEAD_LAGS) as usize, (lags.end - lags.start) as usize);
        let (gram, right) = (self.gram.view((first, first), (n, n)), self.right.rows(first, n));
        gram.clone_owned().cholesky().map_or(0.0, |c| {
            let weights = c.solve(&right);
            // The ridge is not a residual.
            (2.0 * right.dot(&weights) - (gram * &weights).dot(&weights) + RIDGE * weights.norm_squared())
                .clamp(0.0, 1.0)
        })
    }

    /// The share of what earlier inputs leave that later inputs explain.
    pub(super) fn by_later(&self) -> f64 {
        let (earlier, all) = (self.explained(0..MAX_LAGS), self.explained(-MAX_LEAD_LAGS..MAX_LAGS));
        1.0 - (1.0 - all) / (1.0 - earlier).max(1e-12)
    }
}

/// A series over its rms; `None` if it is zero.
fn over_rms(x: &[f64]) -> Option<Vec<f64>> {
    let rms = (dot_wide::<8>(x, x) / x.len() as f64).sqrt();
    (rms > 0.0).then(|| x.iter().map(|x| x / rms).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u32, n: usize) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn the_normal_equations_are_those_of_shifted_columns() {
        let (u, y) = (noise(1, 500), noise(2, 500));
        let equations = Increments::of(&u, &y).unwrap();
        let increments: Vec<f64> = u.windows(2).map(|w| w[1] - w[0]).collect();
        let end = increments.len() - MAX_LEAD_LAGS as usize;
        let power = increments.iter().map(|u| u * u).sum::<f64>() / increments.len() as f64;
        let at = |i: isize, t: isize| {
            increments.get((t + MAX_LEAD_LAGS - i) as usize).copied().filter(|_| t + MAX_LEAD_LAGS >= i)
        };
        for (i, j) in [(0, 0), (0, 70), (3, 5), (9, 40), (71, 71)] {
            let products = (0..end as isize).map(|t| at(i, t).unwrap_or(0.0) * at(j, t).unwrap_or(0.0));
            let expected = products.sum::<f64>() / (end as f64 * power) + if i == j { RIDGE } else { 0.0 };
            let got = equations.gram[(i as usize, j as usize)];
            assert!((got - expected).abs() < 1e-12, "{i} {j}: {got} {expected}");
        }
    }

    #[test]
    fn a_response_is_explained_by_its_own_lags_alone() {
        let u = noise(1, 2000);
        let y: Vec<f64> = (0..2000).map(|t| if t < 3 { 0.0 } else { u[t - 2] + 0.5 * u[t - 3] }).collect();
        let equations = Increments::of(&u, &y).unwrap();
        assert!(
            equations.explained(2..4) > 0.99 && equations.explained(4..MAX_LAGS) < 0.8,
            "{}",
            equations.explained(4..MAX_LAGS)
        );
        assert!(equations.by_later() < 0.02, "{}", equations.by_later());
        assert!(Increments::of(&y, &u).unwrap().by_later() > 0.9);
        assert!(Increments::of(&u, &[1.0; 2000]).is_none() && Increments::of(&u[..90], &y[..90]).is_none());
    }
}
