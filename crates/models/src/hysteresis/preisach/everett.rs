//! Everett's functions of a weighted grid, from tables: the time does not depend on the size of the grid.
//!
//! ```text
//! E(M, m) = sum of the weights of the relays that switch between m and M
//! V(u)    = sum of the weights of the relays that switch from rest to u, negative for negative u
//! ```
//! Between the levels E is bilinear, except in the two cells on the diagonal, where it is quadratic. V is quadratic
//! between the levels and their mirror images.
//!
//! Reference: D. H. Everett, Trans. Faraday Soc. 51, 1551 (1955), DOI 10.1039/TF9555101551.

use super::grid::{Grid, cell, share};
use crate::hysteresis::real::Real;
use crate::program::Block;
use piezoid_numerics::intervals::Intervals;

/// E and V, tabulated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Everett<W = f64> {
    grid: Grid,
    /// E at the nodes (M = l_i, m = l_j) without the cells on the diagonal.
    nodes: Vec<W>,
    /// The weights on the diagonal, and their sum below each level.
    diagonal: Vec<W>,
    diagonal_below: Vec<W>,
    /// Break points of V, and V at each of them, halfway to the next, and at the next.
    breaks: Intervals,
    virgin: Vec<[W; 3]>,
}

impl<W: Real> Everett<W> {
    /// `weights` has one number per cell of the triangle.
    pub(super) fn new(grid: &Grid, weights: &[W]) -> Self {
        let zero = W::from(0.0);
        let (levels, n) = (grid.levels(), grid.rows());
        let stride = n + 1;
        let mut nodes = vec![zero; stride * stride];
        for i in 1..=n {
            let mut row = zero;
            for j in (0..i).rev() {
                row = row + if j < i - 1 { weights[cell(i - 1, j)] } else { zero };
                nodes[i * stride + j] = nodes[(i - 1) * stride + j] + row;
            }
        }
        let diagonal: Vec<W> = (0..n).map(|i| weights[cell(i, i)]).collect();
        let sum = |below: &mut W, w: &W| Some(std::mem::replace(below, *below + *w));
        let diagonal_below = diagonal.iter().chain([&zero]).scan(zero, sum).collect();

        let mut breaks: Vec<f64> = levels.iter().flat_map(|l| [*l, -*l]).chain([0.0]).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        let switched = |u: f64| {
            let mut sum = zero;
            grid.since_rest(u, |k, share| {
                if share != 0.0 {
                    sum = sum + weights[k] * share.into();
                }
            });
            if u < 0.0 { -sum } else { sum }
        };
        let virgin = breaks.windows(2).map(|w| [w[0], 0.5 * (w[0] + w[1]), w[1]].map(switched)).collect();
        Everett { grid: grid.clone(), nodes, diagonal, diagonal_below, breaks: Intervals::new(breaks), virgin }
    }

    /// E between `m` and `M`, m <= M.
    pub(super) fn between<R: Real>(&self, m: R, high: R) -> R
    where
        W: Into<R>,
    {
        let ((i, a), (j, b)) = (self.grid.place(high), self.grid.place(m));
        if i == j {
            return self.diagonal[i].into() * (a - b) * (a - b);
        }
        let one = R::from(1.0);
        let node = |i: usize, j: usize| -> R { self.nodes[i * self.grid.levels().len() + j].into() };
        // Bilinear interpolation: a upwards from l_i, 1 - b downwards from l_{j+1}.
        let at = |i: usize| b * node(i, j + 1) + (one - b) * node(i, j);
        let off = (one - a) * at(i) + a * at(i + 1);
        let between: R = (self.diagonal_below[i] - self.diagonal_below[j + 1]).into();
        let [upper, lower] = [i, j].map(|k| self.diagonal[k].into());
        off + between + upper * a * a + lower * (one - b) * (one - b)
    }

    /// V at `u`.
    pub(super) fn since_rest<R: Real>(&self, u: R) -> R
    where
        W: Into<R>,
    {
        let k = self.breaks.of(u.value());
        let s = share(&self.breaks, k, u);
        let [start, middle, end] = self.virgin[k];
        let [two, three, four] = [2.0, 3.0, 4.0].map(W::from);
        let (rise, bend) = (four * middle - three * start - end, start + end - two * middle);
        start.into() + s * (rise.into() + R::from(2.0) * s * bend.into())
    }
}

