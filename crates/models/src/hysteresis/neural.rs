//! A neural network whose memory is a ladder of plays: one hidden layer of smooth units, one unit of each kind per
//! play.
//!
//! ```text
//! p_0 = u,    p_k <- max(u - r_k, min(u + r_k, p_k))
//! z = sum_k w_k p_k + sum_k sum_j c_kj half (unit(a_kj) - unit(a_kj at rest))         w_k >= 0
//! a_kj = slope_j v(p_k) + input_j v(u) + bias_j,    v(p) = (p - middle) / half,    unit(a) = 1 / (1 + e^-a)
//! ```
//! `middle` and `half` describe the input range; at rest u and all p_k are 0. The units of kind j have the same input
//! weights for all plays, as in a convolution over the thresholds; their output weights are their own. With output
//! weights of 0 it is `prandtl-ishlinskii`. With `input` = 0 each play has its own curve, a sum of these units: a
//! Preisach operator. Units that also see the input make minor loops that are not congruent.
//!
//! The output weights follow from the linear problem of least squares, the input weights from Gauss-Newton on the error
//! of the free run, both together with the linear block. The units start in even steps over the range: no random
//! numbers.
//!
//! References: plays as the memory of a network, and functions of plays as Preisach's operator: M. Brokate & J.
//! Sprekels, "Hysteresis and Phase Transitions", Springer (1996), DOI 10.1007/978-1-4612-4048-8; universal
//! approximation by one hidden layer: G. Cybenko, Math. Control Signals Syst. 2, 303 (1989), DOI 10.1007/BF02551274. It
//! does not do: rate; units that see several plays.
//!
//! Inverse: Newton's method on the step. Output weights of units may have either sign; where z decreases, one of
//! several inputs is found. Far outside the range all units are constant, and z is that of the plays alone.

use super::basis::{BasisDesign, ShapeParameter, counted, counted_within, curvature};
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, finite};
use serde::{Deserialize, Serialize};

/// Weights: w_0, w_1, ... of input and plays, then c_0j, c_1j, ... of each kind of unit.
///
/// State: the plays p_k.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Neural {
    /// r_1 < r_2 < ... [input unit]
    thresholds: Vec<f64>,
    /// The input weights of each kind of unit.
    slopes: Vec<f64>,
    inputs: Vec<f64>,
    biases: Vec<f64>,
}

/// Number of kinds of units, and its maximum.
const KINDS: usize = 3;
const MAX_KINDS: usize = 4;

/// Bounds of the input weights.
const SLOPE: (f64, f64) = (0.2, 20.0);
const OTHERS: (f64, f64) = (-20.0, 20.0);

/// Beyond this argument a unit is constant.
const CONSTANT: f64 = 40.0;

static SLOPES: [&str; MAX_KINDS] = ["slope_1", "slope_2", "slope_3", "slope_4"];
static INPUTS: [&str; MAX_KINDS] = ["input_1", "input_2", "input_3", "input_4"];
static BIASES: [&str; MAX_KINDS] = ["bias_1", "bias_2", "bias_3", "bias_4"];

pub(super) static OPERATOR: Operator = Operator {
    name: "neural",
    aliases: &["neural-network"],
    summary: "a network of one hidden layer whose memory is a ladder of plays: corrects Prandtl-Ishlinskii by what the \
              records show",
    reference: "Brokate & Sprekels 1996, doi:10.1007/978-1-4612-4048-8; Cybenko 1989, doi:10.1007/BF02551274",
    minor_loops: true,
    needs_minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    class: Class::Learned,
    load: Weighted::<Neural>::load,
    basis: |design| Weighted::basis(design.ts, design.range, Neural::even(design)),
    example: |ts| {
        // The input weights of the start: from others a fit ends at some millionths of the displacement.
        let design = BasisDesign { ts, range: (-30.0, 30.0), elements: None, frequencies: Vec::new() };
        let law = Neural { thresholds: thresholds::example(), ..Neural::even(&design) };
        let units = (0..27).map(|k| 0.02 * (1.0 + 0.5 * f64::from(k % 3)) * if k < 9 { -1.0 } else { 1.0 });
        let weights = thresholds::example_weights(0.7).into_iter().chain(units).collect();
        Weighted::example(ts, law, weights)
    },
};

