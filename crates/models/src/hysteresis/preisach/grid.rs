//! A population of relays on a triangular grid with constant density in each cell: the share that has switched.
//!
//! ```text
//! alpha >= beta;  cell (i, j), j <= i:  l_i <= alpha < l_{i+1},  l_j <= beta < l_{j+1}
//! ```
//! A relay switches up when the rising input passes alpha, and down when the falling input passes beta. A movement
//! between m and M switches the relays with alpha <= M and beta >= m. A movement from rest up to u switches those with
//! alpha <= u and alpha + beta >= 0: after demagnetisation the others are already up. The share of a cell is an area: a
//! rectangle, a triangle, or one of these cut by the line alpha + beta = 0.

use crate::hysteresis::real::Real;
use piezoid_numerics::intervals::Intervals;

/// Levels l_0 < l_1 < ... < l_n, the edges of the cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid(Intervals);

/// Cells in a triangle of `n` rows.
pub(super) fn cells(n: usize) -> usize {
    n * (n + 1) / 2
}

/// The number of cell (i, j).
pub(super) fn cell(i: usize, j: usize) -> usize {
    cells(i) + j
}

impl Grid {
    /// `levels` are ascending, at least two.
    pub(super) fn new(levels: Vec<f64>) -> Self {
        Grid(Intervals::new(levels))
    }

    pub(super) fn levels(&self) -> &[f64] {
        self.0.edges()
    }

    /// Rows of cells.
    pub(super) fn rows(&self) -> usize {
        self.levels().len() - 1
    }

    /// The interval between the levels that holds `u`.
    pub(super) fn interval(&self, u: f64) -> usize {
        self.0.of(u)
    }

    /// The interval that holds `u`, and the share of it that lies below `u`.
    pub(super) fn place<R: Real>(&self, u: R) -> (usize, R) {
        let i = self.interval(u.value());
        (i, share(&self.0, i, u))
    }

    /// Adds `way` times the share of relays that switch between `low` and `high` to each cell of `sums`.
    pub(super) fn between(&self, low: f64, high: f64, way: f64, sums: &mut [f64]) {
        let ((last, upto), (first, below)) = (self.place(high), self.place(low));
        for i in first..=last {
            let alphas = if i == last { upto } else { 1.0 };
            let Some((diagonal, row)) = sums[cell(i, first)..=cell(i, i)].split_last_mut() else { return };
            if let Some((begin, whole)) = row.split_first_mut() {
                *begin += way * alphas * (1.0 - below);
                whole.iter_mut().for_each(|sum| *sum += way * alphas);
            }
            let both = if i == first { (alphas - below).max(0.0) } else { alphas };
            *diagonal += way * both * both;
        }
    }

    /// Passes, for each cell, the share of its relays that switch from rest to `u` to `share`.
    pub(super) fn since_rest(&self, u: f64, mut share: impl FnMut(usize, f64)) {
        for i in 0..self.rows() {
            for j in 0..=i {
                share(cell(i, j), self.since_rest_in(i, j, u));
            }
        }
    }

    /// The share of cell (i, j) that switches from rest to `u`. A negative `u` is mirrored at alpha + beta = 0: the
    /// cell is then the one whose alpha is from -l_{j+1} to -l_j.
    fn since_rest_in(&self, i: usize, j: usize, u: f64) -> f64 {
        let l = self.levels();
        let (alpha, beta) = match u >= 0.0 {
            true => ((l[i], l[i + 1]), (l[j], l[j + 1])),
            false => ((-l[j + 1], -l[j]), (-l[i + 1], -l[i])),
        };
        // For each alpha up to |u|, the length of its betas from -alpha on: a difference of two integrals of ramps.
        let upto = |alpha_end: f64, beta_end: f64| ramp(alpha_end + beta_end) - ramp(alpha.0 + beta_end);
        let end = u.abs().clamp(alpha.0, alpha.1);
        let area = match i == j {
            // On one side of the line; the general formula would subtract squares of large levels.
            false if alpha.0 + beta.0 >= 0.0 => (end - alpha.0) * (beta.1 - beta.0),
            true if alpha.0 + beta.0 >= 0.0 => 0.5 * (end - alpha.0) * (end - alpha.0),
            false => upto(end, beta.1) - upto(end, beta.0),
            // Below the diagonal beta <= alpha: lengths run to 2 alpha instead of alpha + l_{j+1}.
            true => ramp(2.0 * end) / 2.0 - ramp(2.0 * alpha.0) / 2.0 - upto(end, beta.0),
        };
        let whole = (alpha.1 - alpha.0) * (beta.1 - beta.0);
        area / if i == j { 0.5 * whole } else { whole }
    }
}

/// The share of interval `i` below `u`, 0 to 1.
pub(super) fn share<R: Real>(intervals: &Intervals, i: usize, u: R) -> R {
    let (low, high) = (intervals.edges()[i], intervals.edges()[i + 1]);
    ((u - low.into()) / (high - low).into()).clamp(0.0.into(), 1.0.into())
}

/// The integral of max(x, 0).
fn ramp(x: f64) -> f64 {
    let x = x.max(0.0);
    0.5 * x * x
}
