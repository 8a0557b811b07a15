//! Polynomial NARX with the direction of the input among its regressors, rate-independent.
//!
//! ```text
//! z_t = z_(t-1) + sum over terms of theta z_(t-1)^a v^j du        a = 0, 1;  du also as |du| = way du
//! ```
//! v is the input over S, the largest |u| of the range, within -1..1, and du its movement. Terms without z and |du| sum
//! up to a polynomial of u. With h the rest of z, the terms in z are one rate of decay, and z is linear in all others:
//! ```text
//! z = sum_i f_i S v^i - sum_j k_j h_j + sum_j g_j d_j      f_1 multiplies u itself, also outside the range
//! h_j' = -b |u'| h_j + u' v^j,      d_j' = -b |u'| d_j + |u'| v^j
//! b = rate (1 + r_1 v + r_2 v^2 + way (q_0 + q_1 v + q_2 v^2)), at least a twentieth of the rate
//! ```
//! A sample is one exponential step, with v in h_j, d_j and b the mean of v at the ends of its path:
//! ```text
//! h_j <- e^(-x) h_j + (1 - e^(-x)) / b way v^j,    d_j <- e^(-x) d_j + (1 - e^(-x)) / b v^j,    x = b |du|
//! ```
//! Both are means of the old value and +-v^j / b. Therefore |h_j| and |d_j| never exceed 20 / rate: a free run cannot
//! diverge. The division of a path into samples has an effect of second order in their length. Held inputs change
//! nothing.
//!
//! The terms f, k and g are selected from the records, forwards, by their error reduction ratios. Duhem's equation in
//! Coleman & Hodgdon's form is the case of a constant b and no g.
//!
//! References: I. J. Leontaritis & S. A. Billings, Int. J. Control 41, 303 (1985), DOI 10.1080/0020718508961129 (NARX);
//! S. Chen, S. A. Billings & W. Luo, Int. J. Control 50, 1873 (1989), DOI 10.1080/00207178908953472 (selection); S. A.
//! M. Martins & L. A. Aguirre, Mech. Syst. Signal Process. 75, 607 (2016) (the sign of du for hysteresis). It does not
//! do: powers of z above the first, rate, wiping out; minor loops start without a jump but do not close.
//!
//! Inverse: Newton's method on the step. Where a polynomial has an extremum z decreases, and one of several inputs is
//! found.

use super::basis::ShapeParameter;
use super::bouc_wen::bends;
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: f, then k, then g, each in the order of its powers.
///
/// State: h, then d [input unit].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Narx {
    /// Powers i of f, ascending.
    reversible: Vec<usize>,
    /// Powers j of k.
    moved: Vec<usize>,
    /// Powers j of g.
    travelled: Vec<usize>,
    /// [1/input unit]
    rate: f64,
    /// r_1, r_2.
    rate_slope: f64,
    rate_bend: f64,
    /// q_0, q_1, q_2.
    rise: f64,
    rise_slope: f64,
    rise_bend: f64,
}

/// Decay after which nothing is left, and the largest rate: no product of both overflows.
const FORGOTTEN: f64 = 800.0;
const MAX_RATE: f64 = 1e100;

/// Default and maximum of the powers.
const DEGREE: usize = 5;
const MAX_DEGREE: usize = 9;

/// Bounds of the factor of the rate.
const FACTOR: (f64, f64) = (0.05, 20.0);

/// Largest absolute value of a coefficient of the factor.
const MOST: f64 = 3.0;

pub(super) static OPERATOR: Operator = Operator {
    name: "narx",
    aliases: &["NARMAX"],
    summary: "polynomial NARX whose terms have the direction of the input, selected from the records: smooth \
              asymmetric loops",
    reference: "Leontaritis & Billings 1985, doi:10.1080/0020718508961129; Martins & Aguirre 2016, Mech. Syst. Signal \
                Process. 75",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Learned,
    load: Weighted::<Narx>::load,
    basis: |design| {
        let degree = design.elements.unwrap_or(DEGREE).clamp(1, MAX_DEGREE);
        Weighted::basis(design.ts, design.range, Narx::all(degree, 1.0 / design.half()))
    },
    example: |ts| {
        let law = Narx { rate_slope: 0.3, rise: 0.1, ..Narx::all(3, 0.05) };
        let law = Narx { reversible: vec![1, 2, 3], moved: vec![0, 1, 2], travelled: vec![1], ..law };
        Weighted::example(ts, law, vec![1.2, 0.05, -0.05, 0.4, 0.05, -0.1, 0.05])
    },
};