impl Neural {
    /// Equidistant thresholds, and units in even steps over the range.
    fn even(design: &BasisDesign) -> Self {
        let step = 4.0 / (KINDS - 1) as f64;
        let biases = (0..KINDS).map(|j| 2.0 - step * j as f64).collect();
        let (slopes, inputs) = (vec![3.0; KINDS], vec![0.0; KINDS]);
        Neural { thresholds: thresholds::even(design), slopes, inputs, biases }
    }

    fn kinds(&self) -> usize {
        self.slopes.len()
    }

    /// Number of the p_k.
    fn plays(&self) -> usize {
        1 + self.thresholds.len()
    }
}

impl Law for Neural {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)?;
        counted_within("slopes", self.kinds(), 1, MAX_KINDS)?;
        let all = [
            ("slopes", SLOPES, &self.slopes, SLOPE),
            ("inputs", INPUTS, &self.inputs, OTHERS),
            ("biases", BIASES, &self.biases, OTHERS),
        ];
        for (field, names, values, (low, high)) in all {
            finite(field, values)?;
            counted(OPERATOR.name, field, values.len(), self.kinds())?;
            for (name, value) in names.iter().zip(values) {
                require((low..=high).contains(value), name, *value, &format!("must be from {low} to {high}"))?;
            }
        }
        Ok(())
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn responses(&self) -> usize {
        self.plays() * (1 + self.kinds())
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let (half, n) = (R::from(input.half()), self.plays());
        let v = |p: R| (p - input.middle().into()) / half;
        let (slopes, others) = shape.split_at(self.kinds());
        let (inputs, biases) = others.split_at(self.kinds());
        phi(0, input.u);
        for (k, (p, &r)) in x.iter_mut().zip(&self.thresholds).enumerate() {
            *p = p.clamp(input.u - r.into(), input.u + r.into());
            phi(k + 1, *p);
        }
        let (now, rest) = (v(input.u), v(0.0.into()));
        for (j, ((&slope, &by_input), &bias)) in slopes.iter().zip(inputs).zip(biases).enumerate() {
            // What all plays share.
            let shared = by_input * now + bias;
            let resting = unit(slope * rest + (by_input * rest + bias));
            let of = |p: R| half * (unit(slope * v(p) + shared) - resting);
            phi(n * (j + 1), of(input.u));
            for (k, &p) in x.iter().enumerate() {
                phi(n * (j + 1) + k + 1, of(p));
            }
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let n = self.plays();
        let block = block.numbers("play", vec![0.0; n - 1]).table("r", &self.thresholds).count("n", n);
        let block = block.constant("half", input.half()).constant("middle", input.middle());
        block.text(UNIT).text(&self.text())
    }

    /// Output weights of units may have either sign.
    fn non_negative(&self, k: usize) -> bool {
        k < self.plays()
    }

    /// Second differences over the thresholds, of the weights of the plays and of each kind of unit.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        let n = self.plays();
        (0..=self.kinds()).flat_map(|j| curvature(n * j + 1, n * (j + 1))).collect()
    }

    fn shape(&self, _: f64, _: f64) -> Vec<ShapeParameter> {
        let of = |names: [&'static str; MAX_KINDS], values: &[f64], (low, high): (f64, f64)| -> Vec<ShapeParameter> {
            names.into_iter().zip(values).map(|(name, &value)| ShapeParameter { name, value, low, high }).collect()
        };
        [of(SLOPES, &self.slopes, SLOPE), of(INPUTS, &self.inputs, OTHERS), of(BIASES, &self.biases, OTHERS)].concat()
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Self, Error> {
        let (slopes, others) = shape.split_at(self.kinds());
        let (inputs, biases) = others.split_at(self.kinds());
        let law = Neural {
            slopes: slopes.to_vec(),
            inputs: inputs.to_vec(),
            biases: biases.to_vec(),
            thresholds: self.thresholds.clone(),
        };
        law.check()?;
        Ok(law)
    }
}

