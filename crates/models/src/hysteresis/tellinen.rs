//! Tellinen's model: two branches; between them the slope is proportional to the distance from the other branch.
//!
//! ```text
//! dz/du = z_a'(u) (z_d - z) / (z_d - z_a)  rising,     z_d'(u) (z - z_a) / (z_d - z_a)  falling
//! ```
//! Let z = m + side v, with m the mean of the branches, v half their distance and side from -1 (ascending) to 1
//! (descending). Then the equation is one for the side alone, and is integrated exactly:
//! ```text
//! 1 + side decays by exp(-int dz_d / (2 v)) rising,    1 - side by exp(-int dz_a / (2 v)) falling
//! ```
//! The integrals are functions of u. They are tabulated once for a thousand cells of the range, by the midpoint rule,
//! and interpolated linearly: the division of a path into samples has no effect. At the ends of the range the integrals
//! diverge: after a reversal there, z is on the branch immediately. Where the branches touch or cross (v <= 0), or
//! where one decreases, the loop is closed.
//!
//! Reference: J. Tellinen, "A simple scalar model for magnetic hysteresis", IEEE Trans. Magnetics 34 (1998), DOI
//! 10.1109/20.706508 (there with a separate slope of vacuum). Reversals start without a jump. It does not do: rate,
//! wiping out (minor loops drift towards a closed loop), inverted loops (they have width 0).
//!
//! Inverse: Newton's method, with the slope of the equation. Outside the range z is linear.

use super::basis::counted;
use super::inverse::{Inverted, by_slopes, by_trials};
use super::nodes::Nodes;
use super::real::{Dual, Real};
use super::two_branch::example;
use super::{Basis, BasisDesign, Branches, Class, Hysteresis, Operator, ShapeParameter, document, parse};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use serde_json::{Map, Value};
use std::sync::Arc;

/// Two branches and Tellinen's equation between them.
///
/// State: the last input, the side from -1 (ascending) to 1 (descending), 0 at rest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tellinen {
    ts: f64,
    branches: Branches,
    decay: Decay<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "tellinen",
    aliases: &[],
    summary: "two splines and a differential equation between them: minor loops without jumps",
    reference: "Tellinen 1998, doi:10.1109/20.706508",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    basis: |design| Ok(Box::new(TellinenBasis::even(design)?)),
    load: |params, ts| Ok(Arc::new(Tellinen::new(ts, parse("tellinen", params)?)?)),
    example: |ts| Ok(Arc::new(Tellinen::new(ts, example(1.0)?)?)),
};

/// Cells of the table.
const CELLS: usize = 1000;

/// Upper bound of the integral of one cell: exp(-50) is negligible.
const CLOSED: f64 = 50.0;

/// The integrals of dz_d / (2 v) and dz_a / (2 v) from the lowest input to the end of each cell.
#[derive(Debug, Clone, PartialEq)]
struct Decay<R> {
    low: f64,
    cell: f64,
    rising: Vec<R>,
    falling: Vec<R>,
}

impl<R: Real> Decay<R> {
    /// The integrals for the curves (m, v).
    fn of((low, high): (f64, f64), curves: impl Fn(f64) -> (R, R)) -> Self {
        let cell = (high - low) / CELLS as f64;
        let zero = R::from(0.0);
        let (mut rising, mut falling) = (vec![zero], vec![zero]);
        let (mut sums, mut start) = ((zero, zero), curves(low));
        for i in 0..CELLS {
            let at = |part: f64| curves(low + cell * (i as f64 + part));
            let (width, end) = (R::from(2.0) * at(0.5).1, at(1.0));
            let lost = |dz: R| if width > zero { (dz / width).clamp(zero, CLOSED.into()) } else { CLOSED.into() };
            sums.0 = sums.0 + lost((end.0 + end.1) - (start.0 + start.1));
            sums.1 = sums.1 + lost((end.0 - end.1) - (start.0 - start.1));
            rising.push(sums.0);
            falling.push(sums.1);
            start = end;
        }
        Decay { low, cell, rising, falling }
    }

    /// The side after a path from `before` to `u`.
    fn side(&self, side: R, before: f64, u: f64) -> R {
        let one = R::from(1.0);
        if u > before {
            (one + side) * (-(at(&self.rising, self.place(u)) - at(&self.rising, self.place(before)))).exp() - one
        } else if u < before {
            one - (one - side) * (-(at(&self.falling, self.place(before)) - at(&self.falling, self.place(u)))).exp()
        } else {
            side
        }
    }

    /// Position of `u` in the table [cells].
    fn place(&self, u: f64) -> f64 {
        ((u - self.low) / self.cell).clamp(0.0, CELLS as f64)
    }
}