impl Narx {
    /// All terms up to a degree, with one rate.
    fn all(degree: usize, rate: f64) -> Self {
        Narx {
            reversible: (1..=degree).collect(),
            moved: (0..degree).collect(),
            travelled: (1..degree).collect(),
            rate,
            rate_slope: 0.0,
            rate_bend: 0.0,
            rise: 0.0,
            rise_slope: 0.0,
            rise_bend: 0.0,
        }
    }

    fn coefficients(&self) -> [(&'static str, f64); 5] {
        [
            ("rate_slope", self.rate_slope),
            ("rate_bend", self.rate_bend),
            ("rise", self.rise),
            ("rise_slope", self.rise_slope),
            ("rise_bend", self.rise_bend),
        ]
    }
}

impl Law for Narx {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("rate", self.rate, "1 / input unit")?;
        require(self.rate <= MAX_RATE, "rate", self.rate, &format!("must be at most {MAX_RATE:e}"))?;
        for (name, value) in self.coefficients() {
            require((-MOST..=MOST).contains(&value), name, value, &format!("must be from {} to {MOST}", -MOST))?;
        }
        let powers =
            [("reversible", &self.reversible, 1), ("moved", &self.moved, 0), ("travelled", &self.travelled, 0)];
        for (name, powers, least) in powers {
            let is_ascending = powers.windows(2).all(|w| w[0] < w[1]);
            let is_within = powers.iter().all(|power| (least..=MAX_DEGREE).contains(power));
            if !(is_ascending && is_within) {
                let rule = format!("must be ascending powers from {least} to {MAX_DEGREE}");
                return Err(Error::parameter(name, format!("{powers:?}"), rule));
            }
        }
        match self.responses() {
            0 => Err(Error::parameter("reversible", "[]", "must have a power: the operator has no term")),
            _ => Ok(()),
        }
    }

    fn responses(&self) -> usize {
        self.reversible.len() + Law::order(self)
    }

