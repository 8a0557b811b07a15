//! Creep and the linear block as one state-space system, with a constant disturbance.
//!
//! ```text
//! s+ = A s + B z + (noise)        s = [linear block, lags of creep, p]
//! y  = C s + D z + offset         p+ = p, added to z after its creep
//! ```
//! The linear block is in observer form of minimal order: s_i+ = s_{i+1} + a_i y + b_i w with w = z + g_1 x_1 + ... +
//! p. p explains every constant error of model or plant, therefore no offset remains: U. Maeder, F. Borrelli, M.
//! Morari, Automatica 45, 2214 (2009), DOI 10.1016/j.automatica.2009.05.023; G. Pannocchia, J. B. Rawlings, AIChE J.
//! 49, 426 (2003), DOI 10.1002/aic.690490213.

use libm::expm1;
use nalgebra::{DMatrix, DVector, RowDVector};
use piezoid_models::creep::Creep;
use piezoid_models::linear::Arx;
use piezoid_numerics::system::System;

/// The matrices.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Realisation {
    pub(super) a: DMatrix<f64>,
    pub(super) b: DVector<f64>,
    pub(super) c: RowDVector<f64>,
    pub(super) d: f64,
    /// Samples between z and its first effect.
    pub(super) delay: usize,
}

impl Realisation {
    pub(super) fn new(creep: &Creep, linear: &Arx) -> Self {
        let (m, n) = (linear.a().len().max(linear.b().len() - 1), creep.lags().len());
        let (order, p) = (m + n + 1, m + n);
        let at = |c: &[f64], i: usize| c.get(i).copied().unwrap_or(0.0);
        let rates: Vec<f64> = creep.lags().iter().map(|lag| -expm1(-creep.ts() / lag.tau_s)).collect();

        // w = through z + crept s
        let through = 1.0 + creep.lags().iter().zip(&rates).map(|(lag, rate)| lag.gain * rate).sum::<f64>();
        let mut crept = RowDVector::zeros(order);
        crept[p] = 1.0;
        for (k, (lag, rate)) in creep.lags().iter().zip(&rates).enumerate() {
            crept[m + k] = lag.gain * (1.0 - rate);
        }
        let (b0, mut c) = (linear.b()[0], linear.b()[0] * &crept);
        if m > 0 {
            c[0] += 1.0;
        }
        let d = b0 * through;

        let (mut a, mut b) = (DMatrix::zeros(order, order), DVector::zeros(order));
        for i in 0..m {
            let (fed_back, fed) = (at(linear.a(), i), at(linear.b(), i + 1));
            a.row_mut(i).copy_from(&(fed_back * &c + fed * &crept));
            if i + 1 < m {
                a[(i, i + 1)] += 1.0;
            }
            b[i] = fed_back * d + fed * through;
        }
        for (k, rate) in rates.iter().enumerate() {
            a[(m + k, m + k)] = 1.0 - rate;
            b[m + k] = *rate;
        }
        a[(p, p)] = 1.0;
        Realisation { a, b, c, d, delay: linear.delay() }
    }

    /// Length of s.
    pub(super) fn order(&self) -> usize {
        self.b.len()
    }

    /// h_0, h_1, ...: the impulse response.
    pub(super) fn impulse(&self, length: usize) -> Vec<f64> {
        let mut s = self.b.clone();
        let mut h = vec![self.d];
        while h.len() < length {
            h.push((&self.c * &s)[0]);
            s = &self.a * s;
        }
        h
    }

    /// C A^(delay), C A^(delay + 1), ...: the free response of s, from the sample on which the next z acts.
    pub(super) fn free(&self, length: usize) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(length, self.order());
        let mut row = self.c.clone();
        for t in 0..self.delay + length {
            if let Some(i) = t.checked_sub(self.delay) {
                rows.row_mut(i).copy_from(&row);
            }
            row *= &self.a;
        }
        rows
    }

    /// The settled state for a constant z, without disturbance.
    pub(super) fn settled(&self, creep: &Creep, linear: &Arx, z: f64) -> Vec<f64> {
        let n = creep.lags().len();
        let m = self.order() - n - 1;
        let w = z * (1.0 + creep.lags().iter().map(|lag| lag.gain).sum::<f64>());
        let y = Some(linear.dc_gain() * w).filter(|y| y.is_finite()).unwrap_or(0.0);
        let at = |c: &[f64], i: usize| c.get(i).copied().unwrap_or(0.0);
        let mut s = vec![0.0; m];
        for i in (0..m).rev() {
            let next = if i + 1 < m { s[i + 1] } else { 0.0 };
            s[i] = next + at(linear.a(), i) * y + at(linear.b(), i + 1) * w;
        }
        s.extend(std::iter::repeat_n(z, n));
        s.push(0.0);
        s
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// Creep and a resonance whose input is delayed by `delay` samples.
    pub(in super::super) fn blocks(delay: usize) -> (Creep, Arx) {
        let creep = Creep::logarithmic(5e-4, 0.02, 0.01, 1.0).unwrap();
        let b = [vec![0.0; delay], vec![0.1, 0.25, 0.05]].concat();
        (creep, Arx::new(5e-4, vec![1.6, -0.8], b).unwrap())
    }

    #[test]
    fn the_realisation_matches_the_blocks() {
        for delay in 0..3 {
            let (creep, linear) = blocks(delay);
            let r = Realisation::new(&creep, &linear);
            let z: Vec<f64> = (0..200).map(|t| f64::from(t * t % 17)).collect();
            let mut s = DVector::zeros(r.order());
            let y: Vec<f64> = z
                .iter()
                .map(|z| {
                    let y = (&r.c * &s)[0] + r.d * z;
                    s = &r.a * &s + &r.b * *z;
                    y
                })
                .collect();
            let known = linear.simulate(&creep.simulate(&z));
            assert_close(&y, &known, 1e-11, 1e-11);
            let impulse: Vec<f64> = (0..50).map(|t| f64::from(u8::from(t == 0))).collect();
            assert_close(&r.impulse(50), &linear.simulate(&creep.simulate(&impulse)), 1e-11, 1e-12);
        }
    }

    #[test]
    fn a_settled_state_stays_settled() {
        let (creep, linear) = blocks(1);
        let r = Realisation::new(&creep, &linear);
        let s = DVector::from_vec(r.settled(&creep, &linear, 3.0));
        assert_close((&r.a * &s + &r.b * 3.0).as_slice(), s.as_slice(), 1e-12, 0.0);
        assert_close(&[(&r.c * &s)[0]], &[linear.dc_gain() * 3.0 * 1.06], 1e-12, 0.0);
    }
}
