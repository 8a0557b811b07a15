//! Preisach: a population of relays with constant density in each cell of a triangular grid.
//!
//! ```text
//! z = r(u) + sum over cells of w_ij times the share of the cell's relays that are up, minus those up at rest
//! ```
//! The reversible curve r is linear between the levels, and 0 at u = 0. The share is an exact area, so z is continuous
//! for any grid. A loop between any two inputs has its own shape; closed loops are wiped out; minor loops over the same
//! input range are congruent. With w >= 0 every loop dissipates energy.
//! At rest (u = 0) the relays are demagnetised; if all inputs have one sign, that is the state after switching off.
//!
//! Reference: I. D. Mayergoyz, "Mathematical Models of Hysteresis", Springer (1991), DOI 10.1007/978-1-4612-3028-1; for
//! piezo actuators P. Ge & M. Jouaneh, Precision Engineering 17 (1995), DOI 10.1016/0141-6359(95)00002-U. It does not
//! do: rate, accommodation (minor loops that drift towards a limit).
//!
//! Inverse: Newton's method on the quadratic pieces of z(u), from the memory, which does not change. Outside the
//! outermost levels z has the slope of r; if that is 0, z saturates.

mod everett;
mod grid;
mod memory;
mod reversible;

use super::basis::{Basis, BasisDesign, SensitiveOperator, counted, counted_within, curvature};
use super::inverse::{Inverted, by_slopes, by_trials};
use super::real::{Dual, Real, Sensitive};
use super::{Class, Hysteresis, Operator, document, parse};
use crate::program::Block;
use everett::Everett;
use grid::{Grid, cell, cells};
use memory::{BranchStart, Memory};
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::system::System;
use reversible::{ReversibleCurve, parts};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::Arc;

/// Default number of rows over the input range, and number of additional rows on each side. The data do not determine
/// the weights of the additional rows, only smoothness does. They serve inputs slightly outside the range.
const ROWS: usize = 30;
const BEYOND: usize = 2;

/// Maximum number of rows.
const MAX_ROWS: usize = 200;

/// The block that runs.
///
/// State: see [`memory`]; the value is the sum over the cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Preisach {
    ts: f64,
    params: PreisachParams,
    reversible: ReversibleCurve,
    everett: Everett,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PreisachParams {
    /// Input range of the identification data [input unit].
    range: (f64, f64),
    /// Edges of the cells [input unit].
    levels: Vec<f64>,
    /// Slope of the reversible curve, in addition to its rises.
    slope: f64,
    /// Rise of the reversible curve over each interval between the levels; empty if it is straight.
    #[serde(default)]
    reversible: Vec<f64>,
    /// One per cell, by ascending alpha, then by ascending beta.
    weights: Vec<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "preisach",
    aliases: &[],
    summary: "relays on a triangular grid: asymmetric loops of any shape, minor loops, wiping-out",
    reference: "Mayergoyz 1991, doi:10.1007/978-1-4612-3028-1",
    minor_loops: true,
    needs_minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    class: Class::Relays,
    basis: |design| Ok(Box::new(CellBasis::new(design)?)),
    load: |params, ts| Ok(Arc::new(Preisach::new(ts, parse("preisach", params)?)?)),
    example: |ts| {
        let design = BasisDesign { ts, range: (-30.0, 30.0), elements: Some(10), frequencies: Vec::new() };
        let cells = CellBasis::new(&design)?;
        let n = cells.grid.rows();
        let density = |i: usize, j: usize| 0.35 / (1.0 + 0.5 * (i - j) as f64) * (1.0 + 0.03 * i as f64);
        let weights = (0..n).flat_map(|i| (0..=i).map(move |j| density(i, j)));
        let m = cells.inside.rows();
        let rises = (0..m).map(|k| 4.2 + 0.1 * (k as f64 - 0.5 * m as f64).abs());
        cells.operator(&rises.chain(weights).collect::<Vec<_>>())
    },
};

/// State layout of [`Preisach`].
const SUM: Memory = Memory { value: 1 };

