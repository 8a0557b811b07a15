//! Two branches from a measured loop: section 2.2 of the paper.
//!
//! A line through the two reversals of a loop splits its points [u, z] into two sets; the paper does not state where
//! the line runs. Each set is averaged in bins, and a spline interpolates the averages. The data decide which set is
//! the ascending one: in a piezo loop rising u is below the line, but above the resonance, or after a wrong linear
//! block, loops are inverted.
//!
//! Both branches end at the two reversals, so the loop is closed. Outside them each branch continues as a straight
//! line.

use super::real::Dual;
use crate::program::Block;
use piezoid_numerics::error::Error;
use piezoid_numerics::intervals::Intervals;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::series::ends;
use piezoid_numerics::spline::Spline;
use serde::{Deserialize, Serialize};

/// Points within this share of the input range belong to a reversal.
const TIP: f64 = 0.005;

/// Maximum number of averages per branch.
const BINS_MAX: usize = 1000;

/// Rule that splits the points of a loop into two branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// The side of the separating line, as in the paper.
    #[default]
    Line,
    /// The direction in which u last moved. Also correct for a loop that crosses itself.
    Direction,
}

const SPLITS: OptionKind = OptionKind::Choice(&[
    ("line", "by the side of the separating line, as in the paper"),
    ("direction", "by the direction of the input"),
]);

options! {
    /// How the points of a loop become two branches.
    #[derive(Copy)]
    pub struct LoopOptions {
        /// How the points are divided between the ascending and the descending branch.
        split: Split = Split::Line, OptionRow::new(SPLITS);
        /// Number of averaged points on each branch, between the reversals.
        bins: usize = 16, OptionRow::new(OptionKind::Integer(1, BINS_MAX as u64));
        /// The separating line: its z at the lowest and at the highest input.
        line: Option<(f64, f64)> = None, OptionRow::new(OptionKind::Pair).absent("through the reversals");
    }
}

/// One branch: knots, and a cubic spline (not-a-knot) through them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Branch {
    knots: Knots,
    spline: Spline,
    /// Slope outside the knots: that of the line from the first to the last knot.
    beyond: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Knots {
    u: Vec<f64>,
    z: Vec<f64>,
}

impl TryFrom<Knots> for Branch {
    type Error = Error;
    fn try_from(knots: Knots) -> Result<Self, Error> {
        let spline = Spline::new(&knots.u, &knots.z)?;
        let n = knots.u.len();
        if n < 2 {
            let remedy = "a branch needs both reversals".into();
            return Err(Error::TooShort { what: "a branch".into(), have: n, need: 2, remedy });
        }
        let beyond = (knots.z[n - 1] - knots.z[0]) / (knots.u[n - 1] - knots.u[0]);
        Ok(Branch { knots, spline, beyond })
    }
}

impl Branch {
    /// The branch through the values `z` at the knots `u`.
    pub(super) fn new(u: Vec<f64>, z: Vec<f64>) -> Result<Self, Error> {
        Branch::try_from(Knots { u, z })
    }

    #[inline]
    pub(super) fn at(&self, u: f64) -> f64 {
        self.on(self.place(u))
    }

    /// z and its slope at `u`.
    #[inline]
    fn rising(&self, u: f64) -> Dual {
        let place = self.place(u);
        let slope = if place.1 == 0.0 { self.spline.slope_on(place.0) } else { self.beyond };
        Dual { value: self.on(place), slope }
    }

    /// Position of `u` on the spline, and its distance outside the ends.
    #[inline]
    pub(super) fn place(&self, u: f64) -> ((usize, f64), f64) {
        let (first, last) = (self.knots.u[0], self.knots.u[self.knots.u.len() - 1]);
        let inside = u.clamp(first, last);
        (self.spline.place(inside), u - inside)
    }

    /// z at a position from this branch or from another one with the same knots.
    #[inline]
    pub(super) fn on(&self, (inside, beyond): ((usize, f64), f64)) -> f64 {
        self.spline.on(inside) + self.beyond * beyond
    }
}