/// `table` at `place`, interpolated linearly.
fn at<R: Real>(table: &[R], place: f64) -> R {
    let i = (place as usize).min(CELLS - 1);
    table[i] + (table[i + 1] - table[i]) * (place - i as f64).into()
}

/// Increment of `table` over the cell at `place`; 0 outside the table.
fn added(table: &[f64], place: f64) -> f64 {
    let i = (place as usize).min(CELLS - 1);
    if place > 0.0 && place < CELLS as f64 { table[i + 1] - table[i] } else { 0.0 }
}

/// z for the values of m and v at the input.
fn between<R: Real>((m, v): (R, R), side: R) -> R {
    if v.value() > 0.0 { m + side * v } else { m }
}

impl Tellinen {
    /// A block with sampling period `ts` [s] between `branches`. Returns an error if `ts` is not positive.
    pub(super) fn new(ts: f64, branches: Branches) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        let decay = Decay::of(branches.range(), |u| curves(&branches, u));
        Ok(Tellinen { ts, branches, decay })
    }
}

/// m and v at `u`.
fn curves(branches: &Branches, u: f64) -> (f64, f64) {
    let (a, d) = (branches.ascending(u), branches.descending(u));
    (0.5 * (d + a), 0.5 * (d - a))
}

impl System for Tellinen {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        2
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        x[1] = self.decay.side(x[1], x[0], u);
        x[0] = u;
        between(curves(&self.branches, u), x[1])
    }
}

impl Hysteresis for Tellinen {
    fn operator(&self) -> &'static Operator {
        &OPERATOR
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.branches)
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some(self.branches.range())
    }

    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        let (before, half) = (x[0], Dual::from(0.5));
        let ahead = |u| {
            let (a, d) = self.branches.slopes(u);
            let (side, place) = (self.decay.side(x[1], before, u), self.decay.place(u));
            let lost = if u > before {
                (1.0 + side) * added(&self.decay.rising, place)
            } else if u < before {
                (side - 1.0) * added(&self.decay.falling, place)
            } else {
                0.0
            };
            between((half * (d + a), half * (d - a)), Dual { value: side, slope: -lost / self.decay.cell })
        };
        by_slopes(before, z, ends, ahead).unwrap_or_else(|| by_trials(self, x, z, ends))
    }

    fn block(&self) -> Option<Block> {
        let block = Block::new("hysteresis", format!("{}: {}", OPERATOR.name, OPERATOR.summary));
        let block = block.number("last", 0.0).number("side", 0.0);
        let Decay { low, cell, rising, falling } = &self.decay;
        let block = block.constant("lowest", *low).constant("cell", *cell).count("cells", CELLS);
        let block = block.table("decay", &[&rising[..], falling].concat());
        Some(Branches::block(block, std::iter::once(&self.branches)).text(STEP))
    }
}

const STEP: &str = "
// The integral up to u, of the table that begins at `first`, and what the cell of u adds to it; nothing beyond the ends.
fn decayed(first: whole, u) {
    let place = clamp((u - lowest) / cell, 0.0, real(cells));
    let i = 0;
    // Not so where it is no number.
    if place >= 1.0 { i = whole(place); }
    if i == cells { i = cells - 1; }
    let more = decay[first + i + 1] - decay[first + i];
    let integral = decay[first + i] + more * (place - real(i));
    if place <= 0.0 || place >= real(cells) { more = 0.0; }
    return integral, more;
}

// The side, from -1 (ascending) to 1 (descending), after a path from `before` to u, and its slope.
fn side_after(side, before, u) {
    let after = side;
    let slope = 0.0;
    let first = 0;
    if u < before { first = cells + 1; }
    let begun, less = decayed(first, before);
    let ended, more = decayed(first, u);
    if u > before {
        after = (1.0 + side) * exponential(-(ended - begun)) - 1.0;
        slope = -((1.0 + after) * more) / cell;
    } else if u < before {
        after = 1.0 - (1.0 - side) * exponential(-(begun - ended));
        slope = -((after - 1.0) * more) / cell;
    }
    return after, slope;
}

// z at u between the branches, and the slope; where they touch or cross the loop is closed.
fn between_branches(u, side, side_slope) {
    let ascending, ascending_slope = branch(0, u);
    let descending, descending_slope = branch(1, u);
    let z = 0.5 * (descending + ascending);
    let slope = 0.5 * (descending_slope + ascending_slope);
    let half = 0.5 * (descending - ascending);
    if half > 0.0 {
        z += side * half;
        slope += side_slope * half + side * (0.5 * (descending_slope - ascending_slope));
    }
    return z, slope;
}

