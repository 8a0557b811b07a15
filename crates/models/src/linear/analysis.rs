//! Analysis of a linear block: poles [Hz] with damping, zeros, gain, frequency response.
//!
//! A pole z of the difference equation corresponds to the continuous-time pole s = ln(z) / Ts, with natural frequency
//! |s| / 2 pi and damping ratio -Re s / |s|.

use super::Arx;
use libm::hypot;
use nalgebra::{Complex, DMatrix, DVector, linalg::Schur};
use piezoid_numerics::complex::{self, argument, modulus, polar};
use piezoid_numerics::system::System;
use serde::Serialize;
use std::f64::consts::TAU;

/// A real pole of the block, or a conjugate pair (listed once).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pole {
    /// Natural frequency [Hz].
    pub hz: f64,
    /// Damping ratio; negative when the pole is unstable.
    pub damping: f64,
    /// The pole in the z plane.
    #[serde(skip)]
    pub z: Root,
}

/// A complex number: a root of a polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Root {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Pole {
    /// The pole `z` of a block sampled every `ts` [s].
    pub(super) fn of(z: Root, ts: f64) -> Self {
        let s = complex::log(Complex::new(z.re, z.im)) / ts;
        let damping = if modulus(s) == 0.0 { 0.0 } else { -s.re / modulus(s) };
        Pole { hz: modulus(s) / TAU, damping, z }
    }
}

impl Root {
    /// Distance from the origin.
    pub fn modulus(&self) -> f64 {
        hypot(self.re, self.im)
    }
}

impl std::fmt::Display for Root {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Adding zero turns a rounded -0 into 0.
        let rounded = |x: f64| (1e3 * x).round() / 1e3 + 0.0;
        match rounded(self.im) {
            0.0 => write!(f, "{:.3}", rounded(self.re)),
            im => write!(f, "{:.3}{im:+.3}i", rounded(self.re)),
        }
    }
}

/// Frequency response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Frequency [Hz].
    pub hz: f64,
    /// Output amplitude over input amplitude.
    pub gain: f64,
    /// Phase [rad], between -pi and pi; negative when the output lags.
    pub phase: f64,
}

impl Arx {
    /// Poles by rising natural frequency, conjugate pairs listed once. Poles at the origin (trailing zeros of `a`) are
    /// delays and not listed; an integrator has frequency and damping 0.
    pub fn poles(&self) -> Vec<Pole> {
        let used = self.a().iter().rposition(|&a| a != 0.0).map_or(0, |last| last + 1);
        let mut poles: Vec<Pole> = roots(&self.denominator()[..=used])
            .into_iter()
            .filter(|z| z.im >= 0.0 || z.im.is_nan())
            .map(|z| Pole::of(z, self.ts()))
            .collect();
        poles.sort_by(|p, q| p.hz.total_cmp(&q.hz));
        poles
    }

    /// The oscillating pole (damping ratio from 0 to 0.3) with the largest response. The least damped pole may be
    /// hardly visible in the output.
    pub fn resonance(&self) -> Option<Pole> {
        let rings = self.poles().into_iter().filter(|p| p.z.im > 0.0 && (0.0..0.3).contains(&p.damping));
        let peak = |p: &Pole| self.response(p.hz).gain;
        rings.max_by(|p, q| peak(p).total_cmp(&peak(q)))
    }

    /// Zeros of b0 + b1 q^-1 + ... in the z plane, by rising modulus. Leading zeros of `b` (a delay) and trailing ones
    /// (zeros at the origin) are not listed.
    pub fn zeros(&self) -> Vec<Root> {
        let used = self.b().iter().rposition(|&b| b != 0.0).map_or(0, |last| last + 1);
        let mut zeros = roots(&self.b()[self.delay()..used]);
        zeros.sort_by(|p, q| p.modulus().total_cmp(&q.modulus()).then(p.im.total_cmp(&q.im)));
        zeros
    }

    /// Delay [samples]: the number of leading zeros of `b`.
    pub fn delay(&self) -> usize {
        self.b().iter().take_while(|&&b| b == 0.0).count()
    }

