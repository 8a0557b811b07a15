//! Prandtl-Ishlinskii of stop operators: the input, less what the stops hold back.
//!
//! ```text
//! s_k = u - p_k, p_k the play of threshold r_k          |s_k| <= r_k
//! z = w_0 u - w_1 s_1 - ... - w_n s_n                   w_k >= 0
//! ```
//! A stop follows the input until it is r_k away from the last reversal's side, then slides. Since s_k = u - p_k the sum
//! spans what plays span; it differs in what must not be negative: here the slope of large inputs, w_0, there the slope
//! at a reversal. Reversals that are passed are wiped out.
//!
//! Reference: M. Brokate & J. Sprekels, "Hysteresis and Phase Transitions", Springer (1996), DOI
//! 10.1007/978-1-4612-4048-8. It does not do: asymmetric loops, rate.
//!
//! Inverse: exact, as of `prandtl-ishlinskii`, while w_0 > w_1 + ... + w_n; else z falls after a reversal, and one of several
//! inputs is found. Where all stops slide z goes on with slope w_0; without it, it saturates.

use super::Operator;
use super::basis::curvature;
use super::law::{Input, Law, Weighted};
use super::real::Real;
use super::thresholds::{self, ELEMENTS};
use crate::error::Error;
use crate::program::Block;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Thresholds r_1 < r_2 < ... [input unit]; the weights are w_0 of the input itself, then one each.
///
/// State: the plays p_k, which unlike sums of steps of the stops gather no rounding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Stop {
    thresholds: Vec<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "stop",
    summary: "Prandtl-Ishlinskii of stop operators: the input less what elastic sliders hold back",
    reference: "Brokate & Sprekels 1996, doi:10.1007/978-1-4612-4048-8",
    minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    load: Weighted::<Stop>::load,
    basis: |design| {
        let law = Stop { thresholds: thresholds::even(design, ELEMENTS) };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        let law = Stop { thresholds: (1..=8).map(|k| 3.0 * f64::from(k)).collect() };
        let weights = (0..=8).map(|k| if k == 0 { 1.2 } else { 0.06 }).collect();
        Ok(Arc::new(Weighted::new(ts, (-30.0, 30.0), law, weights)?))
    },
};

impl Law for Stop {
    fn row() -> &'static Operator {
        &OPERATOR
    }

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)
    }

    fn responses(&self) -> usize {
        1 + self.thresholds.len()
    }

    fn order(&self) -> usize {
        self.thresholds.len()
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

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        curvature(1, self.responses())
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
