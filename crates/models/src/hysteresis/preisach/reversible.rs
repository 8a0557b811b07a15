//! The reversible curve: the part of z that follows u without memory, linear in each interval between the levels.
//!
//! ```text
//! r(u) = s u + sum over intervals k of rise_k times the part of interval k between 0 and u
//! ```
//! Outside the levels the outermost slopes continue. Without this curve, relays on the diagonal of the grid carry the
//! bend of the reversible displacement, and turn it into small loops.
//!
//! Why: docs/decisions/hysteresis-laws.md, "Preisach's operator has a reversible curve".

use super::grid::Grid;
use crate::hysteresis::real::Real;
use crate::program::Block;

/// A reversible curve on the levels of a grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReversibleCurve<W = f64> {
    grid: Grid,
    slope: f64,
    /// In each interval: the sum over the rises at its lower level, and the slope of that sum.
    starts: Vec<W>,
    slopes: Vec<W>,
}

impl<W: Real> ReversibleCurve<W> {
    /// `slope` is s; `rises` has one number per interval, or none.
    pub(super) fn new(grid: &Grid, slope: f64, rises: &[W]) -> Self {
        let levels = grid.levels();
        let rise = |k: usize| rises.get(k).copied().unwrap_or(W::from(0.0));
        let slopes = (0..grid.rows()).map(|k| rise(k) / (levels[k + 1] - levels[k]).into()).collect();
        let start = |&level: &f64| {
            let mut sum = W::from(0.0);
            parts(grid, level, |k, part| sum = sum + rise(k) * part.into());
            sum
        };
        let starts = levels[..grid.rows()].iter().map(start).collect();
        ReversibleCurve { grid: grid.clone(), slope, starts, slopes }
    }

    /// r at `u`.
    pub(super) fn at<R: Real>(&self, u: R) -> R
    where
        W: Into<R>,
    {
        let k = self.grid.interval(u.value());
        let rises: R = self.starts[k].into() + self.slopes[k].into() * (u - self.grid.levels()[k].into());
        R::from(self.slope) * u + rises
    }
}

impl ReversibleCurve {
    /// Adds the curve with its slope to a program `block` that has the `levels` of the grid.
    pub(super) fn block(&self, block: Block) -> Block {
        let block = block.table("reversible_starts", &self.starts).table("reversible_slopes", &self.slopes);
        block.constant("at_once", self.slope).text(TEXT)
    }
}

/// Passes, for each interval of a grid, the part of it between 0 and `u`, negative for negative `u`, to `part`. The
/// outermost intervals have no outer end.
pub(super) fn parts(grid: &Grid, u: f64, mut part: impl FnMut(usize, f64)) {
    let (levels, last) = (grid.levels(), grid.rows() - 1);
    for k in 0..=last {
        let low = if k == 0 { f64::NEG_INFINITY } else { levels[k] };
        let high = if k == last { f64::INFINITY } else { levels[k + 1] };
        part(k, (u.clamp(low, high) - 0f64.clamp(low, high)) / (levels[k + 1] - levels[k]));
    }
}

const TEXT: &str = "
// The part of z that follows u without memory, and its slope.
fn reversible(u) {
    let i = whole(row(0, rows, u));
    let slope = reversible_slopes[i];
    return at_once * u + (reversible_starts[i] + slope * (u - levels[i])), at_once + slope;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_curve_is_the_integral_of_its_slope_from_zero() {
        let grid = Grid::new(vec![-3.0, -1.0, 0.5, 2.0]);
        let rises = [4.0, 0.3, 1.5];
        let slope_at = |u: f64| {
            0.2 + if u < -1.0 {
                2.0
            } else if u < 0.5 {
                0.2
            } else {
                1.0
            }
        };
        let curve = ReversibleCurve::new(&grid, 0.2, &rises);
        for u in [-5.0, -3.0, -1.7, -1.0, 0.0, 0.3, 0.5, 1.9, 2.0, 4.0] {
            let n = 30_000;
            let middles = (0..n).map(|t| u * (f64::from(t) + 0.5) / f64::from(n));
            let integral: f64 = middles.map(|v| slope_at(v) * u / f64::from(n)).sum();
            let mut sum = 0.2 * u;
            parts(&grid, u, |k, part| sum += rises[k] * part);
            assert_close(&[curve.at(u), sum], &[integral; 2], 0.0, 1e-3);
        }
        assert_eq!(ReversibleCurve::<f64>::new(&grid, 0.7, &[]).at(-2.0), -1.4);
    }
}
