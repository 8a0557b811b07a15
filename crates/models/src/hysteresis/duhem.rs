//! Duhem's equation in Coleman & Hodgdon's form, with polynomials.
//!
//! ```text
//! h' = alpha |u'| (f(u) - h) + u' g(u),      z = h
//! ```
//! f and g are polynomials, f(0) = 0. With k = f' - g, which is not negative for loops in the direction of piezo loops,
//! an equivalent form is
//! ```text
//! z = f(u) - psi,      psi' = -alpha |u'| psi + u' k(u)
//! ```
//! It is linear in the coefficients of f and k: z = sum_i f_i S (u/S)^i - sum_j k_j psi_j, i = 1..n, j = 0..n-1, with S
//! the largest |u| of the range. Samples are integrated exactly: over a path of length s from u_0 to u_1
//! ```text
//! psi_j <- e^-x psi_j + (u_1 - u_0) int_0^1 e^(-x r) ((u_1 + (u_0 - u_1) r) / S)^j dr,      x = alpha s
//! ```
//! Reference: B. D. Coleman & M. L. Hodgdon, "A constitutive relation for rate-independent hysteresis in
//! ferromagnetically soft materials", Int. J. Eng. Sci. 24 (1986); for piezo actuators H. J. M. T. S. Adriaens et al.,
//! IEEE/ASME Trans. Mechatronics 5 (2000), DOI 10.1109/3516.891044. It does not do: rate, wiping out; minor loops start
//! without a jump but do not close; the polynomials diverge outside the range.
//!
//! Inverse: Newton's method on the integrals. Where the polynomials have an extremum, usually outside the range, z
//! decreases and one of several inputs is found.

use super::basis::ShapeParameter;
use super::bouc_wen::bends;
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: f_1, ..., f_n, then k_0, ..., k_(n-1).
///
/// State: psi_0, ..., psi_(n-1) [input unit].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Duhem {
    /// n
    degree: usize,
    /// [1/input unit]
    alpha: f64,
}

/// Default and maximum degree of f.
const DEGREE: usize = 3;
const MAX_DEGREE: usize = 7;

pub(super) static OPERATOR: Operator = Operator {
    name: "duhem",
    aliases: &["coleman-hodgdon"],
    summary: "Coleman & Hodgdon's differential equation with polynomials of the input: smooth asymmetric loops",
    reference: "Coleman & Hodgdon 1986, Int. J. Eng. Sci. 24; Adriaens et al. 2000, doi:10.1109/3516.891044",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<Duhem>::load,
    basis: |design| {
        let degree = design.elements.unwrap_or(DEGREE).clamp(1, MAX_DEGREE);
        Weighted::basis(design.ts, design.range, Duhem { degree, alpha: 1.0 / design.half() })
    },
    example: |ts| Weighted::example(ts, Duhem { degree: 3, alpha: 0.04 }, vec![1.1, 0.1, -0.1, 0.4, 0.05, -0.1]),
};

impl Law for Duhem {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("alpha", self.alpha, "1 / input unit")?;
        let rule = format!("must be from 1 to {MAX_DEGREE}");
        require((1..=MAX_DEGREE).contains(&self.degree), "degree", self.degree as f64, &rule)
    }

    fn responses(&self) -> usize {
        2 * self.degree
    }

    fn order(&self) -> usize {
        self.degree
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let scale = input.largest();
        let v = input.u / scale.into();
        if input.direction() != 0.0 {
            let length = shape[0] * input.length();
            let left = (-length).exp();
            let (end, back) = (v, -input.path() / scale.into());
            // integral[i] is that of e^(-x r) v^j r^i, v the scaled input, for j = 0, 1, 2, ...
            let n = x.len();
            let mut integral = moments(length, left, n);
            for (j, psi) in x.iter_mut().enumerate() {
                *psi = left * *psi + input.path() * integral[0];
                for i in 0..n - 1 - j {
                    integral[i] = end * integral[i] + back * integral[i + 1];
                }
            }
        }
        let mut power = R::from(scale);
        for i in 0..self.degree {
            power = power * v;
            phi(i, power);
        }
        for (j, psi) in x.iter().enumerate() {
            phi(self.degree + j, -*psi);
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let block = block.numbers("psi", vec![0.0; self.degree]).count("n", self.degree);
        let block = block.constant("scale", input.largest()).constant("long_path", MAX_DEGREE as f64);
        block.table("reciprocal", &RECIPROCALS).count("terms", RECIPROCALS.len()).text(STEP)
    }

    /// The first coefficients of f and k are not negative.
    fn non_negative(&self, k: usize) -> bool {
        k == 0 || k == self.degree
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = bends(half);
        vec![ShapeParameter { name: "alpha", value: self.alpha, low, high }]
    }
}

