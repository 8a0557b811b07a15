//! Bouc-Wen with different rates for rising and for falling input.
//!
//! ```text
//! h' = u' - |u'| h (a if u' h > 0, b if u' h < 0)
//! a = (beta + gamma) (1 +- loading_skew),   b = (beta - gamma) (1 +- unloading_skew)     + rising, - falling
//! z = w_0 u - w_1 h                                                                      w_k >= 0
//! ```
//! The four sign combinations of u' and h have independent rates, given as two means and two skews. With skews of 0 the
//! operator is `bouc-wen`. Samples are integrated exactly as there. Wang & Wen's term delta (sign u' + sign h) is a
//! loading_skew of 2 delta / (beta + gamma).
//!
//! Reference: J. Song & A. Der Kiureghian, J. Eng. Mech. 132 (2006), DOI 10.1061/(ASCE)0733-9399(2006)132:6(610), with
//! Wang & Wen's model as a special case. The exponent n is 1; terms that depend on the sign of u are omitted. It does
//! not do: rate, wiping out; minor loops start without a jump but do not close.
//!
//! Inverse and behaviour outside the range: like `bouc-wen`.

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
/// State: h [input unit].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct AsymmetricBoucWen {
    /// [1/input unit]
    beta: f64,
    gamma_over_beta: f64,
    loading_skew: f64,
    unloading_skew: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "asymmetric-bouc-wen",
    aliases: &["ABW"],
    summary: "Bouc-Wen with different ascending and descending branches",
    reference: "Song & Der Kiureghian 2006, doi:10.1061/(ASCE)0733-9399(2006)132:6(610)",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<AsymmetricBoucWen>::load,
    basis: |design| {
        let beta = 1.0 / design.half();
        let law = AsymmetricBoucWen { beta, gamma_over_beta: 0.0, loading_skew: 0.0, unloading_skew: 0.0 };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        Weighted::example(
            ts,
            AsymmetricBoucWen { beta: 0.03, gamma_over_beta: 0.25, loading_skew: 0.3, unloading_skew: -0.2 },
            vec![1.4, 0.5],
        )
    },
};

impl Law for AsymmetricBoucWen {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("beta", self.beta, "1 / input unit")?;
        let (ratio, loading, unloading) = (self.gamma_over_beta, self.loading_skew, self.unloading_skew);
        let rule = "must be above -1 and at most 1, otherwise the hysteresis may be unbounded";
        require(ratio > -1.0 && ratio <= 1.0, "gamma_over_beta", ratio, rule)?;
        let rule = "must be between -1 and 1: at the limits a rate would be 0";
        require(loading.abs() < 1.0, "loading_skew", loading, rule)?;
        require(unloading.abs() < 1.0, "unloading_skew", unloading, rule)
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let [beta, ratio, loading, unloading] = [shape[0], shape[1], shape[2], shape[3]];
        let one = R::from(1.0);
        let way = input.direction();
        if way != 0.0 {
            let way = R::from(way);
            let grow = beta * (one + ratio) * (one + way * loading);
            let relax = beta * (one - ratio) * (one + way * unloading);
            x[0] = way * climb(way * x[0], input.length(), grow, relax);
        }
        phi(0, input.u);
        phi(1, -x[0]);
    }

    fn block(&self, block: Block, _: Input) -> Block {
        let (grow, relax) = (self.beta * (1.0 + self.gamma_over_beta), self.beta * (1.0 - self.gamma_over_beta));
        let block = block.number("h", 0.0);
        let block = block.constant("grow_rising", grow * (1.0 + self.loading_skew));
        let block = block.constant("relax_rising", relax * (1.0 + self.unloading_skew));
        let block = block.constant("grow_falling", grow * (1.0 - self.loading_skew));
        block.constant("relax_falling", relax * (1.0 - self.unloading_skew)).text(CLIMB).text(STEP)
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = bends(half);
        vec![
            ShapeParameter { name: "beta", value: self.beta, low, high },
            ShapeParameter { name: "gamma_over_beta", value: self.gamma_over_beta, low: -0.95, high: 1.0 },
            ShapeParameter { name: "loading_skew", value: self.loading_skew, low: -0.9, high: 0.9 },
            ShapeParameter { name: "unloading_skew", value: self.unloading_skew, low: -0.9, high: 0.9 },
        ]
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    if path > 0.0 { x.h = climb(x.h, path, grow_rising, relax_rising); }
    if path < 0.0 { x.h = -climb(-x.h, -path, grow_falling, relax_falling); }
    x.last = u;
    return w[0] * u - w[1] * x.h;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn each_branch_saturates_at_its_own_rate() {
        let law = AsymmetricBoucWen { beta: 2.0, gamma_over_beta: 0.5, loading_skew: 0.2, unloading_skew: 0.0 };
        let operator = Weighted::new(1.0, (-30.0, 30.0), law, vec![0.0, 1.0]).unwrap();
        assert_close(&operator.simulate(&[30.0, -30.0]), &[-1.0 / 3.6, 1.0 / 2.4], 1e-12, 0.0);
    }
}