    fn order(&self) -> usize {
        self.moved.len() + self.travelled.len()
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let scale = input.largest();
        let (one, size) = (R::from(1.0), R::from(scale));
        let (v, before) = ((input.u / size).clamp(-one, one), (input.before / size).clamp(-one, one));
        let way = input.direction();
        if way != 0.0 {
            // The middle of the path.
            let m = R::from(0.5) * (before + v);
            let alike = shape[1] * m + shape[2] * m * m;
            let by_way = shape[3] + shape[4] * m + shape[5] * m * m;
            let factor = (one + alike + R::from(way) * by_way).clamp(FACTOR.0.into(), FACTOR.1.into());
            // Farther back than `most` nothing is left; so no input is too large.
            let (rate, most) = (shape[0] * factor, R::from(FORGOTTEN));
            let length = if rate * input.length() > most { most / rate } else { input.length() };
            let decay = rate * length;
            let share = (-decay).growth();
            let kept = one - decay * share;
            let (path, length) = (share * R::from(way) * length, share * length);
            let powers = powers(m);
            let (moved, travelled) = x.split_at_mut(self.moved.len());
            for (h, &j) in moved.iter_mut().zip(&self.moved) {
                *h = kept * *h + path * powers[j];
            }
            for (d, &j) in travelled.iter_mut().zip(&self.travelled) {
                *d = kept * *d + length * powers[j];
            }
        }
        let powers = powers(v);
        for (k, &i) in self.reversible.iter().enumerate() {
            phi(k, if i == 1 { input.u } else { size * powers[i] });
        }
        let (n, moved) = (self.reversible.len(), self.moved.len());
        for (j, &h) in x.iter().enumerate() {
            phi(n + j, if j < moved { -h } else { h });
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let block = block.numbers("part", vec![0.0; Law::order(self)]).constant("scale", input.largest());
        block.text(&self.text())
    }

    /// The slope at rest and the first coefficient of k are not negative.
    fn non_negative(&self, k: usize) -> bool {
        let first = self.reversible.len();
        (k == 0 && self.reversible.first() == Some(&1)) || (k == first && self.moved.first() == Some(&0))
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = bends(half);
        let rate = ShapeParameter { name: "rate", value: self.rate, low, high };
        let others = self.coefficients().map(|(name, value)| ShapeParameter { name, value, low: -MOST, high: MOST });
        [&[rate][..], &others].concat()
    }

    fn with_terms(&self, terms: &[usize]) -> Option<Self> {
        let of = |powers: &[usize], from: usize| -> Vec<usize> {
            powers.iter().enumerate().filter(|(k, _)| terms.contains(&(from + k))).map(|(_, power)| *power).collect()
        };
        let (first, second) = (self.reversible.len(), self.reversible.len() + self.moved.len());
        let (reversible, moved) = (of(&self.reversible, 0), of(&self.moved, first));
        Some(Narx { reversible, moved, travelled: of(&self.travelled, second), ..self.clone() })
    }
}

/// 1, v, v^2, ...
fn powers<R: Real>(v: R) -> [R; MAX_DEGREE + 1] {
    let mut powers = [R::from(1.0); MAX_DEGREE + 1];
    for i in 1..=MAX_DEGREE {
        powers[i] = powers[i - 1] * v;
    }
    powers
}

impl Narx {
    /// [`Law::step`], weighted, with each term written out.
    fn text(&self) -> String {
        // Only powers and paths that a term has: unused variables are warnings in C.
        let powers = |of: &str, highest: usize| -> String {
            let next = |i: usize| format!("let {of}_{i} = {of}_{} * {of}; ", i - 1);
            format!("let {of}_0 = 1.0; {}", (1..=highest).map(next).collect::<String>())
        };
        let (n, moved) = (self.reversible.len(), self.moved.len());
        let term = |(k, path, j): (usize, &str, usize)| {
            format!("        x.part[{k}] = kept * x.part[{k}] + {path} * m_{j};\n")
        };
        let of_moved = self.moved.iter().enumerate().map(|(k, &j)| (k, "path", j));
        let of_travelled = self.travelled.iter().enumerate().map(|(k, &j)| (moved + k, "length", j));
        let decays: String = of_moved.chain(of_travelled).map(term).collect();
        let of_power = |(k, &i): (usize, &usize)| {
            format!("w[{k}] * {}", if i == 1 { "u".into() } else { format!("(scale * v_{i})") })
        };
        let of_part = |k: usize| format!("w[{}] * {}x.part[{k}]", n + k, if k < moved { "-" } else { "" });
        let all = self.reversible.iter().enumerate().map(of_power).chain((0..Law::order(self)).map(of_part));
        let sum: String = all
            .enumerate()
            .map(|(k, term)| match k {
                0 => format!("    let z = {term};\n"),
                _ => format!("    z += {term};\n"),
            })
            .collect();
        let bends = self.reversible.iter().copied().max().filter(|i| *i > 1);
        let bent = bends.map_or(String::new(), |highest| {
            format!("    let v = clamp(u / scale, -1.0, 1.0);\n    {}\n", powers("v", highest))
        });
        let decay = self.moved.iter().chain(&self.travelled).max().map_or(String::new(), |&highest| {
            DECAY
                .replace("PATH", if self.moved.is_empty() { "" } else { "let path = share * (points * distance);" })
                .replace("LENGTH", if self.travelled.is_empty() { "" } else { "let length = share * distance;" })
                .replace("POWERS", &powers("m", highest))
                .replace("LOWEST", &format!("{:?}", FACTOR.0))
                .replace("HIGHEST", &format!("{:?}", FACTOR.1))
                .replace("FORGOTTEN", &format!("{FORGOTTEN:?}"))
                .replace("DECAYS", &decays)
        });
        format!("\nfn hysteresis(x: hysteresis, u) {{\n{decay}{bent}{sum}    x.last = u;\n    return z;\n}}\n")
    }
}

/// What decays along the path, in a [`Law::step`] that has such parts.
const DECAY: &str = "    let before = clamp(x.last / scale, -1.0, 1.0);
    let after = clamp(u / scale, -1.0, 1.0);
    let moved = u - x.last;
    let points = way(moved);
    if points != 0.0 {
        // In the middle of the path: the rate of decay, and the powers of the input.
        let m = 0.5 * (before + after);
        let alike = rate_slope * m + rate_bend * m * m;
        let by_way = rise + rise_slope * m + rise_bend * m * m;
        let factor = clamp(1.0 + alike + points * by_way, LOWEST, HIGHEST);
        // Farther back than `forgotten` nothing is left; so no input is too large.
        let distance = moved * points;
        let decays = rate * factor;
        if decays * distance > FORGOTTEN { distance = FORGOTTEN / decays; }
        let decay = decays * distance;
        let share = growth(-decay);
        let kept = 1.0 - decay * share;
        PATH
        LENGTH
        POWERS
DECAYS    }
";

#[cfg(test)]
mod tests {
    use super::super::tests::path;
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use serde_json::json;