fn hysteresis(x: hysteresis, u) {
    let side, side_slope = side_after(x.side, x.last, u);
    x.side = side;
    x.last = u;
    let z, slope = between_branches(u, side, side_slope);
    return z;
}

// What the next step would give, and the slope.
fn hysteresis_ahead(x: hysteresis, u) {
    let side, side_slope = side_after(x.side, x.last, u);
    let z, slope = between_branches(u, side, side_slope);
    return z, slope;
}
";

/// The basis: one weight. Shape parameters are the values of m - u (bends) and v (widths) at the knots, relative to
/// half the range.
#[derive(Debug, Clone)]
struct TellinenBasis {
    nodes: Nodes,
    /// Values at the knots between the ends.
    bends: Vec<f64>,
    widths: Vec<f64>,
    /// The operator of weight 1.
    operator: Tellinen,
}

/// Default number of knots between the ends.
const KNOTS: usize = 5;
static BENDS: [&str; 9] = ["bend_1", "bend_2", "bend_3", "bend_4", "bend_5", "bend_6", "bend_7", "bend_8", "bend_9"];
static WIDTHS: [&str; 9] =
    ["width_1", "width_2", "width_3", "width_4", "width_5", "width_6", "width_7", "width_8", "width_9"];

impl TellinenBasis {
    /// Branches with bends of 0 and widths of 0.1.
    fn even(design: &BasisDesign) -> Result<Self, Error> {
        let n = design.elements.unwrap_or(KNOTS).clamp(1, BENDS.len());
        let nodes = Nodes::of(design.range, n + 2)?;
        TellinenBasis::new(design.ts, nodes, vec![0.0; n], vec![0.1; n])
    }

    fn new(ts: f64, nodes: Nodes, bends: Vec<f64>, widths: Vec<f64>) -> Result<Self, Error> {
        let operator = Tellinen::new(ts, branches(&nodes, &bends, &widths, 1.0)?)?;
        Ok(TellinenBasis { nodes, bends, widths, operator })
    }

    /// dz/dp_j.
    fn slope(&self, j: usize, weight: f64, u: &[f64]) -> Vec<f64> {
        let (n, half) = (self.bends.len(), half(self.nodes.knots()));
        let curves = |u: f64| {
            let (m, v) = curves(&self.operator.branches, u);
            let (bend, width) = match j.checked_sub(n) {
                None => (half * self.nodes.middle(j + 1, u), 0.0),
                Some(k) => (0.0, half * self.nodes.side(k + 1, u)),
            };
            (Dual { value: m, slope: bend }, Dual { value: v, slope: width })
        };
        let decay = Decay::of(self.operator.branches.range(), curves);
        let (mut before, mut side) = (0.0, Dual::from(0.0));
        let slope_at = |&u: &f64| {
            side = decay.side(side, before, u);
            before = u;
            weight * between(curves(u), side).slope
        };
        u.iter().map(slope_at).collect()
    }
}

/// Half the range of the knots.
fn half(knots: &[f64]) -> f64 {
    0.5 * (knots[knots.len() - 1] - knots[0])
}

fn branches(nodes: &Nodes, bends: &[f64], widths: &[f64], weight: f64) -> Result<Branches, Error> {
    let (knots, half) = (nodes.knots(), half(nodes.knots()));
    let ended = |inner: &[f64]| [&[0.0], inner, &[0.0]].concat();
    let middle: Vec<f64> = knots.iter().zip(ended(bends)).map(|(u, bend)| weight * (u + half * bend)).collect();
    let side: Vec<f64> = ended(widths).iter().map(|width| weight * half * width).collect();
    nodes.branches_of(&middle, &side)
}

impl Basis for TellinenBasis {
    fn len(&self) -> usize {
        1
    }

