//! Finds the interval that contains a number, in a time almost independent of the number of intervals.
//!
//! Equal cells cover the range of the edges; each cell stores the number of edges below it. Only the edges within one
//! cell need a comparison: none or one if the edges are nearly equidistant; otherwise they are searched by bisection.

/// Cells per interval.
const FINENESS: usize = 2;

/// Intervals between ascending edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Intervals {
    edges: Vec<f64>,
    cells_per_unit: f64,
    cells: Vec<Bucket>,
}

/// The inner edges in one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bucket {
    /// Number of edges in the cells before this one.
    before: usize,
    /// Number of edges in this cell.
    within: usize,
    /// The first of them; NaN if there is none.
    first: f64,
}

impl Intervals {
    /// `edges` are ascending, at least one; a single one counts as an interval.
    pub fn new(edges: Vec<f64>) -> Self {
        let (n, low, high) = (FINENESS * edges.len(), edges[0], edges[edges.len() - 1]);
        let cells_per_unit = n as f64 / (high - low);
        let mut intervals = Intervals { edges, cells_per_unit, cells: Vec::new() };
        intervals.cells = vec![Bucket { before: 0, within: 0, first: f64::NAN }; n];
        for i in 0..intervals.inner().len() {
            let edge = intervals.inner()[i];
            let k = intervals.cell(edge);
            let cell = &mut intervals.cells[k];
            if cell.within == 0 {
                cell.first = edge;
            }
            cell.within += 1;
            intervals.cells[k + 1..].iter_mut().for_each(|cell| cell.before += 1);
        }
        intervals
    }

    /// The number of the interval that contains `u`, lower edge included; the first or the last one for u outside.
    #[inline]
    pub fn of(&self, u: f64) -> usize {
        let Bucket { before, within, first } = self.cells[self.cell(u)];
        if within < 2 {
            return before + usize::from(first <= u);
        }
        before + self.inner()[before..before + within].partition_point(|edge| *edge <= u)
    }

    /// Text of a program function (first, last, u) that finds the interval of u between the edges `first` to `last` of
    /// `table`, at most `most` edges apart.
    pub fn text(function: &str, table: &str, most: usize) -> String {
        let bisections = most.max(1).next_power_of_two().ilog2();
        TEXT.replace("FUNCTION", function).replace("TABLE", table).replace("BISECTIONS", &bisections.to_string())
    }

    /// The edges of the intervals, rising.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// The edges between the first and the last.
    fn inner(&self) -> &[f64] {
        let last = self.edges.len() - 1;
        &self.edges[last.min(1)..last]
    }

    /// The cell of `u`. Rounding may give a neighbouring cell, but the order of two u is always kept.
    fn cell(&self, u: f64) -> usize {
        (((u - self.edges[0]) * self.cells_per_unit) as usize).min(self.cells.len() - 1)
    }
}

const TEXT: &str = "
// The index of the interval that contains u, between the edges first and last; the outermost one if u lies outside.
fn FUNCTION(first: whole, last: whole, u) {
    let below = first;
    let above = last;
    while above > below + 1 at most BISECTIONS {
        let middle = (below + above) / 2;
        if TABLE[middle] <= u { below = middle; } else { above = middle; }
    }
    return real(below);
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::program::{Block, Machine, Program};

    #[test]
    fn every_interval_equals_that_of_a_bisection() {
        let even: Vec<f64> = (0..=30).map(|k| -0.3 + 0.1 * f64::from(k)).collect();
        let crowded: Vec<f64> = (0..60).map(|k| 1.7f64.powi(k)).collect();
        for edges in [even, crowded, vec![-1.0, 2.0], vec![3.0], vec![0.0, 5e-324, 1e-323], vec![-1e308, 0.0, 1e308]] {
            let intervals = Intervals::new(edges.clone());
            let last = edges.len().max(2) - 2;
            let search = Intervals::text("search", "edges", last + 1);
            let text = format!("{search}fn found(u) {{ return search(0, {}, u); }}", last + 1);
            let program = Program::new(vec![Block::new("even", "").table("edges", &edges).text(&text)]).unwrap();
            let mut machine = Machine::new(&program, "", false);
            let near = edges.iter().flat_map(|e| [e.next_down(), *e, e.next_up(), e + 0.03, 0.7 * e]);
            for u in near.chain([f64::NEG_INFINITY, f64::INFINITY, f64::NAN]) {
                let found = edges.partition_point(|edge| *edge <= u).max(1) - 1;
                assert_eq!(intervals.of(u), found.min(last), "{u} in {edges:?}");
                assert_eq!(machine.call("found", &[u]).unwrap(), [found.min(last) as f64], "{u} in {edges:?}");
            }
        }
    }
}
