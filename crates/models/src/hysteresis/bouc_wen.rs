//! Bouc-Wen in the form of Low & Guo: the input minus a hysteretic variable.
//!
//! ```text
//! h' = u' - beta |u'| h - gamma u' |h|          gamma = beta gamma_over_beta
//! z = w_0 u - w_1 h                             w_k >= 0
//! ```
//! Only identifiable values are parameters: the A of the literature is part of w_1. The equation does not depend on
//! time. Along a path of one direction, with H = h sign(u') and the path length s, it is
//! ```text
//! dH/ds = 1 - (beta + gamma) H  for H > 0,      dH/ds = 1 - (beta - gamma) H  for H < 0
//! ```
//! The solutions are exponentials: samples are integrated exactly, and the division of a path into samples has no
//! effect. |h| stays below 1 / (beta + gamma). If gamma is below -beta, h grows with the length of a rise instead; it
//! is bounded for bounded inputs, because a fall takes away more. No search goes there, except for [`crate::feedback`].
//!
//! Reference: T. S. Low & W. Guo, J. MEMS 4 (1995), DOI 10.1109/84.475550; survey: M. Ismail, F. Ikhouane & J.
//! Rodellar, Arch. Comput. Methods Eng. 16 (2009), DOI 10.1007/s11831-009-9031-8. The exponent n is 1. It does not do:
//! asymmetric loops, rate, wiping out; minor loops start without a jump but do not close.
//!
//! Inverse: Newton's method on the exponentials. When h is at its bound, the slope of z is w_0; if w_0 < w_1, z
//! decreases after a reversal.

use super::basis::ShapeParameter;
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
pub(super) struct BoucWen {
    /// [1/input unit]
    beta: f64,
    gamma_over_beta: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "bouc-wen",
    aliases: &["BW"],
    summary: "a differential equation of two parameters: smooth symmetric loops",
    reference: "Low & Guo 1995, doi:10.1109/84.475550",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<BoucWen>::load,
    basis: |design| {
        let law = BoucWen { beta: 1.0 / design.half(), gamma_over_beta: 0.0 };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| Weighted::example(ts, BoucWen { beta: 0.02, gamma_over_beta: 0.25 }, vec![1.4, 0.5]),
};

/// Bounds of beta: from almost no bend of h over the range to a bend within a sixtieth of it.
pub(super) fn bends(half: f64) -> (f64, f64) {
    (0.01 / half, 30.0 / half)
}

/// H after a path of length `s`: dH/ds = 1 - `grow` H where H is positive, 1 - `relax` H where it is negative. `grow`
/// is positive. If `relax` is negative, H must not be below 1 / `relax`, where it would diverge.
pub(super) fn climb<R: Real>(h: R, s: R, grow: R, relax: R) -> R {
    let one = R::from(1.0);
    let piece = |h: R, s: R, rate: R| h + (one - rate * h) * s * (-rate * s).growth();
    if h.value() >= 0.0 {
        return piece(h, s, grow);
    }
    let end = piece(h, s, relax);
    if end.value() <= 0.0 {
        return end;
    }
    // H is 0 after a path of `zero`.
    let zero = -h * (-relax * h).log_growth();
    piece(0.0.into(), (s - zero).clamp(0.0.into(), s), grow)
}

/// [`climb`] for programs.
pub(super) const CLIMB: &str = "
// H after a path of s along which it nears 1 / rate.
fn piece(h, s, rate) {
    return h + (1.0 - rate * h) * s * growth(-rate * s);
}

// H after a path of s: dH/ds = 1 - grow H where it is positive, 1 - relax H where it is negative.
fn climb(h, s, grow, relax) {
    let reached = 0.0;
    if h >= 0.0 {
        reached = piece(h, s, grow);
    } else {
        reached = piece(h, s, relax);
        if reached > 0.0 {
            // H is 0 after a path of zero.
            let zero = -h * log_growth(-relax * h);
            reached = piece(0.0, clamp(s - zero, 0.0, s), grow);
        }
    }
    return reached;
}
";

impl Law for BoucWen {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("beta", self.beta, "1 / input unit")?;
        let ratio = self.gamma_over_beta;
        let rule =
            "must be finite and at least -10, because the hysteresis grows by exp(-(beta + gamma) s) along a rise s";
        require(ratio >= -10.0 && ratio.is_finite(), "gamma_over_beta", ratio, rule)
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let [beta, gamma] = [shape[0], shape[0] * shape[1]];
        let way = input.direction();
        if way != 0.0 {
            let way = R::from(way);
            x[0] = way * climb(way * x[0], input.length(), beta + gamma, beta - gamma);
        }
        phi(0, input.u);
        phi(1, -x[0]);
    }

