//! Prandtl-Ishlinskii model of stop operators: the input minus a weighted sum of stops.
//!
//! ```text
//! s_k = u - p_k, p_k the play of threshold r_k          |s_k| <= r_k
//! z = w_0 u - w_1 s_1 - ... - w_n s_n                   w_k >= 0
//! ```
//! A stop follows the input until |s_k| = r_k, then slides. Since s_k = u - p_k, stops and plays span the same models.
//! They differ in the slope that must not be negative: here that of large inputs, w_0; for plays that after a reversal.
//! Passed reversals are wiped out.
//!
//! Reference: M. Brokate & J. Sprekels, "Hysteresis and Phase Transitions", Springer (1996), DOI
//! 10.1007/978-1-4612-4048-8. It does not do: asymmetric loops, rate.
//!
//! Inverse: exact, like that of `prandtl-ishlinskii`, if w_0 > w_1 + ... + w_n. Otherwise z decreases after a reversal,
//! and one of several inputs is found. When all stops slide, the slope of z is w_0; if w_0 = 0, z saturates.

use super::law::{Input, Law, Weighted};
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use serde::{Deserialize, Serialize};

/// Thresholds r_1 < r_2 < ... [input unit]. Weights: w_0 of the input, then one per threshold.
///
/// State: the plays p_k. They do not accumulate rounding errors, as stops would.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Stop {
    thresholds: Vec<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "stop",
    aliases: &[],
    summary: "Prandtl-Ishlinskii model with stop operators: the input minus a weighted sum of stop operators",
    reference: "Brokate & Sprekels 1996, doi:10.1007/978-1-4612-4048-8",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: true,
    class: Class::Plays,
    load: Weighted::<Stop>::load,
    basis: |design| Weighted::basis(design.ts, design.range, Stop { thresholds: thresholds::even(design) }),
    example: |ts| Weighted::example(ts, Stop { thresholds: thresholds::example() }, thresholds::example_weights(1.2)),
};

impl Law for Stop {
    const ROW: &'static Operator = &OPERATOR;
    const RESPONSE: &'static str = "x.play[k] - u";

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn step<R: Real>(&self, _: &[R], x: &mut [R], Input { u, .. }: Input<R>, mut phi: impl FnMut(usize, R)) {
        phi(0, u);
        for (k, (p, &r)) in x.iter_mut().zip(&self.thresholds).enumerate() {
            *p = p.clamp(u - r.into(), u + r.into());
            phi(k + 1, *p - u);
        }
    }

    fn block(&self, block: Block, _: Input) -> Block {
        let n = self.thresholds.len();
        block.numbers("play", vec![0.0; n]).table("r", &self.thresholds).count("n", n).text(STEP)
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    x.last = u;
    let z = w[0] * u;
    for k in 0..n {
        x.play[k] = clamp(x.play[k], u - r[k], u + r[k]);
        z += w[k + 1] * (x.play[k] - u);
    }
    return z;
}
";