/// The ascending and the descending branch of a loop: two functions of u.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Sides", into = "Sides")]
pub struct Branches {
    ascending: Branch,
    descending: Branch,
}

/// File format of [`Branches`].
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sides {
    ascending: Knots,
    descending: Knots,
}

const BRANCH: &str = "
// z at u on branch b, and the slope there. Beyond its knots a branch continues as a straight line.
fn branch(b: whole, u) {
    let first = whole(starts[b]);
    let last = whole(starts[b + 1]) - 1;
    let inside = clamp(u, knots[first], knots[last]);
    let i = whole(knot_before(first, last, inside));
    let t = inside - knots[i];
    // Four coefficients a piece; a branch has one piece less than knots.
    let k = 4 * (i - b);
    let z = cubics[k] + t * (cubics[k + 1] + t * (cubics[k + 2] + t * cubics[k + 3])) + beyond[b] * (u - inside);
    let slope = beyond[b];
    if u == inside { slope = cubics[k + 1] + t * (2.0 * cubics[k + 2] + t * (3.0 * cubics[k + 3])); }
    return z, slope;
}
";

impl TryFrom<Sides> for Branches {
    type Error = Error;
    fn try_from(Sides { ascending, descending }: Sides) -> Result<Self, Error> {
        Branches::new((ascending.u, ascending.z), (descending.u, descending.z))
    }
}

impl From<Branches> for Sides {
    fn from(branches: Branches) -> Self {
        Sides { ascending: branches.ascending.knots, descending: branches.descending.knots }
    }
}

/// The branches of a measured loop and how they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredLoop {
    /// The branches.
    pub branches: Branches,
    /// The separating line, from the lower to the upper reversal: [(u, z); 2].
    pub line: [(f64, f64); 2],
    /// Share of the points for which the split by line and the split by direction agree, 0.5 to 1.
    pub agreement: f64,
    /// True if ascending points are below the line, as in a piezo loop.
    pub ascending_below: bool,
    /// Rms distance of the points from their branch, relative to the peak-to-peak of z.
    pub error: f64,
}

impl Branches {
    /// Branches through the given knots (u ascending, z).
    ///
    /// # Errors
    /// Returns an error if a branch has fewer than two knots or knots that are not ascending, or if the first or last u
    /// of the branches differ.
    pub fn new(ascending: (Vec<f64>, Vec<f64>), descending: (Vec<f64>, Vec<f64>)) -> Result<Self, Error> {
        let branch = |(u, z)| Branch::new(u, z);
        let (ascending, descending) = (branch(ascending)?, branch(descending)?);
        let ends = |b: &Branch| (b.knots.u[0], b.knots.u[b.knots.u.len() - 1]);
        if ends(&ascending) != ends(&descending) {
            let value = format!("{:?} and {:?}", ends(&ascending), ends(&descending));
            let rule = "the ascending and the descending branch must have the same first and last u";
            return Err(Error::parameter("ends of the branches", value, rule));
        }
        Ok(Branches { ascending, descending })
    }

    /// The branches with ascending and descending exchanged.
    pub fn exchanged(&self) -> Self {
        Branches { ascending: self.descending.clone(), descending: self.ascending.clone() }
    }

    /// z on the ascending branch.
    pub fn ascending(&self, u: f64) -> f64 {
        self.ascending.at(u)
    }

    /// z on the descending branch.
    pub fn descending(&self, u: f64) -> f64 {
        self.descending.at(u)
    }

    /// z and its slope at `u`, on the ascending and on the descending branch.
    #[inline]
    pub(super) fn slopes(&self, u: f64) -> (Dual, Dual) {
        (self.ascending.rising(u), self.descending.rising(u))
    }