    /// True if every pole lies inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.poles().iter().all(|p| p.z.modulus() < 1.0)
    }

    /// Output for a constant input of 1 [output unit over input unit]; infinite when a pole lies at 1.
    pub fn dc_gain(&self) -> f64 {
        self.b().iter().sum::<f64>() / (1.0 - self.a().iter().sum::<f64>())
    }

    /// Frequency response at `hz` [Hz].
    pub fn response(&self, hz: f64) -> Response {
        let z = polar(1.0, -TAU * hz * self.ts());
        let horner = |c: &[f64]| c.iter().rev().fold(Complex::new(0.0, 0.0), |sum, &c| sum * z + c);
        let g = horner(self.b()) / (1.0 - horner(self.a()) * z);
        Response { hz, gain: modulus(g), phase: argument(g) }
    }
}

/// Roots of c0 z^n + c1 z^(n-1) + ... + cn, with c0 not zero: eigenvalues of the companion matrix, each polished by one
/// Newton step. Conjugates stay exact conjugates. Roots that cannot be found are NaN, so every check fails.
pub(crate) fn roots(c: &[f64]) -> Vec<Root> {
    let n = c.len().saturating_sub(1);
    if n == 0 {
        return Vec::new();
    }
    let companion = DMatrix::from_fn(n, n, |i, j| match (i, j) {
        (0, j) => -c[j + 1] / c[0],
        (i, j) => f64::from(u8::from(i == j + 1)),
    });
    // Shifted QR stalls on the symmetry of polynomials in even powers. A Householder reflection removes that symmetry.
    let normal = DVector::from_fn(n, |i, _| 1.0 / (1 + i) as f64);
    let reflection = DMatrix::identity(n, n) - &normal * normal.transpose() * (2.0 / normal.norm_squared());
    let reflected = &reflection * companion * &reflection;
    let schur =
        if reflected.iter().all(|v| v.is_finite()) { Schur::try_new(reflected, f64::EPSILON, 10_000) } else { None };
    let Some(schur) = schur else { return vec![Root { re: f64::NAN, im: f64::NAN }; n] };
    schur
        .complex_eigenvalues()
        .iter()
        .map(|&z| {
            let (value, slope) =
                c.iter().fold((Complex::new(0.0, 0.0), Complex::new(0.0, 0.0)), |(p, dp), &c| (p * z + c, dp * z + p));
            let step = value / slope;
            let polished = if modulus(step) < 1e-6 * modulus(z) { z - step } else { z };
            Root { re: polished.re, im: if z.im == 0.0 { 0.0 } else { polished.im } }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    const TS: f64 = 5e-4;

    /// A pole in the z plane.
    fn pole(hz: f64, damping: f64) -> Complex<f64> {
        polar((-TAU * hz * damping * TS).exp(), TAU * hz * TS)
    }

    #[test]
    fn table_2_has_the_poles_and_zeros_of_the_reproduced_paper() {
        let table2 = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003]).unwrap();
        let poles = table2.poles();
        assert_eq!(poles.len(), 1);
        assert_close(&[poles[0].hz, poles[0].damping], &[146.7, 0.061], 1e-3, 0.0);
        let zeros: Vec<f64> = table2.zeros().iter().map(|z| z.re).collect();
        assert_close(&zeros, &[-0.360, 0.694], 0.0, 6e-4);
        // It leads by 33 degrees at 80 Hz, where a beam lags by 4.
        assert_close(&[table2.response(80.0).phase.to_degrees()], &[33.0], 0.0, 0.6);
    }

    #[test]
    fn roots_of_a_product_are_the_factors() {
        // (z - 0.5)(z + 2)(z^2 - 1.8 z + 0.9)
        let found = roots(&[1.0, -0.3, -2.8, 3.15, -0.9]);
        let mut re: Vec<f64> = found.iter().map(|z| z.re).collect();
        re.sort_by(f64::total_cmp);
        assert_close(&re, &[-2.0, 0.5, 0.9, 0.9], 1e-12, 0.0);
        assert_close(&[found.iter().map(|z| z.im).fold(0.0, f64::max)], &[0.3], 1e-12, 0.0);
    }

    #[test]
    fn poles_at_the_origin_are_delays_and_an_integrator_has_no_frequency() {
        let poles = Arx::new(1.0, vec![1.0, 0.0], vec![1.0]).unwrap().poles();
        assert_eq!((poles.len(), poles[0].hz, poles[0].damping), (1, 0.0, 0.0));
    }

    #[test]
    fn a_block_whose_roots_cannot_be_found_has_no_inverse() {
        let block = Arx::new(1.0, vec![], vec![1e-300, 1e300, 1.0]).unwrap();
        assert!(block.inverse().is_err() && block.invert_whole(&[1.0, 2.0]).is_err());
    }

    #[test]
    fn a_pole_on_the_circle_or_one_that_is_not_found_is_not_stable() {
        let block = |a: Vec<f64>| Arx::new(1.0, a, vec![1.0]).unwrap();
        assert_eq!([0.999, 1.0, 1.001, -1.0].map(|a| block(vec![a]).is_stable()), [true, false, false, false]);
        let lost = block(vec![1e308; 3]);
        assert!(lost.poles().len() == 3 && !lost.is_stable());
    }

    #[test]
    fn a_response_is_the_ratio_of_its_sums() {
        let block = Arx::new(TS, vec![1.7, -0.9, 0.1], vec![0.0, 3.0, -2.5, 0.4]).unwrap();
        let sum = |c: &[f64], hz: f64| -> Complex<f64> {
            c.iter().zip(0..).map(|(c, k)| polar(*c, -TAU * hz * TS * f64::from(k))).sum()
        };
        for hz in [0.0, 40.0, 166.0, 700.0] {
            let expected = sum(block.b(), hz) / sum(&[1.0, -1.7, 0.9, -0.1], hz);
            let found = block.response(hz);
            assert_close(&[found.gain, found.phase], &[modulus(expected), argument(expected)], 1e-12, 1e-12);
        }
    }

    #[test]
    fn zeros_are_listed_by_modulus_and_written_to_three_places() {
        // (z - 0.9)(z^2 - 0.8 z + 0.25), behind a delay and before a zero at the origin.
        let block = Arx::new(1.0, vec![], vec![0.0, 2.0, -3.4, 1.94, -0.45, 0.0]).unwrap();
        let written: Vec<String> = block.zeros().iter().map(Root::to_string).collect();
        assert_eq!(written, ["0.400-0.300i", "0.400+0.300i", "0.900"]);
        assert_eq!(Root { re: -1e-4, im: -1e-4 }.to_string(), "0.000");
    }

    #[test]
    fn a_delay_has_no_zeros_and_no_poles() {
        let delay = Arx::new(1.0, vec![], vec![0.0, 0.0, 3.0, 0.0]).unwrap();
        assert_eq!((delay.delay(), delay.zeros().len(), delay.poles().len()), (2, 0, 0));
        assert_eq!(delay.dc_gain(), 3.0);
    }

    #[test]
    fn the_resonance_is_the_highest_peak_and_not_the_least_damped_pole() {
        // 166 Hz carries the displacement; 900 Hz, less damped, a thousandth of it.
        let quadratic = |p: Complex<f64>| [1.0, -2.0 * p.re, p.norm_sqr()];
        let ([_, a1, a2], [_, c1, c2]) = (quadratic(pole(166.0, 0.03)), quadratic(pole(900.0, 0.02)));
        let (large, small) = (1.0 + a1 + a2, 1e-3 * (1.0 + c1 + c2));
        let a = vec![-(a1 + c1), -(a2 + a1 * c1 + c2), -(a1 * c2 + a2 * c1), -(a2 * c2)];
        let b = vec![0.0, large + small, large * c1 + small * a1, large * c2 + small * a2];
        let found = Arx::new(TS, a, b).unwrap().resonance().unwrap();
        assert!((found.hz - 166.0).abs() < 1.0, "{} Hz", found.hz);
    }

    #[test]
    fn poles_that_are_real_or_well_damped_or_unstable_are_no_resonance() {
        let resonance = |z: Complex<f64>| {
            let block = Arx::new(TS, vec![2.0 * z.re, -z.norm_sqr()], vec![1.0]).unwrap();
            block.resonance().map(|pole| pole.hz)
        };
        assert_eq!(Arx::new(TS, vec![1.0], vec![1.0]).unwrap().resonance(), None);
        assert_eq!([0.5, -0.01].map(|damping| resonance(pole(100.0, damping))), [None, None]);
        assert!(resonance(pole(100.0, 0.2)).is_some());
    }
}