/// 1 / (1 + e^-a).
fn unit<R: Real>(a: R) -> R {
    let a = a.clamp((-CONSTANT).into(), CONSTANT.into());
    R::from(1.0) / (R::from(1.0) + (-a).exp())
}

/// [`unit`] for programs.
const UNIT: &str = "
// A unit of the hidden layer, from 0 to 1.
fn unit(a) {
    return 1.0 / (1.0 + exponential(-clamp(a, -40.0, 40.0)));
}
";

impl Neural {
    /// [`Law::step`], weighted, with each kind of unit written out.
    fn text(&self) -> String {
        let kind = |j: usize| {
            let name = j + 1;
            let first = if j == 0 { "n".into() } else { format!("{name} * n") };
            format!(
                "    // The units of kind {name}.
    let shared_{name} = input_{name} * now + bias_{name};
    let resting_{name} = unit(slope_{name} * rest + (input_{name} * rest + bias_{name}));
    z += w[{first}] * (half * (unit(slope_{name} * now + shared_{name}) - resting_{name}));
    for k in 1..n {{
        let a_{name} = slope_{name} * ((x.play[k - 1] - middle) / half) + shared_{name};
        z += w[{first} + k] * (half * (unit(a_{name}) - resting_{name}));
    }}
"
            )
        };
        let kinds: String = (0..self.kinds()).map(kind).collect();
        format!(
            "
fn hysteresis(x: hysteresis, u) {{
    let z = w[0] * u;
    for k in 1..n {{
        x.play[k - 1] = clamp(x.play[k - 1], u - r[k - 1], u + r[k - 1]);
        z += w[k] * x.play[k - 1];
    }}
    let now = (u - middle) / half;
    let rest = (0.0 - middle) / half;
{kinds}    x.last = u;
    return z;
}}
"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use serde_json::json;

    fn wander(n: u32) -> Vec<f64> {
        (0..n).map(|t| 28.0 * (f64::from(t) * 0.1).sin() * (f64::from(t) * 0.013).cos()).collect()
    }

    #[test]
    fn without_output_weights_of_units_it_is_prandtl_ishlinskii() {
        let mut document = super::super::save(&*(OPERATOR.example)(5e-4).unwrap());
        let plays = json!({"operator": "prandtl-ishlinskii", "range": document["range"],
                           "thresholds": document["thresholds"], "weights": thresholds::example_weights(0.7)});
        document["weights"].as_array_mut().unwrap()[9..].iter_mut().for_each(|c| *c = json!(0.0));
        let [network, plays] = [document, plays].map(|document| super::super::load(&document, 5e-4).unwrap());
        assert_close(&network.simulate(&wander(400)), &plays.simulate(&wander(400)), 1e-14, 1e-13);
    }

    #[test]
    fn a_unit_is_the_logistic_function_of_its_play() {
        let law = Neural { thresholds: vec![4.0], slopes: vec![3.0], inputs: vec![-0.5], biases: vec![0.7] };
        let network = Weighted::new(1.0, (-10.0, 30.0), law, vec![0.0, 0.0, 0.3, -1.2]).unwrap();
        let (mut p, v) = (0.0f64, |p: f64| (p - 10.0) / 20.0);
        let logistic = |a: f64| 0.5 + 0.5 * (0.5 * a).tanh();
        let known: Vec<f64> = wander(300)
            .into_iter()
            .map(|u| {
                p = p.min(u + 4.0).max(u - 4.0);
                let of = |p: f64| logistic(3.0 * v(p) - 0.5 * v(u) + 0.7) - logistic(2.5 * v(0.0) + 0.7);
                20.0 * (0.3 * of(u) - 1.2 * of(p))
            })
            .collect();
        assert_close(&network.simulate(&wander(300)), &known, 1e-12, 1e-12);
    }

    #[test]
    fn far_outside_the_range_only_the_plays_move() {
        let network = (OPERATOR.example)(5e-4).unwrap();
        let z = network.simulate(&[1e6, 1.1e6]);
        let slope: f64 = thresholds::example_weights(0.7).iter().sum();
        assert_close(&[z[1] - z[0]], &[1e5 * slope], 1e-9, 0.0);
    }
}