    /// Adds the branches of `pairs` to a program `block`: the ascending branch of pair k has number 2 k, the descending
    /// one 2 k + 1. The function `branch(b: whole, u)` returns z and its slope.
    pub fn block<'b>(block: Block, pairs: impl Iterator<Item = &'b Branches>) -> Block {
        let (mut starts, mut knots, mut cubics, mut beyond) = (vec![0.0], Vec::new(), Vec::new(), Vec::new());
        let mut longest = 0;
        for branch in pairs.flat_map(|pair| [&pair.ascending, &pair.descending]) {
            longest = longest.max(branch.knots.u.len());
            knots.extend(&branch.knots.u);
            starts.push(knots.len() as f64);
            cubics.extend(branch.spline.pieces().iter().flatten());
            beyond.push(branch.beyond);
        }
        let block = block.table("starts", &starts).table("knots", &knots).table("cubics", &cubics);
        block.table("beyond", &beyond).text(&Intervals::text("knot_before", "knots", longest)).text(BRANCH)
    }

    /// The lowest and the highest u.
    pub fn range(&self) -> (f64, f64) {
        let u = &self.ascending.knots.u;
        (u[0], u[u.len() - 1])
    }

    /// Largest distance between the branches, relative to the peak-to-peak of z. Negative if the loop is inverted: the
    /// ascending branch lies above.
    pub fn width(&self) -> f64 {
        let (low, high) = self.range();
        let at = |k: usize| low + (high - low) * k as f64 / 200.0;
        let gap = |u: f64| self.descending(u) - self.ascending(u);
        let widest = (0..=200).map(|k| gap(at(k))).fold(0.0, |w: f64, g| if g.abs() > w.abs() { g } else { w });
        let z = (0..=200).flat_map(|k| [self.ascending(at(k)), self.descending(at(k))]);
        let (lowest, highest) = ends(z);
        if highest > lowest { widest / (highest - lowest) } else { 0.0 }
    }

    /// Splits the loop (`u`, `z`), in the order of time, into branches of at most `bins` averages between the
    /// reversals. The branches end at the reversals wherever the separating line is.
    ///
    /// # Errors
    /// [`Error::Unidentifiable`] if u does not move, or moves in one direction only, or if all points are on one side
    /// of the line; an error if `bins` is not 1 to 1000.
    pub fn of_loop(u: &[f64], z: &[f64], options: &LoopOptions) -> Result<MeasuredLoop, Error> {
        let LoopOptions { bins, split, line } = *options;
        if !(1..=BINS_MAX).contains(&bins) {
            return Err(Error::parameter("bins", bins, format!("must be from 1 to {BINS_MAX}")));
        }
        if u.is_empty() || u.len() != z.len() {
            let (left, right) = ("u of a loop".into(), "z".into());
            return Err(Error::Lengths { left, left_len: u.len(), right, right_len: z.len() });
        }
        let (low, high) = ends(u.iter().copied());
        let range = high - low;
        if !(range > 0.0 && range.is_finite()) {
            let because = format!("the input is constant at {low}: drive it up and down through a loop");
            return Err(Error::Unidentifiable { what: "the hysteresis loop".into(), because });
        }
        let mean_where = |near: &dyn Fn(f64) -> bool| {
            let (sum, n) =
                u.iter().zip(z).filter(|(u, _)| near(**u)).fold((0.0, 0.0), |(s, n), (_, z)| (s + z, n + 1.0));
            sum / n
        };
        let bottom = (low, mean_where(&|u| u <= low + TIP * range));
        let top = (high, mean_where(&|u| u >= high - TIP * range));
        let (from, to) = line.unwrap_or((bottom.1, top.1));
        let line = |u: f64| from + (to - from) * (u - low) / range;

        // Direction of each point: the last one while u is held, 0 until it first moves.
        let directions = u.iter().scan((u[0], 0.0), |(before, direction), &u| {
            if u != *before {
                *direction = (u - *before).signum();
            }
            *before = u;
            Some(*direction)
        });
        let points: Vec<(f64, f64, f64)> = u.iter().zip(z).zip(directions).map(|((u, z), d)| (*u, *z, d)).collect();

        // Ascending points below the line and descending points above it count +1, the others -1.
        let below = |u: f64, z: f64| f64::from(i8::from(z < line(u)) - i8::from(z > line(u)));
        let vote: f64 = points.iter().map(|(u, z, d)| d * below(*u, *z)).sum();
        let side = if vote >= 0.0 { 1.0 } else { -1.0 };
        let moving = points.iter().filter(|(_, _, d)| *d != 0.0).count().max(1) as f64;
        let rises = |&(u, z, d): &(f64, f64, f64)| match split {
            Split::Line => side * (line(u) - z) > 0.0,
            Split::Direction => d > 0.0,
        };
        if let Some(way) = [1.0, -1.0].into_iter().find(|way| !points.iter().any(|p| p.2 == *way)) {
            let because =
                format!("the input never {}: it must go up and down", if way > 0.0 { "rises" } else { "falls" });
            return Err(Error::Unidentifiable { what: "the hysteresis loop".into(), because });
        }
        let (up, down): (Vec<_>, Vec<_>) = points.iter().filter(|p| p.2 != 0.0).partition(|p| rises(p));
        if let Some(way) = [(&up, "ascending"), (&down, "descending")].iter().find(|(points, _)| points.is_empty()) {
            let because = format!("no point is on the {} side of the separating line: move the line", way.1);
            return Err(Error::Unidentifiable { what: "the hysteresis loop".into(), because });
        }
        let average = |points: &[&(f64, f64, f64)]| {
            let mut sums = vec![(0.0, 0.0, 0.0); bins];
            for (u, z, _) in points.iter().filter(|p| p.0 > low + TIP * range && p.0 < high - TIP * range) {
                let bin = &mut sums[(((u - low) / range * bins as f64) as usize).min(bins - 1)];
                *bin = (bin.0 + u, bin.1 + z, bin.2 + 1.0);
            }
            let means = sums.into_iter().filter(|s| s.2 > 0.0).map(|(u, z, n)| (u / n, z / n));
            std::iter::once(bottom).chain(means).chain(std::iter::once(top)).unzip()
        };
        let branches = Branches::new(average(&up), average(&down))?;
        let misses = |points: &[&(f64, f64, f64)], on: &Branch| -> f64 {
            points.iter().map(|(u, z, _)| (z - on.at(*u)).powi(2)).sum()
        };
        let missed = misses(&up, &branches.ascending) + misses(&down, &branches.descending);
        let (lowest, highest) = ends(z.iter().copied());
        Ok(MeasuredLoop {
            error: (missed / moving).sqrt() / (highest - lowest),
            branches,
            line: [(low, from), (high, to)],
            agreement: 0.5 + 0.5 * vote.abs() / moving,
            ascending_below: side > 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// An elliptic loop: z lags u, so the ascending branch lies below.
    fn cycle(lag: f64) -> (Vec<f64>, Vec<f64>) {
        let phase = |t: u32| f64::from(t) * std::f64::consts::TAU / 500.0;
        (0..1500).map(|t| (30.0 * phase(t).sin(), 10.0 * (phase(t) - lag).sin())).unzip()
    }

    fn twelve() -> LoopOptions {
        LoopOptions { bins: 12, ..LoopOptions::default() }
    }

    #[test]
    fn a_separating_line_that_is_moved_takes_points_from_one_branch_to_the_other() {
        let (u, z) = cycle(0.1);
        let own = Branches::of_loop(&u, &z, &twelve()).unwrap();
        let [(low, from), (high, to)] = own.line;
        let same = Branches::of_loop(&u, &z, &LoopOptions { line: Some((from, to)), ..twelve() }).unwrap();
        assert_eq!((same.branches.ascending.knots, same.error), (own.branches.ascending.knots.clone(), own.error));
        let moved = Branches::of_loop(&u, &z, &LoopOptions { line: Some((from + 0.5, to + 0.5)), ..twelve() }).unwrap();
        assert_eq!(moved.line, [(low, from + 0.5), (high, to + 0.5)]);
        assert!(moved.agreement < own.agreement && moved.error > 2.0 * own.error, "{} {}", moved.error, own.error);
        let away = LoopOptions { line: Some((from + 50.0, to + 50.0)), ..twelve() };
        let error = Branches::of_loop(&u, &z, &away).unwrap_err().to_string();
        assert!(error.contains("side of the separating line: move the line"), "{error}");
    }

    #[test]
    fn the_data_decide_on_which_side_the_ascending_branch_lies() {
        for split in [Split::Line, Split::Direction] {
            let (u, z) = cycle(0.1);
            let normal = Branches::of_loop(&u, &z, &LoopOptions { split, bins: 12, line: None }).unwrap();
            assert!(normal.ascending_below && normal.agreement > 0.95);
            assert_close(&[normal.branches.width()], &[0.1], 0.03, 0.0);
            let (u, z) = cycle(-0.1);
            let inverted = Branches::of_loop(&u, &z, &LoopOptions { split, bins: 12, line: None }).unwrap();
            assert!(!inverted.ascending_below);
            assert_close(&[inverted.branches.width()], &[-0.1], 0.03, 0.0);
        }
    }

    #[test]
    fn the_branches_meet_at_the_reversals_and_are_straight_outside_them() {
        let (u, z) = cycle(0.1);
        let branches = Branches::of_loop(&u, &z, &twelve()).unwrap().branches;
        let (low, high) = branches.range();
        assert_close(&[branches.ascending(high)], &[branches.descending(high)], 0.0, 1e-12);
        let slope = (branches.ascending(high) - branches.ascending(low)) / (high - low);
        let outside = branches.ascending(high) + 5.0 * slope;
        assert_close(&[branches.ascending(high + 5.0)], &[outside], 1e-12, 0.0);
    }

    #[test]
    fn a_constant_or_monotonic_input_has_no_loop() {
        let error = Branches::of_loop(&[2.0; 9], &[1.0; 9], &twelve()).unwrap_err().to_string();
        assert!(error.contains("the input is constant at 2"), "{error}");
        let error = Branches::of_loop(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0], &twelve()).unwrap_err().to_string();
        assert!(error.contains("never falls"), "{error}");
    }

    #[test]
    fn a_branch_needs_two_knots_and_both_branches_the_same_ends() {
        let knots = |u: &[f64]| (u.to_vec(), vec![1.0; u.len()]);
        let message = Branches::new(knots(&[0.0, 2.0]), knots(&[0.0, 3.0])).unwrap_err().to_string();
        assert!(message.contains("(0.0, 2.0) and (0.0, 3.0)") && message.contains("the same first and last u"));
        assert!(Branches::new(knots(&[0.0]), knots(&[0.0])).is_err());
        assert!(Branches::new(knots(&[0.0, 2.0]), knots(&[0.0, 1.0, 2.0])).is_ok());
    }

    #[test]
    fn exchanged_branches_turn_the_loop_round() {
        let (u, z) = cycle(0.1);
        let branches = Branches::of_loop(&u, &z, &twelve()).unwrap().branches;
        let exchanged = branches.exchanged();
        assert_eq!(
            (exchanged.ascending(3.0), exchanged.descending(3.0)),
            (branches.descending(3.0), branches.ascending(3.0))
        );
        assert_eq!(exchanged.width(), -branches.width());
    }

    #[test]
    fn slopes_are_differences_inside_and_outside_the_knots() {
        let branches = Branches::new(
            (vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 0.5, 2.5, 3.0]),
            (vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 1.5, 2.0, 3.0]),
        )
        .unwrap();
        for u in [-2.0, 0.3, 1.0, 1.7, 2.9, 4.5] {
            let h = 1e-6;
            let (up, down) = branches.slopes(u);
            let slope = |z: &dyn Fn(f64) -> f64| (z(u + h) - z(u - h)) / (2.0 * h);
            let expected = [slope(&|u| branches.ascending(u)), slope(&|u| branches.descending(u))];
            assert_close(&[up.slope, down.slope], &expected, 1e-5, 1e-5);
            assert_eq!((up.value, down.value), (branches.ascending(u), branches.descending(u)));
        }
        assert_eq!(branches.ascending(4.5), 4.5);
    }

    #[test]
    fn averages_lie_on_a_loop_of_straight_branches() {
        // Up along z = u - 1, down along z = u + 1, 3 samples a step of u, as a staircase.
        let turn = |k: i32| f64::from(if k % 40 < 20 { k % 20 } else { 20 - k % 20 });
        let (u, z): (Vec<f64>, Vec<f64>) = (0..240)
            .map(|k| (turn(k / 3), if (k / 3) % 40 < 20 { turn(k / 3) - 1.0 } else { turn(k / 3) + 1.0 }))
            .unzip();
        for split in [Split::Line, Split::Direction] {
            let found = Branches::of_loop(&u, &z, &LoopOptions { split, bins: 5, line: None }).unwrap();
            // The means of u in the bins.
            for u in [2.0, 5.5, 9.5, 13.5, 17.5] {
                let both = [found.branches.ascending(u), found.branches.descending(u)];
                assert_close(&both, &[u - 1.0, u + 1.0], 0.0, 1e-12);
            }
            assert!(found.error < 0.01 && found.agreement > 0.9, "{} {}", found.error, found.agreement);
        }
    }

    #[test]
    fn a_loop_without_samples_or_with_too_many_bins_is_an_error() {
        let (u, z) = cycle(0.1);
        for bins in [0, 1001] {
            let message = Branches::of_loop(&u, &z, &LoopOptions { bins, ..twelve() }).unwrap_err().to_string();
            assert!(message.contains("must be from 1 to 1000"), "{message}");
        }
        assert!(Branches::of_loop(&u, &z, &LoopOptions { bins: 1, ..twelve() }).is_ok());
        assert!(Branches::of_loop(&[], &[], &twelve()).is_err());
        assert!(Branches::of_loop(&u, &z[1..], &twelve()).is_err());
    }

    #[test]
    fn every_number_of_a_split_is_that_of_its_definition() {
        // At rest, up with samples on the line and a held one, down, and up again; two at the edges of the tips.
        let edge = TIP * 10.0;
        let u = [12.0, 12.0, 15.0, 15.0, 20.0 - edge, 20.0, 20.0, 17.0, 13.0, 10.0 + edge, 10.0, 10.0, 11.0];
        let z = [3.0, 3.5, 5.5, 5.7, 9.8, 10.0, 10.2, 9.0, 6.0, 1.2, 1.0, 0.8, 1.3];
        let (bottom, top) = ((10.0, 1.0), (20.0, 10.0));
        let by_line = [vec![bottom, (11.0, 1.3), top], vec![bottom, (13.0, 6.0), (47.0 / 3.0, 20.2 / 3.0), top]];
        let by_direction = [vec![bottom, (11.0, 1.3), (15.0, 5.6), top], vec![bottom, (13.0, 6.0), (17.0, 9.0), top]];
        let splits =
            [(Split::Line, by_line, 0.08209874108896355), (Split::Direction, by_direction, 0.012352425035827784)];
        for (split, known, error) in splits {
            let found = Branches::of_loop(&u, &z, &LoopOptions { split, bins: 2, line: None }).unwrap();
            for (branch, known) in [&found.branches.ascending, &found.branches.descending].into_iter().zip(&known) {
                let (u, z): (Vec<f64>, Vec<f64>) = known.iter().copied().unzip();
                assert_close(&branch.knots.u, &u, 1e-14, 0.0);
                assert_close(&branch.knots.z, &z, 1e-14, 0.0);
            }
            assert_eq!((found.line, found.ascending_below), ([bottom, top], true));
            // Of 11 samples in motion 5 agree, 3 do not, and 3 are on the line.
            assert_close(&[found.agreement, found.error], &[0.5 + 1.0 / 11.0, error], 1e-9, 0.0);
        }
    }

    #[test]
    fn a_loop_without_height_has_no_width_and_one_without_bounds_is_an_error() {
        let flat = || (vec![-1.0, 1.0], vec![3.0, 3.0]);
        assert_eq!(Branches::new(flat(), flat()).unwrap().width(), 0.0);
        let options = LoopOptions { split: Split::Direction, ..twelve() };
        assert!(Branches::of_loop(&[-1.7e308, 1.7e308, -1.7e308], &[0.0, 1.0, 0.0], &options).is_err());
    }
}