    fn block(&self, block: Block, _: Input) -> Block {
        let gamma = self.beta * self.gamma_over_beta;
        let block =
            block.number("h", 0.0).constant("loading", self.beta + gamma).constant("unloading", self.beta - gamma);
        block.text(CLIMB).text(
            "
fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    if points != 0.0 {
        x.h = points * climb(points * x.h, path * points, loading, unloading);
    }
    x.last = u;
    return w[0] * u - w[1] * x.h;
}
",
        )
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = bends(half);
        vec![
            ShapeParameter { name: "beta", value: self.beta, low, high },
            ShapeParameter { name: "gamma_over_beta", value: self.gamma_over_beta, low: -0.95, high: 2.0 },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::path;
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use piezoid_twins::spec::{DriverSpec, SensorSpec};
    use piezoid_twins::{BeamSpec, Logged, Plant, Preset, Spec};

    #[test]
    fn the_division_of_a_path_into_samples_has_no_effect() {
        let run = |pieces: u32| {
            let u = path(&[0.0, 30.0, -20.0, 5.0, -30.0, 12.0], pieces);
            [-1.4, -1.0, -0.5, 0.25, 2.0].map(|ratio| {
                let law = BoucWen { beta: 0.05, gamma_over_beta: ratio };
                *Weighted::new(1.0, (-30.0, 30.0), law, vec![0.0, 1.0]).unwrap().simulate(&u).last().unwrap()
            })
        };
        assert_close(&run(1000), &run(1), 1e-11, 0.0);
    }

    #[test]
    fn an_unbounded_law_is_an_error() {
        for (beta, gamma_over_beta, start) in [(0.0, 0.5, "beta = 0"), (0.02, f64::NAN, "gamma_over_beta = NaN")] {
            let law = BoucWen { beta, gamma_over_beta };
            let message = Weighted::new(1.0, (-1.0, 1.0), law, vec![1.0, 1.0]).unwrap_err().to_string();
            assert!(message.starts_with(start), "{message}");
        }
    }

    #[test]
    fn it_equals_the_hysteresis_of_the_twin() {
        // Only the ceramic of the twin: driver, beam and sensor are ideal, and there is no creep.
        let twin = Preset::find("pl140-bouc-wen").unwrap().spec();
        let ceramic =
            Spec { driver: DriverSpec::default(), creep_per_decade: 0.0, beam: BeamSpec::Modes(vec![]), ..twin };
        let plant =
            Plant::new(&Spec { sensor: SensorSpec::default(), logged: Logged::After, ..ceramic }, 5e-4).unwrap();
        let u: Vec<f64> =
            (0..4000).map(|t| 30.0 * (f64::from(t) * 0.05).sin() * (f64::from(t) * 0.003).sin()).collect();
        let y: Vec<f64> = plant.run(&u).y;

        let law = BoucWen { beta: 0.020, gamma_over_beta: 0.25 };
        let response = |weights| Weighted::new(5e-4, (-30.0, 30.0), law.clone(), weights).unwrap().simulate(&u);
        let phi = nalgebra::DMatrix::from_columns(&[vec![1.0, 0.0], vec![0.0, 1.0]].map(|w| response(w).into()));
        let weights = phi.clone().svd(true, true).solve(&nalgebra::DVector::from(y.clone()), 0.0).unwrap();
        assert_close((&phi * &weights).as_slice(), &y, 0.0, 1e-9);
        // d and alpha d of the literature [um/V], for a loop 13 % wide.
        assert_close(weights.as_slice(), &[46.9, 0.349 * 46.9], 2e-3, 0.0);
    }
}
