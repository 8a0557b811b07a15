//! Generalised Maxwell slip: the input minus the forces of elastic sliders with dynamics.
//!
//! ```text
//! b_k(u') = r_k (1 + rise (1 - exp(-|u'| / rate)))                  breakaway of threshold r_k
//! sticking:  e_k' = u'                                              until e_k sign u' reaches b_k, then it slides
//! sliding:   e_k' = (b_k sign u' - e_k) / attraction                until u stops or reverses, then it sticks
//! z = w_0 u - w_1 e_1 - ... - w_n e_n                               w_k >= 0
//! ```
//! u' is the movement of a sample over the sampling period [input unit/s]. Within a sample it is constant, so both
//! solutions are exact. A negative `rise` reduces the breakaway at high rates, like the Stribeck effect; a positive
//! `rise` increases it and makes fast loops wider. `attraction` [s] is the time constant with which a sliding element
//! follows its breakaway (C in the paper). With rise = 0 the operator is `stop`.
//!
//! References: M. Goldfarb & N. Celanovic, IEEE Control Systems 17 (1997), DOI 10.1109/37.588158 (sliders for piezo
//! actuators); F. Al-Bender, V. Lampaert & J. Swevers, IEEE Trans. Autom. Control 50 (2005), DOI
//! 10.1109/TAC.2005.858676 (sliding). It does not do: asymmetric loops; at changing rates reversals are not wiped out.
//!
//! Inverse: Newton's method on the law. When all sliders slide, the slope of z is w_0. If w_0 < w_1 + ... + w_n, z
//! decreases after a reversal.

use super::basis::ShapeParameter;
use super::law::{Input, Law, Weighted, require};
use super::rate_play::speeds;
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: w_0 of the input, then one per slider.
///
/// State: the e_k, then the sliding direction of each slider (1 rising, -1 falling, 0 sticking).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct MaxwellSlip {
    /// r_1 < r_2 < ... [input unit]
    thresholds: Vec<f64>,
    /// Increase of the breakaway at high rates, relative to its threshold.
    rise: f64,
    /// [input unit/s]
    rate: f64,
    /// [s]
    attraction: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "maxwell-slip",
    aliases: &["GMS"],
    summary: "elastic sliders whose breakaway force depends on speed: loops that change with frequency",
    reference: "Al-Bender, Lampaert & Swevers 2005, doi:10.1109/TAC.2005.858676",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: false,
    wipes_out: false,
    class: Class::Plays,
    load: Weighted::<MaxwellSlip>::load,
    basis: |design| {
        let (low, high) = speeds(design.half(), design.ts);
        let thresholds = thresholds::even(design);
        let law = MaxwellSlip { thresholds, rise: 0.1, rate: (low * high).sqrt(), attraction: 10.0 * design.ts };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        Weighted::example(
            ts,
            MaxwellSlip { thresholds: thresholds::example(), rise: 0.3, rate: 2000.0, attraction: 5e-3 },
            thresholds::example_weights(1.2),
        )
    },
};