    fn order(&self) -> usize {
        self.operator.order()
    }

    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]) {
        phi[0] = self.operator.step(x, u);
    }

    fn non_negative(&self) -> Vec<bool> {
        vec![true]
    }

    fn shape(&self) -> Vec<ShapeParameter> {
        let bend = |(&value, name): (&f64, &&'static str)| ShapeParameter { name, value, low: -0.25, high: 0.25 };
        let width = |(&value, name): (&f64, &&'static str)| ShapeParameter { name, value, low: 1e-3, high: 0.5 };
        let bends = self.bends.iter().zip(&BENDS).map(bend);
        bends.chain(self.widths.iter().zip(&WIDTHS).map(width)).collect()
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        let n = self.bends.len();
        counted(OPERATOR.name, "shape", shape.len(), 2 * n)?;
        let (bends, widths) = (shape[..n].to_vec(), shape[n..].to_vec());
        Ok(Box::new(TellinenBasis::new(self.operator.ts, self.nodes.clone(), bends, widths)?))
    }

    fn slopes(&self, weights: &[f64], u: &[f64]) -> Vec<Vec<f64>> {
        (0..2 * self.bends.len()).map(|j| self.slope(j, weights[0], u)).collect()
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        counted(OPERATOR.name, "weights", weights.len(), 1)?;
        let branches = branches(&self.nodes, &self.bends, &self.widths, weights[0])?;
        Ok(Arc::new(Tellinen::new(self.operator.ts, branches)?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::inverse;
    use super::super::tests::path;
    use super::*;
    use crate::program::{Machine, Program};
    use piezoid_testing::assert_close;

    fn block() -> Tellinen {
        Tellinen::new(1.0, example(2.0).unwrap()).unwrap()
    }

    /// A block between two lines that are bent at 0 by -`width` and by `width`.
    fn bent(end: f64, width: f64) -> Tellinen {
        let branch = |z: f64| (vec![-end, 0.0, end], vec![-end, z, end]);
        Tellinen::new(1.0, Branches::new(branch(-width), branch(width)).unwrap()).unwrap()
    }

    #[test]
    fn between_the_ends_of_the_range_it_is_on_its_branches() {
        let (block, u) = (block(), path(&[-30.0, 30.0], 40));
        let known: Vec<f64> = u.iter().map(|u| block.branches.ascending(*u)).collect();
        assert_close(&block.resume(&mut block.settled(-30.0), &u), &known, 0.0, 1e-9);
    }

    #[test]
    fn the_division_of_a_path_into_samples_has_no_effect() {
        let reversals = [0.0, 20.0, -10.0, 15.0, 3.0, -29.0, 12.0];
        let last = |pieces| *block().simulate(&path(&reversals, pieces)).last().unwrap();
        assert_close(&[last(1000)], &[last(1)], 1e-10, 0.0);
    }

    #[test]
    fn an_inverted_loop_is_closed_and_has_no_jump() {
        let z = bent(10.0, -1.0).simulate(&[-10.0, 5.0, 4.999]);
        assert!((z[2] - z[1]).abs() < 0.01, "{z:?}");
    }

    #[test]
    fn a_reversal_leaves_the_branch_without_a_jump() {
        let z = bent(30.0, 2.0).simulate(&[-30.0, 0.0, -0.1]);
        assert!((z[1] + 2.0).abs() < 1e-9 && (z[2] - z[1]).abs() < 0.1, "{z:?}");
    }

    #[test]
    fn the_slopes_by_the_shape_are_proportional_to_the_weight() {
        let design = BasisDesign { ts: 1.0, range: (-10.0, 30.0), elements: Some(2), frequencies: Vec::new() };
        let basis = TellinenBasis::even(&design).unwrap();
        let u = path(&[0.0, 25.0, -5.0, 12.0], 20);
        let slopes = |weight: f64| basis.slopes(&[weight], &u).concat();
        let known: Vec<f64> = slopes(1.0).iter().map(|slope| 2.5 * slope).collect();
        assert!(known.iter().any(|slope| *slope != 0.0));
        assert_close(&slopes(2.5), &known, 1e-14, 0.0);
    }

    #[test]
    fn beyond_ends_that_are_open_the_inverse_is_that_of_its_program() {
        let branch = |z: f64| (vec![-10.0, 0.0, 10.0], vec![z - 12.0, z, z + 9.0]);
        let block = Tellinen::new(1.0, Branches::new(branch(-1.0), branch(1.5)).unwrap()).unwrap();
        let mut program = Program::new(vec![Block::elementary(), block.block().unwrap()]).unwrap();
        inverse(&mut program).unwrap();
        let mut machine = Machine::new(&program, "hysteresis", false);
        let mut x = block.initial();
        for t in 0..200 {
            // About the upper end, then about the lower one.
            let u = if t < 100 { 10.5 } else { -10.5 } + 2.5 * (1.1 * f64::from(t)).sin();
            let z = block.step(&mut x.clone(), u);
            let back = block.invert(&x, z, (-40.0, 40.0)).u;
            let found = machine.call("hysteresis_inverse", &[z, -40.0, 40.0]).unwrap()[0];
            assert_eq!(found.to_bits(), back.to_bits(), "{found}, not {back}, at {t}");
            assert_close(&[back], &[u], 1e-9, 1e-9);
            block.step(&mut x, u);
            machine.call("hysteresis", &[u]).unwrap();
        }
    }
}