/// m_i = int_0^1 e^(-x r) r^i dr for i = 0..n, given e^-x, x >= 0. By parts (i + 1) m_i = e^-x + x m_(i+1). The
/// recursion is stable downwards for small x and upwards for large x.
fn moments<R: Real>(x: R, left: R, n: usize) -> [R; MAX_DEGREE] {
    let mut m = [R::from(0.0); MAX_DEGREE];
    if x.value() > MAX_DEGREE as f64 {
        m[0] = (-x).growth();
        for i in 1..n {
            m[i] = (R::from(i as f64) * m[i - 1] - left) / x;
        }
        return m;
    }
    // e^-x (1/n + x/(n (n+1)) + ...): all terms are positive.
    let mut term = R::from(1.0 / n as f64);
    let mut sum = term;
    for reciprocal in &RECIPROCALS[n..] {
        term = term * x * (*reciprocal).into();
        sum = sum + term;
        if term.value() < 0.05 * f64::EPSILON * sum.value() {
            break;
        }
    }
    m[n - 1] = left * sum;
    for i in (0..n - 1).rev() {
        m[i] = (left + x * m[i + 1]) * RECIPROCALS[i].into();
    }
    m
}

/// 1, 1/2, 1/3, ...: a multiplication takes a quarter of the time of a division.
const RECIPROCALS: [f64; 60 + MAX_DEGREE] = {
    let (mut r, mut i) = ([1.0; 60 + MAX_DEGREE], 1);
    while i < r.len() {
        r[i] = 1.0 / (i + 1) as f64;
        i += 1;
    }
    r
};

/// [`moments`] and [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    let v = u / scale;
    if points != 0.0 {
        let length = alpha * (path * points);
        let kept = exponential(-length);
        // The integrals of exp(-length t) t^i for t from 0 to 1, upwards where the path is long, else downwards.
        let integral = [0.0; n];
        if length > long_path {
            integral[0] = growth(-length);
            for i in 1..n {
                integral[i] = (real(i) * integral[i - 1] - kept) / length;
            }
        } else {
            let term = reciprocal[n - 1];
            let sum = term;
            let k = n;
            while k < terms && term >= 0.05 * epsilon * sum at most terms - n {
                term = term * length * reciprocal[k];
                sum += term;
                k += 1;
            }
            integral[n - 1] = kept * sum;
            for i in 0..n - 1 down {
                integral[i] = (kept + length * integral[i + 1]) * reciprocal[i];
            }
        }
        // Then with v^j in place of 1, for one j after the other.
        let back = -path / scale;
        for j in 0..n {
            x.psi[j] = kept * x.psi[j] + path * integral[0];
            for i in 0..n - 1 - j {
                integral[i] = v * integral[i] + back * integral[i + 1];
            }
        }
    }
    let power_of_v = scale * v;
    let z = w[0] * power_of_v;
    for i in 1..n {
        power_of_v *= v;
        z += w[i] * power_of_v;
    }
    for j in 0..n {
        z -= w[n + j] * x.psi[j];
    }
    x.last = u;
    return z;
}
";

#[cfg(test)]
mod tests {
    use super::super::tests::path;
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn moments_are_the_integrals_for_short_and_long_paths() {
        for x in [0.0, 1e-9, 0.3, 6.9, 7.1, 80.0] {
            let n = 200_000;
            // Midpoint rule.
            let integral = |i: i32| {
                let r = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
                (0..n).map(|k| (-x * r(k)).exp() * r(k).powi(i)).sum::<f64>() / f64::from(n)
            };
            for few in [1, 3, MAX_DEGREE] {
                let known: Vec<f64> = (0..few).map(|i| integral(i as i32)).collect();
                assert_close(&moments(x, (-x).exp(), few)[..few], &known, 1e-7, 0.0);
            }
        }
    }

    #[test]
    fn the_division_of_a_path_into_samples_has_no_effect() {
        let run = |pieces: u32| {
            let law = Duhem { degree: 4, alpha: 0.2 };
            let weights = vec![0.0, 0.0, 0.0, 0.0, 1.0, -0.5, 0.3, 2.0];
            let operator = Weighted::new(1.0, (-30.0, 30.0), law, weights).unwrap();
            *operator.simulate(&path(&[0.0, 30.0, -20.0, 5.0, -30.0], pieces)).last().unwrap()
        };
        assert_close(&[run(1000)], &[run(1)], 1e-11, 0.0);
    }
}