impl Law for MaxwellSlip {
    const ROW: &'static Operator = &OPERATOR;
    const RESPONSE: &'static str = "-x.slider[k]";

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)?;
        positive("rate", self.rate, "input units per second")?;
        positive("attraction", self.attraction, "seconds")?;
        let rule = "must be finite and above -1: at -1 the breakaway would be 0";
        require(self.rise > -1.0 && self.rise.is_finite(), "rise", self.rise, rule)
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn order(&self) -> usize {
        2 * self.thresholds.len()
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let [rise, rate, attraction] = [shape[0], shape[1], shape[2]];
        let way = input.direction();
        let gain = R::from(1.0) + rise * (R::from(1.0) - (-input.rate() / rate).exp());
        let left = (-R::from(input.ts) / attraction).exp();
        let (sliders, sliding) = x.split_at_mut(self.thresholds.len());
        if way == 0.0 {
            sliding.fill(0.0.into());
        } else {
            for ((slider, sliding), &r) in sliders.iter_mut().zip(sliding).zip(&self.thresholds) {
                // In the direction of the movement.
                let (e, breakaway) = (*slider * way.into(), gain * r.into());
                let (pulled, beyond) = (e + input.length(), e - breakaway);
                let slides = sliding.value() == way;
                // A slider that breaks away within the sample ends at its breakaway.
                let released = if slides | (beyond.value() > 0.0) { beyond * left } else { 0.0.into() };
                let sticks = !slides & (pulled < breakaway);
                *slider = if sticks { pulled } else { breakaway + released } * way.into();
                *sliding = if sticks { 0.0 } else { way }.into();
            }
        }
        phi(0, input.u);
        sliders.iter().enumerate().for_each(|(k, e)| phi(k + 1, -*e));
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let n = self.thresholds.len();
        let left = Real::exp(-input.ts / self.attraction);
        let block = block.numbers("slider", vec![0.0; n]).numbers("sliding", vec![0.0; n]);
        let block = block.table("r", &self.thresholds).count("n", n).constant("ts", input.ts);
        block.constant("left_over", left).text(STEP)
    }

    fn shape(&self, half: f64, ts: f64) -> Vec<ShapeParameter> {
        let (low, high) = speeds(half, ts);
        vec![
            ShapeParameter { name: "rise", value: self.rise, low: -0.9, high: 2.0 },
            ShapeParameter { name: "rate", value: self.rate, low, high },
            ShapeParameter { name: "attraction", value: self.attraction, low: 0.3 * ts, high: 1e4 * ts },
        ]
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    let length = path * points;
    let gain = 1.0;
    if points != 0.0 { gain = 1.0 + rise * (1.0 - exponential(-length / ts / rate)); }
    let z = w[0] * u;
    for k in 0..n {
        if points == 0.0 {
            x.sliding[k] = 0.0;
        } else {
            // Seen in the direction of the movement, everything rises.
            let force = x.slider[k] * points;
            let breakaway = gain * r[k];
            if x.sliding[k] != points && force + length < breakaway {
                x.slider[k] = (force + length) * points;
                x.sliding[k] = 0.0;
            } else {
                // A slider that breaks away within this sample stays at its breakaway force.
                let released = 0.0;
                if x.sliding[k] == points || force > breakaway { released = (force - breakaway) * left_over; }
                x.slider[k] = (breakaway + released) * points;
                x.sliding[k] = points;
            }
        }
        z -= w[k + 1] * x.slider[k];
    }
    x.last = u;
    return z;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    fn operator(rise: f64, attraction: f64) -> impl System {
        let law = MaxwellSlip { thresholds: vec![2.0], rise, rate: 1000.0, attraction };
        Weighted::new(1e-3, (-10.0, 10.0), law, vec![0.0, 1.0]).unwrap()
    }

    #[test]
    fn a_sliding_element_follows_its_breakaway_with_the_time_constant_attraction() {
        // Slowly to 4 V, sliding from 2 V; then 1 V per sample, where the breakaway is higher.
        let slow = (1..=4000).map(|t| 1e-3 * f64::from(t));
        let fast = (1..=5).map(|t| 4.0 + f64::from(t));
        let z = operator(0.5, 3e-3).simulate(&slow.chain(fast).collect::<Vec<_>>());
        let high = 2.0 * (1.0 + 0.5 * (1.0 - (-1.0f64).exp()));
        let low = 2.0 * (1.0 + 0.5 * (1.0 - (-1e-3f64).exp()));
        let expected: Vec<f64> = (1..=5).map(|t| -(high + (low - high) * (-f64::from(t) / 3.0).exp())).collect();
        assert_close(&z[4000..], &expected, 1e-9, 0.0);
    }

    #[test]
    fn a_breakaway_that_decreases_with_rate_gives_a_larger_z() {
        let held = |rise| operator(rise, 1e-4).simulate(&[3.0, 6.0, 9.0])[2];
        assert!(held(-0.5) > held(0.0) && held(0.0) > held(0.5));
        assert_eq!(held(0.0), -2.0);
    }
}