impl Preisach {
    fn new(ts: f64, params: PreisachParams) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        finite("range", &[params.range.0, params.range.1])?;
        finite("slope", &[params.slope])?;
        finite("weights", &params.weights)?;
        finite("reversible", &params.reversible)?;
        check(&params.levels)?;
        let (levels, rows) = (params.levels.len(), params.levels.len() - 1);
        let count = |name: &str, have: usize, need: usize| match have == need {
            true => Ok(()),
            false => {
                let rule = format!("must be {need} numbers for {levels} levels");
                Err(Error::parameter(name, format!("{have} numbers"), rule))
            }
        };
        count("weights", params.weights.len(), cells(rows))?;
        if !params.reversible.is_empty() {
            count("reversible", params.reversible.len(), rows)?;
        }
        let grid = Grid::new(params.levels.clone());
        let reversible = ReversibleCurve::new(&grid, params.slope, &params.reversible);
        let everett = Everett::new(&grid, &params.weights);
        Ok(Preisach { ts, params, reversible, everett })
    }

    /// The sum over the cells at `u`, on a branch that starts with the value `start`.
    fn sum<R: Real>(&self, branch: BranchStart, start: &[f64], u: R) -> R {
        match branch {
            BranchStart::Rest => self.everett.since_rest(u),
            BranchStart::From(r) if u.value() >= r => R::from(start[0]) + self.everett.between(r.into(), u),
            BranchStart::From(r) => R::from(start[0]) - self.everett.between(u, r.into()),
        }
    }

    /// z and its slope after a step to `u` from the state `x`; `None` if the memory is full.
    fn ahead(&self, x: &[f64], u: f64) -> Option<Dual> {
        let input = Dual { value: u, slope: 1.0 };
        let sum = if u == SUM.input(x) {
            Dual::from(SUM.value(x)[0])
        } else {
            let (branch, start) = SUM.ahead(x, u)?;
            self.sum(branch, start, input)
        };
        Some(self.reversible.at(input) + sum)
    }
}

/// Returns an error unless the levels are ascending.
fn check(levels: &[f64]) -> Result<(), Error> {
    finite("levels", levels)?;
    counted_within("levels", levels.len(), 2, MAX_ROWS + 1)?;
    match levels.windows(2).position(|w| w[0] >= w[1]) {
        None => Ok(()),
        Some(k) => {
            let rule = format!("must be above levels[{k}] = {}: levels must be ascending", levels[k]);
            Err(Error::parameter(format!("levels[{}]", k + 1), levels[k + 1], rule))
        }
    }
}

impl System for Preisach {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        SUM.order()
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        if u != SUM.input(x) {
            let (branch, start, now) = SUM.travel(x, u);
            now[0] = self.sum(branch, start, u);
        }
        self.reversible.at(u) + SUM.value(x)[0]
    }
}

impl Hysteresis for Preisach {
    fn operator(&self) -> &'static Operator {
        &OPERATOR
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.params)
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some(self.params.range)
    }

    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        let none = Dual::from(f64::NAN);
        let ahead = |u| self.ahead(x, u).unwrap_or(none);
        by_slopes(SUM.input(x), z, ends, ahead).unwrap_or_else(|| by_trials(self, x, z, ends))
    }

    fn block(&self) -> Option<Block> {
        let block = Block::new("hysteresis", format!("{}: {}", OPERATOR.name, OPERATOR.summary));
        let block = self.everett.block(memory::block(block));
        Some(self.reversible.block(block).text(STEP))
    }
}

const STEP: &str = "
// The weighted sum at u and its slope, on the branch that began at the reversal with this number; if that one is not stored, it is the present input.
fn on_branch(x: hysteresis, reversals: whole, u) {
    let sum = 0.0;
    let slope = 0.0;
    if reversals == 0 {
        let turned, rises = since_rest(u);
        sum = turned;
        slope = rises;
    } else {
        let begun = x.last;
        let start = x.sum;
        let i = 2 * (reversals - 1);
        if reversals <= whole(stored(x)) {
            begun = x.reversal[i];
            start = x.reversal[i + 1];
        }
        // While u falls, the lower limit moves and the weights of the switched relays are subtracted.
        let up = 0.0;
        let low = u;
        let high = begun;
        if u >= begun {
            up = 1.0;
            low = begun;
            high = u;
        }
        let turned, rises = everett(low, high, 1.0 - up, up);
        sum = start - turned;
        slope = -rises;
        if up > 0.0 {
            sum = start + turned;
            slope = rises;
        }
    }
    return sum, slope;
}

fn hysteresis(x: hysteresis, u) {
    if u != x.last {
        if turns(x, u) > 0.0 { remember(x); }
        x.count = kept(x, whole(stored(x)), u);
        let sum, slope = on_branch(x, whole(stored(x)), u);
        x.last = u;
        x.sum = sum;
    }
    let curve, rises = reversible(u);
    return curve + x.sum;
}

