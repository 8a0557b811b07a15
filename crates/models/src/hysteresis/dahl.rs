//! Dahl's friction: the input minus a friction force that approaches its limit smoothly.
//!
//! ```text
//! h' = u' |1 - h sign(u') / breakaway|^exponent          |h| <= breakaway
//! z = w_0 u - w_1 h                                      w_k >= 0
//! ```
//! With y = 1 - h sign(u') / breakaway and the path length s, dy/ds = -y^exponent / breakaway. The solution integrates
//! samples exactly:
//! ```text
//! y^q = y_0^q - q s / breakaway,    q = 1 - exponent
//! ```
//! It is an exponential for q = 0; for q > 0, y stays 0 once the right side is 0. With exponent 1 the operator is
//! `bouc-wen` with gamma = 0 and beta = 1 / breakaway; with an exponent near 0 it is one stop operator.
//!
//! Reference: P. R. Dahl, "Solid friction damping of mechanical vibrations", AIAA J. 14 (1976), DOI 10.2514/3.61511. It
//! does not do: asymmetric loops, rate, wiping out; minor loops start without a jump but do not close.
//!
//! Inverse: Newton's method on the solution. At breakaway the slope of z is w_0; if w_0 < w_1, z decreases after a
//! reversal.

use super::basis::ShapeParameter;
use super::law::{Input, Law, Weighted};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: w_0 of the input, w_1 of -h.
///
/// State: h [input unit].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Dahl {
    /// [input unit]
    breakaway: f64,
    exponent: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "dahl",
    aliases: &[],
    summary: "Dahl's friction with its exponent: smooth symmetric loops",
    reference: "Dahl 1976, doi:10.2514/3.61511",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<Dahl>::load,
    basis: |design| Weighted::basis(design.ts, design.range, Dahl { breakaway: design.half(), exponent: 1.0 }),
    example: |ts| Weighted::example(ts, Dahl { breakaway: 20.0, exponent: 1.4 }, vec![1.4, 0.5]),
};

/// y after a path of length `s`, in breakaways.
fn near<R: Real>(y: R, s: R, exponent: R) -> R {
    if y.value() <= 0.0 {
        return 0.0.into();
    }
    // y = y_0 (1 - q t)^(1/q), in a form that allows q = 0.
    let q = R::from(1.0) - exponent;
    let t = s / (q * y.ln()).exp();
    if (q * t).value() >= 1.0 { 0.0.into() } else { y * (-t * (-q * t).log_growth()).exp() }
}

/// [`near`] and [`Law::step`], weighted.
const STEP: &str = "
// y after a path of s breakaways.
fn nearer(y, s) {
    let reached = 0.0;
    if y > 0.0 {
        let t = s / exponential(q * logarithm(y));
        if q * t < 1.0 { reached = y * exponential(-t * log_growth(-q * t)); }
    }
    return reached;
}

fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    if points != 0.0 {
        let y = 1.0 - points * x.h / breakaway;
        x.h = points * breakaway * (1.0 - nearer(y, path * points / breakaway));
    }
    x.last = u;
    return w[0] * u - w[1] * x.h;
}
";

impl Law for Dahl {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("breakaway", self.breakaway, "input units")?;
        positive("exponent", self.exponent, "no unit").map(|_| ())
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let [breakaway, exponent] = [shape[0], shape[1]];
        let way = input.direction();
        if way != 0.0 {
            let (way, one) = (R::from(way), R::from(1.0));
            let y = one - way * x[0] / breakaway;
            x[0] = way * breakaway * (one - near(y, input.length() / breakaway, exponent));
        }
        phi(0, input.u);
        phi(1, -x[0]);
    }

    fn block(&self, block: Block, _: Input) -> Block {
        block.number("h", 0.0).constant("q", 1.0 - self.exponent).text(STEP)
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        vec![
            ShapeParameter { name: "breakaway", value: self.breakaway, low: 0.03 * half, high: 30.0 * half },
            ShapeParameter { name: "exponent", value: self.exponent, low: 0.1, high: 4.0 },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_solution_equals_the_analytical_one_for_exponents_below_at_and_above_one() {
        for (exponent, y) in [(0.5, (1.0 - 0.3 / 2.0f64).powi(2)), (1.0, (-0.3f64).exp()), (2.0, 1.0 / 1.3)] {
            assert_close(&[near(1.0, 0.3, exponent)], &[y], 1e-14, 0.0);
            assert_close(&[near(1.0, 0.3, exponent + 1e-9)], &[y], 1e-8, 0.0);
        }
        assert_eq!(near(1.0, 2.1, 0.5), 0.0, "a small exponent reaches its limit");
    }
}
