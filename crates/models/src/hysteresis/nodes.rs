//! Two branches as weighted responses: splines through equidistant knots, linear in the values at the knots.
//!
//! ```text
//! z = m(u) + way v(u)                               way +1 descending, -1 ascending, 0 not yet known
//! m(u) = sum_k m_k (c_k(u) - c_k(0))                c_k the cardinal spline: 1 at knot k, 0 at all others
//! v(u) = sum_k v_k c_k(u), all knots but the ends   v_k >= 0
//! ```
//! m is the mean of the branches and v half their distance. Therefore the branches meet at the ends of the range, and z
//! = 0 at rest. The sum of the cardinals is 1, so one of the m_k is redundant: the one nearest to u = 0 is omitted.

use super::Branches;
use super::basis::BasisDesign;
use super::branches::Branch;
use piezoid_numerics::error::Error;

/// Default and maximum number of knots.
const KNOTS: usize = 13;
const MAX_KNOTS: usize = 200;

/// Equidistant knots over the range and the cardinal splines through them.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    knots: Vec<f64>,
    cardinals: Vec<Branch>,
    /// c_k(0)
    at_rest: Vec<f64>,
    /// The knot without an m_k.
    redundant: usize,
}

impl Nodes {
    pub(super) fn new(design: &BasisDesign) -> Result<Self, Error> {
        Nodes::of(design.range, design.elements.unwrap_or(KNOTS).clamp(3, MAX_KNOTS))
    }

    /// `n` knots from the lowest to the highest input.
    pub(super) fn of((low, high): (f64, f64), n: usize) -> Result<Self, Error> {
        let last = n - 1;
        let knots: Vec<f64> =
            (0..n).map(|k| if k == last { high } else { low + (high - low) * k as f64 / last as f64 }).collect();
        let one = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect();
        let cardinals = (0..n).map(|k| Branch::new(knots.clone(), one(k))).collect::<Result<Vec<_>, _>>()?;
        let at_rest = cardinals.iter().map(|c| c.at(0.0)).collect();
        let redundant = (0..n).min_by(|&i, &j| knots[i].abs().total_cmp(&knots[j].abs())).unwrap_or(0);
        Ok(Nodes { knots, cardinals, at_rest, redundant })
    }

    /// Number of weights: the m_k, then the v_k.
    pub(super) fn len(&self) -> usize {
        self.middles() + self.knots.len() - 2
    }

    /// Number of the m_k.
    fn middles(&self) -> usize {
        self.knots.len() - 1
    }

    /// c_k(u) - c_k(0).
    pub(super) fn middle(&self, k: usize, u: f64) -> f64 {
        self.cardinals[k].at(u) - self.at_rest[k]
    }

    /// c_k(u).
    pub(super) fn side(&self, k: usize, u: f64) -> f64 {
        self.cardinals[k].at(u)
    }

    /// Position of m_k (k not redundant) among the weights.
    fn weight(&self, k: usize) -> usize {
        k - usize::from(k > self.redundant)
    }

    /// Adds `share` of the responses at `u` to `phi`.
    pub(super) fn respond(&self, u: f64, way: f64, share: f64, phi: &mut [f64]) {
        let (middles, sides) = phi.split_at_mut(self.middles());
        let place = self.cardinals[0].place(u);
        for (k, (cardinal, at_rest)) in self.cardinals.iter().zip(&self.at_rest).enumerate() {
            let c = cardinal.on(place);
            if k != self.redundant {
                middles[self.weight(k)] += share * (c - at_rest);
            }
            if (1..=sides.len()).contains(&k) {
                sides[k - 1] += share * way * c;
            }
        }
    }

    pub(super) fn non_negative(&self) -> impl Iterator<Item = bool> {
        (0..self.len()).map(|k| k >= self.middles())
    }

    /// Second differences of the m_k and of the v_k, which begin at weight `from`.
    pub(super) fn roughness(&self, from: usize) -> Vec<Vec<(usize, f64)>> {
        let (n, middles) = (self.knots.len(), self.middles());
        let middle = |k: usize| (k != self.redundant).then(|| from + self.weight(k));
        // v is 0 at both ends.
        let side = move |k: usize| (1..n - 1).contains(&k).then(|| from + middles + k - 1);
        let bend = |weight: &dyn Fn(usize) -> Option<usize>, k: usize| {
            let terms = [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)];
            terms.into_iter().filter_map(|(k, c)| Some((weight(k)?, c))).collect()
        };
        (1..n - 1).map(|k| bend(&middle, k)).chain((1..n - 1).map(|k| bend(&side, k))).collect()
    }

    /// The branches for these weights.
    pub(super) fn branches(&self, weights: &[f64]) -> Result<Branches, Error> {
        let (m, v) = weights.split_at(self.middles());
        let middle: Vec<f64> =
            (0..self.knots.len()).map(|k| if k == self.redundant { 0.0 } else { m[self.weight(k)] }).collect();
        let side: Vec<f64> = std::iter::once(&0.0).chain(v).chain(&[0.0]).copied().collect();
        self.branches_of(&middle, &side)
    }

    /// The branches for given values of m and v at every knot; m is shifted to be 0 at rest.
    pub(super) fn branches_of(&self, middle: &[f64], side: &[f64]) -> Result<Branches, Error> {
        let at_rest: f64 = middle.iter().zip(&self.at_rest).map(|(m, c)| m * c).sum();
        let branch = |way: f64| {
            let z = middle.iter().zip(side).map(|(m, v)| m - at_rest + way * v);
            (self.knots.clone(), z.collect())
        };
        Branches::new(branch(-1.0), branch(1.0))
    }

    pub(super) fn knots(&self) -> &[f64] {
        &self.knots
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn branches_meet_at_the_ends_of_the_range_and_pass_through_rest() {
        for range in [(-30.0, 30.0), (0.0, 100.0), (-10.0, 35.0), (20.0, 60.0)] {
            let nodes = Nodes::of(range, 9).unwrap();
            let weights: Vec<f64> = (0..nodes.len()).map(|k| (k as f64).sin()).collect();
            let branches = nodes.branches(&weights).unwrap();
            for u in [range.0, range.1, range.1 + 7.0] {
                assert_close(&[branches.ascending(u)], &[branches.descending(u)], 1e-12, 1e-12);
            }
            let middle = 0.5 * (branches.ascending(0.0) + branches.descending(0.0));
            assert_close(&[middle], &[0.0], 0.0, 1e-12);
        }
    }

    #[test]
    fn a_line_and_a_constant_distance_have_no_roughness_inside() {
        let nodes = Nodes::of((-30.0, 30.0), 7).unwrap();
        let line: Vec<f64> = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 5.0, 5.0, 5.0, 5.0, 5.0].into();
        let rows = nodes.roughness(0);
        let sums: Vec<f64> = rows.iter().map(|row| row.iter().map(|(k, c)| c * line[*k]).sum()).collect();
        assert_eq!(sums, [0.0, 0.0, 0.0, 0.0, 0.0, -5.0, 0.0, 0.0, 0.0, -5.0]);
    }
}
