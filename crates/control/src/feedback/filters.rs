//! Building blocks of linear laws: polynomials in q^-1, and second-order filters by matched poles.
//!
//! ```text
//! p(q) = 1 - 2 exp(-d w Ts) cos(w sqrt(1 - d^2) Ts) q^-1 + exp(-2 d w Ts) q^-2,    w = 2 pi hz
//! ```
//! has the poles of s^2 + 2 d w s + w^2, for damping ratios d up to 1.
//!
//! Reference: G. F. Franklin, J. D. Powell, M. Workman, Digital Control of Dynamic Systems, 1998, section 6.3 (matched
//! poles).

use libm::{cos, exp};
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

/// p(q) for a natural frequency [Hz] and a damping ratio.
pub(super) fn pair(ts: f64, hz: f64, damping: f64) -> [f64; 3] {
    let (decay, angle) = (damping * TAU * hz * ts, TAU * hz * ts * (1.0 - damping * damping).max(0.0).sqrt());
    [1.0, -2.0 * exp(-decay) * cos(angle), exp(-2.0 * decay)]
}

/// Second-order low-pass with static gain 1: p(1) / p(q).
pub(super) fn lag(ts: f64, hz: f64, damping: f64) -> Result<Arx, Error> {
    let p = pair(ts, hz, damping);
    ratio(ts, &[p.iter().sum()], &p)
}

/// Notch with static gain 1 and a gain of about `depth / width`, its two damping ratios, at `hz`.
pub(super) fn notch(ts: f64, hz: f64, depth: f64, width: f64) -> Result<Arx, Error> {
    let (zeros, poles) = (pair(ts, hz, depth), pair(ts, hz, width));
    let gain = poles.iter().sum::<f64>() / zeros.iter().sum::<f64>();
    ratio(ts, &zeros.map(|c| gain * c), &poles)
}

/// The block with this numerator and denominator; the first coefficient of the denominator is 1.
pub(super) fn ratio(ts: f64, numerator: &[f64], denominator: &[f64]) -> Result<Arx, Error> {
    Arx::new(ts, denominator[1..].iter().map(|c| -c).collect(), numerator.to_vec())
}

/// The product of two polynomials.
pub(super) fn times(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; (p.len() + q.len()).saturating_sub(1)];
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

/// p + k q.
pub(super) fn plus(p: &[f64], k: f64, q: &[f64]) -> Vec<f64> {
    let at = |c: &[f64], i: usize| c.get(i).copied().unwrap_or(0.0);
    (0..p.len().max(q.len())).map(|i| at(p, i) + k * at(q, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn a_pair_has_the_requested_poles() {
        let pole = lag(5e-4, 160.0, 0.03).unwrap().poles()[0];
        assert_close(&[pole.hz, pole.damping], &[160.0, 0.03], 1e-9, 0.0);
        let slow = lag(5e-4, 40.0, 1.0).unwrap();
        assert_close(&[slow.dc_gain(), slow.response(40.0).gain], &[1.0, 0.5], 0.01, 0.0);
    }

    #[test]
    fn a_notch_has_static_gain_1_and_blocks_its_frequency() {
        let notch = notch(5e-4, 160.0, 0.03, 0.6).unwrap();
        assert_close(&[notch.dc_gain(), notch.response(160.0).gain], &[1.0, 0.05], 1e-9, 0.01);
    }

    #[test]
    fn products_and_sums_of_polynomials_are_correct() {
        let (p, q) = ([1.0, 2.0, 3.0], [4.0, -1.0]);
        assert_eq!(times(&p, &q), [4.0, 7.0, 10.0, -3.0]);
        assert_eq!(plus(&p, 2.0, &q), [9.0, 0.0, 3.0]);
    }
}