    fn weighted(law: Narx, weights: Vec<f64>) -> Weighted<Narx> {
        Weighted::new(1.0, (-30.0, 30.0), law, weights).unwrap()
    }

    #[test]
    fn with_one_rate_it_converges_to_duhems_equation() {
        let duhem = json!({"operator": "duhem", "range": [-30, 30], "degree": 3, "alpha": 0.05,
                           "weights": [1.1, 0.1, -0.1, 0.4, 0.05, -0.1]});
        let duhem = super::super::load(&duhem, 1.0).unwrap();
        let law = Narx { travelled: vec![], ..Narx::all(3, 0.05) };
        let narx = weighted(law, vec![1.1, 0.1, -0.1, 0.4, 0.05, -0.1]);
        let off = |pieces: u32| {
            let u = path(&[0.0, 28.0, -20.0, 5.0, -29.0, 12.0], pieces);
            let (a, b) = (narx.simulate(&u), duhem.simulate(&u));
            a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (off(20), off(200));
        assert!(coarse < 0.02, "{coarse}");
        // Of second order: a tenth of the step, a hundredth of the error.
        assert_close(&[fine / coarse], &[0.01], 0.15, 0.0);
    }

    #[test]
    fn the_largest_inputs_leave_numbers() {
        for rate in [1e-100, 1e-3, 1.0, MAX_RATE] {
            let narx = weighted(Narx::all(2, rate), vec![1e-300; Narx::all(2, rate).responses()]);
            let z = narx.simulate(&[0.0, f64::MAX, -f64::MAX, 1.0, -2.0]);
            assert!(z.iter().all(|z| z.is_finite()), "{rate:e}: {z:?}");
        }
        let law = Narx::all(2, 1.1 * MAX_RATE);
        assert!(law.check().unwrap_err().to_string().contains("at most 1e100"));
    }

    #[test]
    fn no_input_and_no_rate_make_a_free_run_diverge() {
        for sign in [-MOST, MOST] {
            let law = Narx {
                rate_slope: sign,
                rate_bend: -sign,
                rise: sign,
                rise_slope: -sign,
                rise_bend: sign,
                ..Narx::all(5, 1.0 / 30.0)
            };
            let narx = weighted(law.clone(), vec![1.0; law.responses()]);
            let mut x = narx.initial();
            for t in 0..20_000u32 {
                narx.step(&mut x, if t % 7 == 0 { 1e9 } else { 40.0 * (f64::from(t) * 0.7).sin() });
                // 20 / rate, and rounding.
                assert!(x[1..].iter().all(|part| part.abs() <= 20.0 * 30.0 * 1.000001), "{x:?} at {t}");
            }
        }
    }

    #[test]
    fn the_terms_that_are_selected_remain_in_their_order() {
        let law = Narx::all(3, 0.05);
        // f_1 f_2 f_3, k_0 k_1 k_2, g_1 g_2
        let some = law.with_terms(&[0, 2, 4, 7]).unwrap();
        assert_eq!((some.reversible, some.moved, some.travelled), (vec![1, 3], vec![1], vec![2]));
        assert_eq!(law.with_terms(&[0, 1, 2, 3, 4, 5, 6, 7]), Some(law));
    }

    #[test]
    fn powers_that_are_not_ascending_or_too_high_are_an_error() {
        for (reversible, moved) in [(vec![2, 1], vec![0]), (vec![0], vec![0]), (vec![1], vec![10]), (vec![], vec![])] {
            let law = Narx { reversible, moved, travelled: vec![], ..Narx::all(1, 0.05) };
            let message = law.check().unwrap_err().to_string();
            assert!(message.contains("must"), "{message}");
        }
    }

    #[test]
    fn a_power_stands_once() {
        let law = Narx { reversible: vec![1, 1], ..Narx::all(1, 0.05) };
        let message = law.check().unwrap_err().to_string();
        assert!(message.starts_with("reversible = [1, 1]: must be ascending powers from 1 to 9"), "{message}");
    }

    #[test]
    fn a_program_has_no_powers_that_no_term_needs() {
        let texts = [1, 2].map(|degree| Narx::all(degree, 0.05).text());
        assert!(!texts[0].contains("let v = ") && texts[1].contains("let v = "), "{texts:?}");
    }
}
