//! Rate-dependent Prandtl-Ishlinskii: play operators with thresholds that increase with the input rate.
//!
//! ```text
//! r_k(t) = r_k + growth ln(1 + |u'| / rate)
//! p_k <- max(u - r_k(t), min(u + r_k(t), p_k))
//! z = w_0 u + w_1 p_1 + ... + w_n p_n                  w_k >= 0
//! ```
//! All thresholds increase by the same amount. This is the condition for a closed inverse. Far below `rate` the
//! increase is proportional to |u'|, with the factor growth / rate [s]. Far above it is logarithmic, so that a step
//! stops the plays for one sample only. u' is the difference of two samples divided by the sampling period: a staircase
//! input has peaks of u'.
//!
//! Reference: M. Al Janaideh & P. Krejci, IEEE/ASME Trans. Mechatronics 18 (2013), DOI 10.1109/TMECH.2012.2205265. It
//! does not do: asymmetric loops, saturation; reversals are wiped out only at a constant rate.
//!
//! Inverse: Newton's method; except for the logarithm z(u) is piecewise linear. If growth / rate exceeds the sampling
//! period, plays decrease when the input moves faster, and z may decrease; then bracketing finds one of several inputs.

use super::basis::ShapeParameter;
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Weights: w_0 of the input, then one per threshold.
///
/// State: the plays p_k.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct RatePlay {
    /// At rest, ascending [input unit].
    thresholds: Vec<f64>,
    /// [input unit]
    growth: f64,
    /// [input unit/s]
    rate: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "rate-dependent-prandtl-ishlinskii",
    aliases: &["RDPI"],
    summary: "play operators with thresholds that increase with the input rate",
    reference: "Al Janaideh & Krejci 2013, doi:10.1109/TMECH.2012.2205265",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: false,
    wipes_out: false,
    class: Class::Plays,
    load: Weighted::<RatePlay>::load,
    basis: |design| {
        let rate = TAU * 0.01 * design.half() / design.ts;
        let law = RatePlay { thresholds: thresholds::even(design), growth: 0.05 * design.half(), rate };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        Weighted::example(
            ts,
            RatePlay { thresholds: thresholds::example(), growth: 1.0, rate: 3000.0 },
            thresholds::example_weights(0.7),
        )
    },
};

/// Bounds of a `rate`: the largest rates of full-range sines from 1e-4 to half of the sampling frequency.
pub(super) fn speeds(half: f64, ts: f64) -> (f64, f64) {
    (TAU * half * 1e-4 / ts, TAU * half * 0.5 / ts)
}

impl Law for RatePlay {
    const ROW: &'static Operator = &OPERATOR;
    const RESPONSE: &'static str = "x.play[k]";

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)?;
        positive("rate", self.rate, "input units per second")?;
        let rule = "must be finite and not negative";
        require(self.growth >= 0.0 && self.growth.is_finite(), "growth", self.growth, rule)
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let u = input.u;
        let relative = input.rate() / shape[1];
        let more = shape[0] * relative * relative.log_growth();
        phi(0, u);
        for (k, (p, &r)) in x.iter_mut().zip(&self.thresholds).enumerate() {
            let r = more + r.into();
            *p = p.clamp(u - r, u + r);
            phi(k + 1, *p);
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let n = self.thresholds.len();
        // `growth` is the name of a function of programs.
        let block = block.constant("ts", input.ts).constant("widening", self.growth);
        block.numbers("play", vec![0.0; n]).table("r", &self.thresholds).count("n", n).text(STEP)
    }

    fn shape(&self, half: f64, ts: f64) -> Vec<ShapeParameter> {
        let (low, high) = speeds(half, ts);
        vec![
            ShapeParameter { name: "growth", value: self.growth, low: 1e-3 * half, high: half },
            ShapeParameter { name: "rate", value: self.rate, low, high },
        ]
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let relative = path * way(path) / ts / rate;
    // What all thresholds grow by at this speed.
    let more = widening * relative * log_growth(relative);
    let z = w[0] * u;
    for k in 0..n {
        let threshold = more + r[k];
        x.play[k] = clamp(x.play[k], u - threshold, u + threshold);
        z += w[k + 1] * x.play[k];
    }
    x.last = u;
    return z;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;

    #[test]
    fn faster_loops_are_wider() {
        let law = || RatePlay { thresholds: vec![3.0], growth: 2.0, rate: 1000.0 };
        let width = |hz: f64| {
            let operator = Weighted::new(5e-4, (-30.0, 30.0), law(), vec![0.0, 1.0]).unwrap();
            let n = (1.0 / (hz * 5e-4)) as usize;
            let z =
                operator.simulate(&(0..2 * n).map(|t| 30.0 * (TAU * t as f64 / n as f64).sin()).collect::<Vec<_>>());
            // At the zero crossing of a sine its play lags by the threshold.
            z[n + n / 2] - z[n]
        };
        let expected = |hz: f64| 2.0 * (3.0 + 2.0 * (1.0 + TAU * hz * 30.0 / 1000.0).ln());
        for hz in [2.0, 20.0] {
            piezoid_testing::assert_close(&[width(hz)], &[expected(hz)], 5e-3, 0.0);
        }
    }
}