// The value that the next step would give, and its slope. If the memory of reversals is full, the result is the largest number with slope -1, so that the caller uses the other search.
fn hysteresis_ahead(x: hysteresis, u) {
    let curve, steep = reversible(u);
    let z = curve + x.sum;
    let slope = steep;
    if u != x.last {
        let reversals = whole(stored(x)) + whole(turns(x, u));
        if reversals > capacity {
            z = most;
            slope = -1.0;
        } else {
            let sum, rises = on_branch(x, whole(kept(x, reversals, u)), u);
            z = curve + sum;
            slope = steep + rises;
        }
    }
    return z, slope;
}
";

/// The responses of each interval of the reversible curve inside the range, and of each cell.
///
/// State: see [`memory`]; the value has one number per cell.
#[derive(Debug, Clone, PartialEq)]
struct CellBasis {
    ts: f64,
    range: (f64, f64),
    grid: Grid,
    /// The levels inside the range: outside, the slope of the reversible curve continues.
    inside: Grid,
    memory: Memory,
}

impl CellBasis {
    fn new(design: &BasisDesign) -> Result<Self, Error> {
        let rows = design.elements.unwrap_or(ROWS).clamp(1, MAX_ROWS - 2 * BEYOND);
        let (low, high) = design.range;
        let h = (high - low) / rows as f64;
        let level = |k: usize| low + h * (k as f64 - BEYOND as f64);
        let levels: Vec<f64> = (0..=rows + 2 * BEYOND).map(level).collect();
        check(&levels)?;
        let memory = Memory { value: cells(levels.len() - 1) };
        let inside = Grid::new(levels[BEYOND..=rows + BEYOND].to_vec());
        Ok(CellBasis { ts: design.ts, range: design.range, grid: Grid::new(levels), inside, memory })
    }
}

impl Basis for CellBasis {
    fn len(&self) -> usize {
        self.inside.rows() + self.memory.value
    }