impl Everett {
    /// Adds the tables and both functions, with their slopes, to a program `block`.
    pub(super) fn block(&self, block: Block) -> Block {
        let n = self.grid.levels().len();
        let block = block.table("levels", self.grid.levels()).table("nodes", &self.nodes).count("rows", n - 1);
        let block = block.table("diagonal", &self.diagonal).table("diagonal_below", &self.diagonal_below);
        let breaks = self.breaks.edges();
        let block =
            block.table("breaks", breaks).table("virgin", self.virgin.as_flattened()).count("pieces", breaks.len() - 1);
        let (row, piece) =
            (Intervals::text("row", "levels", n - 1), Intervals::text("piece", "breaks", breaks.len() - 1));
        block.text(&row).text(&piece).text(TEXT)
    }
}

const TEXT: &str = "
// The fraction of the interval low..high that lies below v (0 to 1), and its slope.
fn share_below(v, v_slope, low, high) {
    let share = (v - low) / (high - low);
    let slope = v_slope / (high - low);
    if share > 1.0 {
        share = 1.0;
        slope = 0.0;
    }
    if share < 0.0 {
        share = 0.0;
        slope = 0.0;
    }
    return share, slope;
}

// Everett's function at M = l_i, for m at a share b of the way from l_j to l_j+1, and its slope.
fn everett_at(i: whole, j: whole, b, b_slope) {
    let k = i * (rows + 1) + j;
    return b * nodes[k + 1] + (1.0 - b) * nodes[k], b_slope * nodes[k + 1] - b_slope * nodes[k];
}

// Everett's function: the sum of the weights of the relays that switch between low and high, and its slope.
fn everett(low, high, low_slope, high_slope) {
    let i = whole(row(0, rows, high));
    let j = whole(row(0, rows, low));
    let a, a_slope = share_below(high, high_slope, levels[i], levels[i + 1]);
    let b, b_slope = share_below(low, low_slope, levels[j], levels[j + 1]);
    let sum = diagonal[i] * (a - b) * (a - b);
    let slope = diagonal[i] * (a_slope - b_slope) * (a - b) + diagonal[i] * (a - b) * (a_slope - b_slope);
    if i != j {
        let before, before_slope = everett_at(i, j, b, b_slope);
        let after, after_slope = everett_at(i + 1, j, b, b_slope);
        let c = 1.0 - b;
        sum = (1.0 - a) * before + a * after + (diagonal_below[i] - diagonal_below[j + 1]);
        sum = sum + diagonal[i] * a * a + diagonal[j] * c * c;
        slope = (-a_slope * before + (1.0 - a) * before_slope) + (a_slope * after + a * after_slope);
        slope = slope + (diagonal[i] * a_slope * a + diagonal[i] * a * a_slope);
        slope = slope + (diagonal[j] * -b_slope * c + diagonal[j] * c * -b_slope);
    }
    return sum, slope;
}

// The weights of the relays that turn from rest to u, negative for negative u, and the slope.
fn since_rest(u) {
    let i = whole(piece(0, pieces, u));
    let s, s_slope = share_below(u, 1.0, breaks[i], breaks[i + 1]);
    // At the start of a piece, halfway, and at its end.
    let start = virgin[3 * i];
    let middle = virgin[3 * i + 1];
    let stop = virgin[3 * i + 2];
    let rise = 4.0 * middle - 3.0 * start - stop;
    let bend = start + stop - 2.0 * middle;
    let steep = rise + 2.0 * s * bend;
    return start + s * steep, s_slope * steep + s * (2.0 * s_slope * bend);
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::preisach::grid::cells;
    use piezoid_testing::assert_close;

    #[test]
    fn the_tables_are_the_sums_over_the_cells() {
        let levels = [-3.0, -1.5, -0.4, 0.9, 2.0, 3.5];
        let weights: Vec<f64> = (0..cells(5)).map(|k| 0.3 + (k as f64 * 1.7).sin().abs()).collect();
        let grid = Grid::new(levels.to_vec());
        let everett = Everett::new(&grid, &weights);
        let points: Vec<f64> = (0..50).map(|k| -4.0 + 0.17 * f64::from(k)).collect();
        for (k, &m) in points.iter().enumerate() {
            let mut sum = 0.0;
            grid.since_rest(m, |k, share| sum += weights[k] * share * if m < 0.0 { -1.0 } else { 1.0 });
            assert_close(&[everett.since_rest(m)], &[sum], 0.0, 1e-13);
            for &high in &points[k..] {
                let mut shares = vec![0.0; weights.len()];
                grid.between(m, high, 1.0, &mut shares);
                let sum = shares.iter().zip(&weights).map(|(share, w)| share * w).sum();
                assert_close(&[everett.between(m, high)], &[sum], 0.0, 1e-13);
            }
        }
    }
}
