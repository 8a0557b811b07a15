//! Bouc-Wen-Baber-Noori: Bouc-Wen with degradation by dissipated energy and with pinching.
//!
//! ```text
//! h' = P(h) (u' - nu (beta |u'| h + gamma u' |h|)) / eta
//! nu = 1 + strength_loss e,   eta = 1 + stiffness_loss e,   e' = h u'               hysteretic energy
//! P(h) = 1 - pinch exp(-(h / (pinch_width h_u))^2),   h_u = 1 / (nu (beta + gamma)), the bound of h
//! z = w_0 u - w_1 h                                                                 w_k >= 0
//! ```
//! The integration rule is part of the definition. A path is divided into equal steps of at most 1/64 of the range, at
//! most a thousand steps per sample. Within a step P, nu and eta are those at its midpoint, predicted by a half step,
//! and h follows the exact exponentials of `bouc-wen`. Without degradation and pinching the operator is `bouc-wen`.
//!
//! Reference: T. T. Baber & M. N. Noori, J. Eng. Mech. 111 (1985), DOI 10.1061/(ASCE)0733-9399(1985)111:8(1010), with
//! pinching in the closed form of later authors. The exponent n is 1; pinching does not increase; negative energy
//! counts as 0. It does not do: asymmetric loops, rate, recovery. A degrading loop never repeats; nothing is wiped out.
//!
//! Inverse: Newton's method through all steps of a path, at a few times the cost of one step. Outside the range like
//! `bouc-wen`, except for the degradation.

use super::basis::ShapeParameter;
use super::bouc_wen::{CLIMB, bends, climb};
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: w_0 of the input, w_1 of -h.
///
/// State: h [input unit]; the energy e [input unit squared].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct BaberNoori {
    /// [1/input unit]
    beta: f64,
    gamma_over_beta: f64,
    /// [1/input unit^2]
    strength_loss: f64,
    /// [1/input unit^2]
    stiffness_loss: f64,
    pinch: f64,
    pinch_width: f64,
}

/// Steps per range, and maximum steps per sample.
const STEPS: f64 = 64.0;
const MAX_STEPS_PER_SAMPLE: f64 = 1000.0;

pub(super) static OPERATOR: Operator = Operator {
    name: "bouc-wen-baber-noori",
    aliases: &["BWBN", "baber-noori"],
    summary: "Bouc-Wen with degradation and pinching",
    reference: "Baber & Noori 1985, doi:10.1061/(ASCE)0733-9399(1985)111:8(1010)",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<BaberNoori>::load,
    basis: |design| {
        let half = design.half();
        let wear = 1e-4 / (half * half);
        Weighted::basis(design.ts, design.range, BaberNoori::of(&[1.0 / half, 0.0, wear, wear, 0.1, 0.3]))
    },
    example: |ts| Weighted::example(ts, BaberNoori::of(&[0.05, 0.25, 1e-6, 1e-6, 0.3, 0.4]), vec![1.4, 0.5]),
};

impl BaberNoori {
    fn of(shape: &[f64]) -> Self {
        BaberNoori {
            beta: shape[0],
            gamma_over_beta: shape[1],
            strength_loss: shape[2],
            stiffness_loss: shape[3],
            pinch: shape[4],
            pinch_width: shape[5],
        }
    }
}

/// H after a short path of length `s`, with P, nu and eta for h = `middle` and the energy `e`.
fn advance<R: Real>(shape: &[R], h: R, (middle, e): (R, R), s: R) -> R {
    let [beta, ratio, strength_loss, stiffness_loss, pinch, width] =
        [shape[0], shape[1], shape[2], shape[3], shape[4], shape[5]];
    let one = R::from(1.0);
    let e = if e.value() > 0.0 { e } else { 0.0.into() };
    let (nu, eta) = (one + strength_loss * e, one + stiffness_loss * e);
    let (grow, relax) = (nu * beta * (one + ratio), nu * beta * (one - ratio));
    // The divisions come first, so that they run in parallel with the rest.
    let (v, path) = (middle * (grow / width), s / eta);
    climb(h, path * (one - pinch * (-v * v).exp()), grow, relax)
}

/// [`advance`] and [`Law::step`], weighted.
const STEP: &str = "
// H after a short path of s, with pinching and wear as they are at middle with this energy.
fn advance(h, middle, energy, s) {
    let taken = 0.0;
    if energy > 0.0 { taken = energy; }
    let nu = 1.0 + strength_loss * taken;
    let eta = 1.0 + stiffness_loss * taken;
    let grow = nu * beta * grow_share;
    let relax = nu * beta * relax_share;
    let v = middle * (grow / pinch_width);
    let path = s / eta;
    return climb(h, path * (1.0 - pinch * exponential(-v * v)), grow, relax);
}

fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    if points != 0.0 {
        let length = path * points;
        // Steps of at most a share of the range, and not more of them than there may be.
        let needed = length * pieces / span;
        let steps = 1;
        if needed > real(most_steps) {
            steps = most_steps;
        } else if needed > 1.0 {
            steps = whole(needed);
            if real(steps) < needed { steps += 1; }
        }
        let s = length / real(steps);
        let brief = 0.5 * s;
        let h = points * x.h;
        for k in 0..steps at most most_steps {
            let middle = advance(h, h, x.energy, brief);
            let next = advance(h, middle, x.energy + brief * 0.5 * (h + middle), s);
            x.energy += brief * (h + next);
            h = next;
        }
        x.h = points * h;
    }
    x.last = u;
    return w[0] * u - w[1] * x.h;
}
";

impl Law for BaberNoori {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("beta", self.beta, "1 / input unit")?;
        positive("pinch_width", self.pinch_width, "fractions of the largest h")?;
        let (ratio, strength, stiffness) = (self.gamma_over_beta, self.strength_loss, self.stiffness_loss);
        let wear = |loss: f64| loss >= 0.0 && loss.is_finite();
        require(ratio > -1.0 && ratio <= 1.0, "gamma_over_beta", ratio, "must be above -1 and at most 1")?;
        require(wear(strength), "strength_loss", strength, "must be finite and not negative")?;
        require(wear(stiffness), "stiffness_loss", stiffness, "must be finite and not negative")?;
        require((0.0..1.0).contains(&self.pinch), "pinch", self.pinch, "must be at least 0 and below 1")
    }

    fn order(&self) -> usize {
        2
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let way = input.direction();
        if way != 0.0 {
            let way = R::from(way);
            let steps = (input.length().value() * STEPS / (2.0 * input.half())).ceil().clamp(1.0, MAX_STEPS_PER_SAMPLE);
            let (s, half) = (input.length() / steps.into(), R::from(0.5));
            let mut h = way * x[0];
            for _ in 0..steps as usize {
                let middle = advance(shape, h, (h, x[1]), half * s);
                let next = advance(shape, h, (middle, x[1] + half * s * half * (h + middle)), s);
                x[1] = x[1] + s * half * (h + next);
                h = next;
            }
            x[0] = way * h;
        }
        phi(0, input.u);
        phi(1, -x[0]);
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let ratio = self.gamma_over_beta;
        let block = block.number("h", 0.0).number("energy", 0.0);
        let block = block.constant("grow_share", 1.0 + ratio).constant("relax_share", 1.0 - ratio);
        let block = block.constant("span", 2.0 * input.half()).constant("pieces", STEPS);
        block.count("most_steps", MAX_STEPS_PER_SAMPLE as usize).text(CLIMB).text(STEP)
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = bends(half);
        let wear = (1e-6 / (half * half), 0.1 / (half * half));
        vec![
            ShapeParameter { name: "beta", value: self.beta, low, high },
            ShapeParameter { name: "gamma_over_beta", value: self.gamma_over_beta, low: -0.95, high: 1.0 },
            ShapeParameter { name: "strength_loss", value: self.strength_loss, low: wear.0, high: wear.1 },
            ShapeParameter { name: "stiffness_loss", value: self.stiffness_loss, low: wear.0, high: wear.1 },
            ShapeParameter { name: "pinch", value: self.pinch, low: 0.0, high: 0.95 },
            ShapeParameter { name: "pinch_width", value: self.pinch_width, low: 0.05, high: 1.0 },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    fn sine(cycles: u32) -> Vec<f64> {
        (0..200 * cycles).map(|t| 25.0 * (f64::from(t) * std::f64::consts::TAU / 200.0).sin()).collect()
    }

    fn run(shape: [f64; 6], u: &[f64]) -> Vec<f64> {
        Weighted::new(1.0, (-30.0, 30.0), BaberNoori::of(&shape), vec![1.4, 0.5]).unwrap().simulate(u)
    }

    #[test]
    fn without_degradation_and_pinching_it_is_bouc_wen() {
        let document = r#"{"operator": "bouc-wen", "range": [-30, 30], "beta": 0.1, "gamma_over_beta": 0.4, "weights": [1.4, 0.5]}"#;
        let plain = super::super::load(&serde_json::from_str(document).unwrap(), 1.0).unwrap();
        let u = sine(3);
        assert_close(&run([0.1, 0.4, 0.0, 0.0, 0.0, 0.3], &u), &plain.simulate(&u), 1e-11, 1e-11);
    }

    #[test]
    fn strength_and_stiffness_are_lost_with_every_cycle() {
        let u = sine(20);
        for (strength, stiffness) in [(1e-4, 0.0), (0.0, 1e-4)] {
            let z = run([0.1, 0.0, strength, stiffness, 0.0, 0.3], &u);
            // w_1 h at the maximum of a cycle.
            let held = |cycle: usize| 1.4 * 25.0 - z[200 * cycle + 50];
            assert!(held(19) < 0.95 * held(1), "{} {}", held(1), held(19));
        }
    }
}