    fn order(&self) -> usize {
        self.memory.order()
    }

    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]) {
        if u != self.memory.input(x) {
            let (branch, start, now) = self.memory.travel(x, u);
            match branch {
                BranchStart::Rest => self.grid.since_rest(u, |k, share| now[k] = if u < 0.0 { -share } else { share }),
                BranchStart::From(r) => {
                    now.copy_from_slice(start);
                    self.grid.between(r.min(u), r.max(u), if u >= r { 1.0 } else { -1.0 }, now);
                }
            }
        }
        let (curve, shares) = phi.split_at_mut(self.inside.rows());
        parts(&self.inside, u, |k, part| curve[k] = part);
        shares.copy_from_slice(self.memory.value(x));
    }

    fn non_negative(&self) -> Vec<bool> {
        vec![true; self.len()]
    }

    fn sensitive<'a>(&'a self, weights: &'a [Sensitive], _: &'a [Sensitive]) -> Option<SensitiveOperator<'a>> {
        let (rises, weights) = weights.split_at(self.inside.rows());
        let (first, last) = ([rises[0]; BEYOND], [rises[rises.len() - 1]; BEYOND]);
        let curve = ReversibleCurve::new(&self.grid, 0.0, &[&first, rises, &last].concat());
        let everett = Everett::new(&self.grid, weights);
        let mut x = vec![Sensitive::from(0.0); SUM.order()];
        Some(Box::new(move |u| {
            if u.value != SUM.input(&x) {
                let (branch, start, now) = SUM.travel(&mut x, u);
                now[0] = match branch {
                    BranchStart::Rest => everett.since_rest(u),
                    BranchStart::From(r) if u.value >= r.value => start[0] + everett.between(r, u),
                    BranchStart::From(r) => start[0] - everett.between(u, r),
                };
            }
            curve.at(u) + SUM.value(&x)[0]
        }))
    }

    /// Second differences of the rises, and of the density along both axes and along the diagonals.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        let (n, curve) = (self.grid.rows(), self.inside.rows());
        // A cell on the diagonal has half the area.
        let density =
            |i: usize, j: usize, factor: f64| (curve + cell(i, j), if i == j { 2.0 * factor } else { factor });
        let mut rows = curvature(0, curve);
        for i in 0..n {
            for j in 0..=i {
                for (di, dj) in [(1, 0), (0, 1), (1, 1)] {
                    let before = i.checked_sub(di).zip(j.checked_sub(dj)).filter(|(i, j)| j <= i);
                    let (after_i, after_j) = (i + di, j + dj);
                    if let Some((i0, j0)) = before.filter(|_| after_i < n && after_j <= after_i) {
                        rows.push(vec![density(i0, j0, 1.0), density(i, j, -2.0), density(after_i, after_j, 1.0)]);
                    }
                }
            }
        }
        rows
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        counted(OPERATOR.name, "shape", shape.len(), 0)?;
        Ok(Box::new(self.clone()))
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        counted(OPERATOR.name, "weights", weights.len(), Basis::len(self))?;
        let (rises, weights) = weights.split_at(self.inside.rows());
        let (first, last) = ([rises[0]; BEYOND], [rises[rises.len() - 1]; BEYOND]);
        let (reversible, weights) = ([&first, rises, &last].concat(), weights.to_vec());
        let levels = self.grid.levels().to_vec();
        let params = PreisachParams { range: self.range, levels, slope: 0.0, reversible, weights };
        Ok(Arc::new(Preisach::new(self.ts, params)?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::check_program;
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    fn wander(n: usize) -> Vec<f64> {
        (0..n).map(|t| 14.0 * (t as f64 * 0.11).sin() + 13.0 * (t as f64 * 0.37).sin() - 3.0).collect()
    }

    fn basis(range: (f64, f64), rows: usize) -> CellBasis {
        CellBasis::new(&BasisDesign { ts: 1e-3, range, elements: Some(rows), frequencies: Vec::new() }).unwrap()
    }

    #[test]
    fn the_block_is_the_weighted_sum_of_its_cells() {
        let cells = basis((-20.0, 31.0), 9);
        let weights: Vec<f64> = (0..Basis::len(&cells)).map(|k| 0.1 + (k as f64 * 2.3).sin().abs()).collect();
        let block = cells.operator(&weights).unwrap();
        let (mut x, mut phi) = (Basis::initial(&cells), vec![0.0; Basis::len(&cells)]);
        let sum = |&u: &f64| {
            Basis::step(&cells, &mut x, u, &mut phi);
            phi.iter().zip(&weights).map(|(phi, w)| phi * w).sum()
        };
        let sums: Vec<f64> = wander(2000).iter().map(sum).collect();
        assert_close(&sums, &block.simulate(&wander(2000)), 0.0, 1e-10);
    }

    #[test]
    fn the_block_approximates_a_sum_of_many_relays() {
        let example = (OPERATOR.example)(1e-3).unwrap();
        let p: PreisachParams = parse("preisach", Value::Object(example.params())).unwrap();
        // 60 x 60 relays per cell: up above alpha, down below beta, at rest up where alpha + beta < 0.
        let (n, m) = (p.levels.len() - 1, 60);
        let mut relays = Vec::new();
        for i in 0..n {
            for j in 0..=i {
                let place =
                    |k: usize, s: usize| p.levels[k] + (p.levels[k + 1] - p.levels[k]) * (s as f64 + 0.5) / m as f64;
                let inside: Vec<(f64, f64)> = (0..m * m)
                    .map(|s| (place(i, s / m), place(j, s % m)))
                    .filter(|(alpha, beta)| alpha > beta)
                    .collect();
                let each = p.weights[cell(i, j)] / inside.len() as f64;
                relays.extend(inside.into_iter().map(|(alpha, beta)| (alpha, beta, each, alpha + beta < 0.0)));
            }
        }
        let curve = ReversibleCurve::new(&Grid::new(p.levels.clone()), p.slope, &p.reversible);
        let at_rest: f64 = relays.iter().filter(|r| r.3).map(|r| r.2).sum();
        let u = wander(150);
        let step = |&u: &f64| {
            relays.iter_mut().for_each(|(alpha, beta, _, up)| *up = u >= *alpha || (*up && u > *beta));
            curve.at(u) + relays.iter().filter(|r| r.3).map(|r| r.2).sum::<f64>() - at_rest
        };
        assert_close(&u.iter().map(step).collect::<Vec<_>>(), &example.simulate(&u), 0.0, 0.03);
    }

    #[test]
    fn a_ring_down_longer_than_the_memory_ends_at_the_right_value() {
        let example = (OPERATOR.example)(1e-3).unwrap();
        let ring = |n: usize| {
            let shrinking = |t: usize| 29.0 * (1.0 - t as f64 / n as f64) * (TAU * t as f64 / 4.0).sin();
            let u: Vec<f64> = (0..n).map(shrinking).chain([0.0]).collect();
            example.simulate(&u)[n]
        };
        assert_close(&[ring(4000)], &[ring(100)], 0.0, 0.05);
    }

    #[test]
    fn the_program_is_bit_identical_when_the_memory_is_full() {
        let shrinking = |t: usize| 29.0 * (1.0 - t as f64 / 700.0) * (TAU * t as f64 / 4.0).sin();
        let u: Vec<f64> = (0..700).map(shrinking).chain(wander(300)).chain((0..200).map(shrinking)).collect();
        check_program(&*(OPERATOR.example)(1e-3).unwrap(), &u);
    }

    #[test]
    fn a_narrow_range_far_from_rest_is_as_accurate_as_others() {
        let cells = basis((-68.5, -68.4), 7);
        let weights: Vec<f64> =
            (0..Basis::len(&cells)).map(|k| f64::from(u8::from(k >= cells.inside.rows()))).collect();
        let (mut x, mut phi) = (Basis::initial(&cells), vec![0.0; weights.len()]);
        Basis::step(&cells, &mut x, -68.43, &mut phi);
        let z = cells.operator(&weights).unwrap().simulate(&[-68.43]);
        assert_close(&[phi[cells.inside.rows()..].iter().sum()], &z, 0.0, 1e-9);
    }

    #[test]
    fn levels_that_are_not_ascending_are_an_error() {
        let load = |levels: &str| {
            let text = format!(r#"{{"range": [0, 1], "slope": 1, "levels": {levels}, "weights": [1]}}"#);
            (OPERATOR.load)(serde_json::from_str(&text).unwrap(), 1.0).map(|_| ()).map_err(|e| e.to_string())
        };
        assert!(load("[1, 0]").unwrap_err().starts_with("levels[1] = 0"));
        assert!(load("[1]").is_err() && load("[0, 1, 2]").unwrap_err().contains("must be 3 numbers"));
        assert!(load("[0, 1]").is_ok());
    }

    #[test]
    fn a_file_with_a_slope_alone_has_a_straight_reversible_curve() {
        let load = |more: &str| {
            let text = format!(r#"{{"range": [0, 1], "levels": [0, 1, 2], "weights": [0, 0, 0], {more}}}"#);
            (OPERATOR.load)(serde_json::from_str(&text).unwrap(), 1.0).map_err(|e| e.to_string())
        };
        let u = [-1.0, 0.25, 0.8, 1.5, 3.0];
        assert_eq!(load(r#""slope": 0.5"#).unwrap().simulate(&u), u.map(|u| 0.5 * u));
        assert_eq!(load(r#""slope": 0, "reversible": [0.5, 1]"#).unwrap().simulate(&u), [-0.5, 0.125, 0.4, 1.0, 2.5]);
        assert!(
            load(r#""slope": 0, "reversible": [1]"#)
                .unwrap_err()
                .starts_with("reversible = 1 numbers: must be 2 numbers")
        );
    }

    #[test]
    fn there_are_two_levels_or_more_but_not_above_two_hundred_rows() {
        let levels = |n: u32| -> Vec<f64> { (0..n).map(f64::from).collect() };
        assert!(check(&levels(2)).is_ok() && check(&levels(201)).is_ok());
        for n in [1, 202] {
            let message = check(&levels(n)).unwrap_err().to_string();
            assert_eq!(message, format!("levels = {n} numbers: must be 2 to 201 numbers"));
        }
    }

    #[test]
    fn an_inverse_after_the_first_movement_returns_the_input() {
        let example = (OPERATOR.example)(1e-3).unwrap();
        for first in [10.0, -10.0] {
            let mut x = example.initial();
            example.step(&mut x, first);
            for u in [1.5, 0.9, 0.3, -0.2, -0.5, -0.7, -0.9, -1.2, -2.0].map(|share| share * first) {
                let z = example.step(&mut x.clone(), u);
                assert_close(&[example.invert(&x, z, (-30.0, 30.0)).u], &[u], 1e-9, 1e-9);
            }
        }
    }

    #[test]
    fn an_input_that_is_no_number_wipes_out_nothing() {
        let example = (OPERATOR.example)(1e-3).unwrap();
        let mut x = example.initial();
        example.resume(&mut x, &[10.0, -5.0, f64::NAN]);
        assert_eq!(x[0], 1.0);
    }
}
