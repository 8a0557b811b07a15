//! The paper's hysteresis block: one function of u for rising and one for falling input (section 2.2).
//!
//! ```text
//! z = a(u) while u rises,    d(u) while u falls,    (a(u) + d(u)) / 2 until it first moves
//! ```
//! a and d are cubic splines (not-a-knot) through the knots of the file. Outside its knots a branch is a straight line,
//! with the slope from its first to its last knot.
//!
//! The printed rule uses one function if u_t > u_{t-1} and the other one *otherwise*, so held samples always use the
//! second one. In a staircase input these are most samples. The default therefore keeps the last direction while u is
//! held. The paper calls the first function "upper"; here it is the ascending branch. The data decide which one that
//! is; in a piezo loop it lies below.
//!
//! It does not do: minor loops (its only memory is the direction: each reversal inside the loop jumps to the other
//! branch), changes of amplitude or offset.
//!
//! Inverse: Newton's method on the spline of the branch in the direction of the requested z. If the jump at a reversal
//! skips the requested z, bracketing returns the nearer side of the jump. There is no saturation.

use super::basis::counted;
use super::inverse::{Inverted, by_slopes, by_trials};
use super::nodes::Nodes;
use super::real::{Dual, Real};
use super::{Basis, Branches, Class, Hysteresis, Operator, document, parse};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::Arc;

/// The branch that is used while the input is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeldInput {
    /// The branch of the last movement: the output does not depend on how long an input is held.
    #[default]
    Held,
    /// The descending branch, the "otherwise" of the paper's rule: a held input changes the output.
    Printed,
}

impl HeldInput {
    /// The direction for a step from `before` to `u` after the last `direction`: +1, -1, or 0 (not yet known).
    pub(super) fn direction(self, before: f64, u: f64, direction: f64) -> f64 {
        if u > before {
            1.0
        } else if u < before || self == HeldInput::Printed {
            -1.0
        } else {
            direction
        }
    }

    /// The direction of a held input, as text in a program.
    pub(super) fn held(self) -> &'static str {
        match self {
            HeldInput::Held => "x.direction",
            HeldInput::Printed => "-1.0",
        }
    }
}

/// Two functions of u, selected by the direction of u. Until u first moves, z is their mean (with the printed rule, the
/// descending branch).
///
/// State: the last input, the direction (1 rising, -1 falling, 0 not yet known).
#[derive(Debug, Clone, PartialEq)]
pub struct TwoBranch {
    ts: f64,
    params: TwoBranchParams,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TwoBranchParams {
    #[serde(default)]
    reading: HeldInput,
    #[serde(flatten)]
    branches: Branches,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "two-branch",
    aliases: &[],
    summary: "one spline for rising and one for falling input; no minor loops",
    reference: "Kuklisova Pavelkova, ICINCO 2025, section 2.2",
    minor_loops: false,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Branches,
    basis: |design| Ok(Box::new(TwoBranchBasis { ts: design.ts, nodes: Nodes::new(design)? })),
    load: |params, ts| {
        let TwoBranchParams { reading, branches } = parse("two-branch", params)?;
        Ok(Arc::new(TwoBranch::new(ts, branches, reading)?))
    },
    example: |ts| Ok(Arc::new(TwoBranch::new(ts, example(1.0)?, HeldInput::Held)?)),
};

/// A loop `width` volts wide at +-30 V.
pub(super) fn example(width: f64) -> Result<Branches, Error> {
    let u: Vec<f64> = (-3..=3).map(|k| f64::from(k) * 10.0).collect();
    let z = |side: f64| u.iter().map(|u| u + side * width * (1.0 - u * u / 900.0)).collect();
    Branches::new((u.clone(), z(-1.0)), (u.clone(), z(1.0)))
}

impl TwoBranch {
    /// A block with sampling period `ts` [s] and the rule `reading` for held inputs.
    ///
    /// # Errors
    /// Returns an error if `ts` is not positive.
    pub fn new(ts: f64, branches: Branches, reading: HeldInput) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        Ok(TwoBranch { ts, params: TwoBranchParams { reading, branches } })
    }

    /// The two branches.
    pub fn branches(&self) -> &Branches {
        &self.params.branches
    }
}

/// z at `u` for movement in `direction`; the mean of the branches if the direction is 0.
pub(super) fn read(branches: &Branches, u: f64, direction: f64) -> f64 {
    choose(|| branches.ascending(u), || branches.descending(u), direction)
}

/// [`read`] with the slope.
pub(super) fn read_slope(branches: &Branches, u: f64, direction: f64) -> Dual {
    let (ascending, descending) = branches.slopes(u);
    choose(|| ascending, || descending, direction)
}

#[inline]
fn choose<R: Real>(ascending: impl FnOnce() -> R, descending: impl FnOnce() -> R, direction: f64) -> R {
    if direction > 0.0 {
        ascending()
    } else if direction < 0.0 {
        descending()
    } else {
        R::from(0.5) * (ascending() + descending())
    }
}

