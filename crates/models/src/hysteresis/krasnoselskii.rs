//! Krasnosel'skii & Pokrovskii: a weighted grid of relays with ridges instead of jumps.
//!
//! ```text
//! r(v) = 0 below -ridge/2, 1 above ridge/2, a line between
//! k_ij <- max(r(u - s_j), min(r(u - s_i), k_ij))               levels s_i <= s_j
//! z = sum_ij w_ij (k_ij - k_ij at rest)                        w_ij >= 0
//! ```
//! A Preisach model of finite resolution that is continuous in the input: a rising input moves along the ridge at s_j,
//! a falling input along the ridge at s_i. The grid is the triangle of all pairs; pairs with i = j are ramps without
//! memory. At rest a kernel is 1/2, or as close to it as the ridges at u = 0 allow. Minor loops over the same input
//! range are congruent; passed reversals are wiped out; z saturates outside the outermost levels.
//!
//! Reference: M. A. Krasnosel'skii & A. V. Pokrovskii, "Systems with Hysteresis", Springer (1989), DOI
//! 10.1007/978-3-642-61302-9. It does not do: rate.
//!
//! Inverse: Newton's method on z(u), which is piecewise linear. Outside the outermost ridges z is constant and has no
//! inverse.

use super::basis::{BasisDesign, ShapeParameter, counted_within};
use super::law::{Input, Law, Weighted};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::number::short;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Weights: w_11, w_12, w_22, w_13, w_23, w_33, ...: by ascending s_j, then by ascending s_i.
///
/// State: the kernels k_ij minus their value at rest, in the order of the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Krasnoselskii {
    /// s_1 < s_2 < ... [input unit]
    levels: Vec<f64>,
    /// Width of a ridge [input unit].
    ridge: f64,
}

/// Default and maximum number of levels.
const LEVELS: usize = 12;
const MAX_LEVELS: usize = 90;

/// Least ridge, as a share of the distance of two levels: of narrower ones z jumps, and its inverse has to bisect.
const NARROWEST: f64 = 1e-3;

pub(super) static OPERATOR: Operator = Operator {
    name: "krasnoselskii-pokrovskii",
    aliases: &["KP"],
    summary: "a triangular grid of relays with ridges: asymmetric, saturating loops, continuous",
    reference: "Krasnosel'skii & Pokrovskii 1989, doi:10.1007/978-3-642-61302-9",
    minor_loops: true,
    needs_minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    class: Class::Relays,
    load: Weighted::<Krasnoselskii>::load,
    basis: |design| Weighted::basis(design.ts, design.range, Krasnoselskii::even(design)),
    example: |ts| {
        let design = BasisDesign { ts, range: (-30.0, 30.0), elements: None, frequencies: Vec::new() };
        let law = Krasnoselskii::even(&design);
        let near = |k: usize| (0..law.levels.len()).any(|j| index(j, j) == k);
        let weights = (0..law.responses()).map(|k| if near(k) { 2.5 } else { 0.2 }).collect();
        Ok(Arc::new(Weighted::new(ts, design.range, law, weights)?))
    },
};

/// Position of the pair i <= j.
fn index(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

impl Krasnoselskii {
    /// Levels in the middles of equal cells of the range; the ridges touch.
    fn even(design: &BasisDesign) -> Self {
        let n = design.elements.unwrap_or(LEVELS).clamp(1, MAX_LEVELS);
        let cell = 2.0 * design.half() / n as f64;
        Krasnoselskii { levels: (0..n).map(|i| design.range.0 + cell * (i as f64 + 0.5)).collect(), ridge: cell }
    }

    /// The kernels at rest.
    fn at_rest(&self) -> Vec<f64> {
        let ramps: Vec<f64> = self.levels.iter().map(|s| ramp(-s, self.ridge)).collect();
        let row = |j: usize| ramps[..=j].iter().map(move |fall| (j, *fall));
        (0..ramps.len()).flat_map(row).map(|(j, fall)| 0.5.clamp(ramps[j], fall)).collect()
    }
}

/// The ramp r(v).
fn ramp<R: Real>(v: R, ridge: R) -> R {
    (R::from(0.5) + v / ridge).clamp(0.0.into(), 1.0.into())
}

impl Law for Krasnoselskii {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        finite("levels", &self.levels)?;
        positive("ridge", self.ridge, "input units")?;
        counted_within("levels", self.levels.len(), 1, MAX_LEVELS)?;
        let nearest = self.levels.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
        match self.levels.windows(2).position(|w| w[0] >= w[1]) {
            None if nearest.is_finite() && self.ridge < NARROWEST * nearest => {
                let rule = format!(
                    "must be at least {NARROWEST} of the smallest distance of two levels, {}; for relays without \
                     ridges use the operator preisach",
                    short(nearest)
                );
                Err(Error::parameter("ridge", short(self.ridge), rule))
            }
            None => Ok(()),
            Some(i) => {
                let rule = format!("must be above {}: levels must be ascending", self.levels[i]);
                Err(Error::parameter(format!("levels[{}]", i + 1), self.levels[i + 1], rule))
            }
        }
    }

    fn responses(&self) -> usize {
        index(0, self.levels.len())
    }

    fn order(&self) -> usize {
        self.responses()
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], Input { u, .. }: Input<R>, mut phi: impl FnMut(usize, R)) {
        // The ramp of each level, now and at rest: lower and upper bounds of the kernels.
        let (mut now, mut at_rest) = ([R::from(0.0); MAX_LEVELS], [R::from(0.0); MAX_LEVELS]);
        for ((now, at_rest), &s) in now.iter_mut().zip(&mut at_rest).zip(&self.levels) {
            (*now, *at_rest) = (ramp(u - s.into(), shape[0]), ramp((-s).into(), shape[0]));
        }
        let mut kernels = &mut x[..];
        for j in 0..self.levels.len() {
            let (row, next) = std::mem::take(&mut kernels).split_at_mut(j + 1);
            for ((k, &fall), &fall_at_rest) in row.iter_mut().zip(&now).zip(&at_rest) {
                let rest = R::from(0.5).clamp(at_rest[j], fall_at_rest);
                *k = k.clamp(now[j] - rest, fall - rest);
            }
            kernels = next;
        }
        x.iter().enumerate().for_each(|(k, kernel)| phi(k, *kernel));
    }

    fn block(&self, block: Block, _: Input) -> Block {
        let block = block.numbers("kernel", vec![0.0; self.responses()]).table("rest", &self.at_rest());
        block.table("level", &self.levels).count("n", self.levels.len()).text(STEP)
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        let n = self.levels.len();
        let pairs = || (0..n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let bend = |a, b, c| vec![(a, 1.0), (b, -2.0), (c, 1.0)];
        let along_i = pairs().filter(|(i, j)| i + 2 <= *j);
        let along_j = pairs().filter(|(_, j)| j + 2 < n);
        let first = along_i.map(|(i, j)| bend(index(i, j), index(i + 1, j), index(i + 2, j)));
        first.chain(along_j.map(|(i, j)| bend(index(i, j), index(i, j + 1), index(i, j + 2)))).collect()
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let cell = 2.0 * half / self.levels.len() as f64;
        vec![ShapeParameter { name: "ridge", value: self.ridge, low: 0.25 * cell, high: 6.0 * cell }]
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    x.last = u;
    // The ramp of each level: what pairs rise by and fall by.
    let ramp = [0.0; n];
    for i in 0..n {
        ramp[i] = clamp(0.5 + (u - level[i]) / ridge, 0.0, 1.0);
    }
    let z = -0.0;
    let k = 0;
    for j in 0..n {
        for i in 0..j + 1 {
            x.kernel[k] = clamp(x.kernel[k], ramp[j] - rest[k], ramp[i] - rest[k]);
            z += w[k] * x.kernel[k];
            k += 1;
        }
    }
    return z;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn ramps_side_by_side_are_a_line() {
        let design = BasisDesign { ts: 1.0, range: (-10.0, 30.0), elements: Some(5), frequencies: Vec::new() };
        let law = Krasnoselskii::even(&design);
        let weights = (0..law.responses()).map(|k| f64::from(u8::from((0..5).any(|j| index(j, j) == k)))).collect();
        let operator = Weighted::new(1.0, design.range, law, weights).unwrap();
        let u = [0.0, 7.0, 29.0, -9.0, 3.0];
        assert_close(&operator.simulate(&u), &u.map(|u| u / 8.0), 1e-14, 1e-14);
    }

    #[test]
    fn smooth_weights_have_no_roughness() {
        let design = BasisDesign { ts: 1.0, range: (0.0, 1.0), elements: Some(6), frequencies: Vec::new() };
        let law = Krasnoselskii::even(&design);
        let mut plane = vec![0.0; law.responses()];
        (0..6).for_each(|j| (0..=j).for_each(|i| plane[index(i, j)] = 1.0 + 2.0 * i as f64 - 3.0 * j as f64));
        assert_eq!(law.roughness().len(), 2 * 10);
        for row in law.roughness() {
            assert_eq!(row.iter().map(|(k, c)| c * plane[*k]).sum::<f64>(), 0.0);
        }
    }

    #[test]
    fn levels_ascend_and_the_ridge_is_not_much_narrower_than_their_distance() {
        let message = |levels: &[f64], ridge: f64| {
            Krasnoselskii { levels: levels.to_vec(), ridge }.check().err().map(|error| error.to_string())
        };
        assert_eq!(message(&[-1.0, 0.0, 4.0], 1.0), None);
        assert_eq!(message(&[3.0], 1e-9), None);
        let narrow = message(&[-1.0, 0.0, 4.0], 0.999 * NARROWEST).unwrap();
        assert!(narrow.contains("ridge") && narrow.contains("of the smallest distance of two levels, 1"), "{narrow}");
        assert_eq!(message(&[-1.0, 0.0, 4.0], 1.001 * NARROWEST), None);
        for (levels, at, below) in
            [([-1.0, -2.0, 4.0], "levels[1] = -2", "-1"), ([-1.0, 2.0, 2.0], "levels[2] = 2", "2")]
        {
            let message = message(&levels, 1.0).unwrap();
            assert!(message.starts_with(at) && message.contains(&format!("must be above {below}:")), "{message}");
        }
    }

    #[test]
    fn the_narrowest_ridge_is_allowed() {
        assert!(Krasnoselskii { levels: vec![-1.0, 0.0, 4.0], ridge: NARROWEST }.check().is_ok());
    }
}