/// [`HeldInput::direction`] and [`read_slope`] as a program with several pairs of branches.
pub(super) const READ: &str = "
// The direction of the input: 1, -1, or 0 while unknown; it keeps its value while the input is constant.
fn heading(before, u, held) {
    let direction = held;
    if u > before { direction = 1.0; }
    if u < before { direction = -1.0; }
    return direction;
}

// z at u when it moves in this direction, and the slope; midway between both branches of the pair while that is not known.
fn read_pair(pair: whole, u, direction) {
    let first = 2 * pair;
    let last = first + 1;
    if direction > 0.0 { last = first; }
    if direction < 0.0 { first = last; }
    let z = 0.0;
    let slope = 0.0;
    for b in first..last + 1 at most 2 {
        let on_branch, rises = branch(b, u);
        z += on_branch;
        slope += rises;
    }
    if direction == 0.0 {
        z = 0.5 * z;
        slope = 0.5 * slope;
    }
    return z, slope;
}
";

const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    x.direction = heading(x.last, u, HELD);
    x.last = u;
    let z, slope = read_pair(0, u, x.direction);
    return z;
}

// What the next step would give, and the slope.
fn hysteresis_ahead(x: hysteresis, u) {
    let z, slope = read_pair(0, u, heading(x.last, u, HELD));
    return z, slope;
}
";

impl System for TwoBranch {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        2
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        vec![u, 0.0]
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        x[1] = self.params.reading.direction(x[0], u, x[1]);
        x[0] = u;
        read(&self.params.branches, u, x[1])
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        let TwoBranchParams { reading, branches } = &self.params;
        let (mut before, mut direction) = (x[0], x[1]);
        for v in signal {
            direction = reading.direction(before, *v, direction);
            before = *v;
            *v = read(branches, *v, direction);
        }
        (x[0], x[1]) = (before, direction);
    }
}

impl Hysteresis for TwoBranch {
    fn operator(&self) -> &'static Operator {
        &OPERATOR
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.params)
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some(self.params.branches.range())
    }

    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        let TwoBranchParams { reading, branches } = &self.params;
        let ahead = |u| read_slope(branches, u, reading.direction(x[0], u, x[1]));
        by_slopes(x[0], z, ends, ahead).unwrap_or_else(|| by_trials(self, x, z, ends))
    }

    fn block(&self) -> Option<Block> {
        let TwoBranchParams { reading, branches } = &self.params;
        let block = Block::new("hysteresis", format!("{}: {}", OPERATOR.name, OPERATOR.summary));
        let block = block.number("last", 0.0).number("direction", 0.0);
        let block = Branches::block(block, std::iter::once(branches));
        Some(block.text(READ).text(&STEP.replace("HELD", reading.held())))
    }
}

/// The basis: both branches by their values at equidistant knots, with [`HeldInput::Held`].
#[derive(Debug, Clone)]
struct TwoBranchBasis {
    ts: f64,
    nodes: Nodes,
}

impl Basis for TwoBranchBasis {
    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn order(&self) -> usize {
        2
    }

    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]) {
        x[1] = HeldInput::Held.direction(x[0], u, x[1]);
        x[0] = u;
        phi.fill(0.0);
        self.nodes.respond(u, -x[1], 1.0, phi);
    }

    fn non_negative(&self) -> Vec<bool> {
        self.nodes.non_negative().collect()
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        self.nodes.roughness(0)
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        counted(OPERATOR.name, "shape", shape.len(), 0)?;
        Ok(Box::new(self.clone()))
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        counted(OPERATOR.name, "weights", weights.len(), self.len())?;
        Ok(Arc::new(TwoBranch::new(self.ts, self.nodes.branches(weights)?, HeldInput::Held)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_input_stays_on_its_branch_except_with_the_printed_rule() {
        let u = [0.0, 10.0, 10.0, 10.0];
        let z = |reading| TwoBranch::new(5e-4, example(1.0).unwrap(), reading).unwrap().simulate(&u);
        let (held, printed) = (z(HeldInput::Held), z(HeldInput::Printed));
        assert_eq!(held[1], held[3]);
        assert_eq!(held[1], printed[1]);
        assert!(printed[2] > printed[1], "the printed rule jumps to the descending branch: {printed:?}");
    }

    #[test]
    fn before_the_first_movement_z_is_the_mean_of_the_branches() {
        let block = TwoBranch::new(5e-4, example(1.0).unwrap(), HeldInput::Held).unwrap();
        assert_eq!(block.simulate(&[0.0, 0.0]), [0.0, 0.0]);
        let mut x = block.settled(10.0);
        assert_eq!(block.step(&mut x, 10.0), 10.0);
    }
}
