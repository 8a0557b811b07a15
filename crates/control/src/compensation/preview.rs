//! The inverse of the linear block as a filter with preview.
//!
//! ```text
//! minimise  mean over f of  W(f) |G(f) F(f) / g - 1|^2 + m |F(f)|^2      g = G(0),  F(0) = 1 / g
//! W = 1 / (1 + (f / f_c)^2)^2
//! F = F_fir R      R = 1 / product of (1 - zeta_k / z) over slow zeros zeta_k of G,  R(0) = 1
//! ```
//! For zeros outside the unit circle a stable inverse needs preview. Zeros near it, such as the sampling zeros close to
//! -1, make it ring and amplify noise. Weighted least squares with a price m on effort gives up accuracy where it
//! matters least: references are slow, so errors are weighted by W, and F fades at frequencies where it would cost too
//! much. At 0 Hz F is exact. [`Preview::error`] gives the error elsewhere.
//!
//! F_fir is finite. A lightly damped zero inside the unit circle needs an inverse that decays as slowly as the zero,
//! for which a finite filter is too short at high sampling rates: the recursion R cancels it.
//!
//! Reference: S. Devasia, D. Chen & B. Paden, IEEE Trans. Autom. Control 41, 930 (1996), DOI 10.1109/9.508898
//! (preview); M. Tomizuka, J. Dyn. Syst. Meas. Control 109, 65 (1987), DOI 10.1115/1.3143822 (zeros that cannot be
//! cancelled). It does not do: zeros near 1 outside the unit circle that are slower than the filter is long; the
//! iterations of [`super::FeedForward`] correct for them.
//!
//! Why: docs/decisions/compensation.md, "The linear block is inverted over frequency".

use super::fir::Fir;
use libm::pow;
use nalgebra::{Complex, DMatrix, DVector};
use piezoid_models::linear::{Arx, Response};
use piezoid_models::program::Block;
use piezoid_numerics::complex::{modulus, polar};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use std::f64::consts::PI;

/// Number of frequencies in the least squares.
const GRID: usize = 2048;

/// Largest number of taps: the solution costs their cube.
const MAX_TAPS: usize = 1024;

/// Corner f_c of the weight, as a share of half the sampling rate [-].
const CORNER: f64 = 0.02;

/// Price m on effort [-].
const EFFORT: f64 = 1e-9;

/// What may be left at the end of the finite filter of the inverse of a zero [-]; more needs a recursion.
const LEFT: f64 = 1e-3;

/// Design of the inverse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirDesign {
    /// Preview [samples].
    pub ahead: usize,
    /// Number of taps.
    pub taps: usize,
}

impl FirDesign {
    /// For whole records.
    pub(crate) const WHOLE: FirDesign = FirDesign { ahead: 64, taps: 192 };

    /// Sample by sample, with a delay of `ahead` samples.
    pub(crate) fn delayed(ahead: usize) -> Self {
        FirDesign { ahead, taps: 48 + 2 * ahead }
    }
}

/// The inverse of a linear block, and the block.
///
/// State: the last inputs, newest first; then that of the recursion.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    fir: Fir,
    /// The inverse of zeros that are slower than the filter is long.
    recursion: Option<Arx>,
    block: Arx,
}

impl Preview {
    /// The inverse of `block`.
    ///
    /// # Errors
    /// [`Error::NoInverse`] for a block that is unstable or has no gain at 0 Hz; an error for invalid settings.
    pub(crate) fn new(block: &Arx, design: FirDesign) -> Result<Self, Error> {
        let FirDesign { ahead, taps } = design;
        if !(1..=MAX_TAPS).contains(&taps) || taps <= ahead {
            let rule = format!("must be from {} to {MAX_TAPS}", ahead.saturating_add(1));
            return Err(Error::parameter("taps", taps, rule));
        }
        let g = block.dc_gain();
        let none = |because: String| Err(Error::NoInverse { kind: "bounded", because });
        if !block.is_stable() {
            let farthest = block.poles().iter().map(|pole| pole.z.modulus()).fold(0.0, f64::max);
            return none(format!("it is unstable (pole modulus {farthest}): identify the model again"));
        }
        if !(g.is_finite() && g != 0.0) {
            return none(format!("its gain at 0 Hz is {g}: no unique input holds a constant displacement"));
        }
        if let ([], [delay_samples]) = (block.a(), &nonzero(block.b())[..])
            && *delay_samples <= ahead
        {
            // A pure gain has an exact inverse, which only adds the rest of the delay.
            let mut f = vec![0.0; ahead - delay_samples];
            f.push(1.0 / g);
            return Ok(Preview { fir: Fir::new(block.ts(), f, ahead)?, recursion: None, block: block.clone() });
        }
        let recursion = recursion(block, taps - ahead)?;
        // Correlations of the weighted response give the normal equations; the last row fixes the gain at 0 Hz.
        let mut own = vec![0.0; taps];
        let mut right = DVector::zeros(taps + 1);
        for k in 0..GRID {
            let angle = PI * (k as f64 + 0.5) / GRID as f64;
            let hz = 0.5 * angle / (PI * block.ts());
            let back = recursion.as_ref().map_or(Complex::from(1.0), |recursion| phasor(recursion.response(hz)));
            let h = phasor(block.response(hz)) * back / g;
            let weight = (1.0 + (angle / (PI * CORNER)).powi(2)).powi(-2) / GRID as f64;
            let rotation = polar(1.0, angle);
            // The effort is that of both filters; that of a gain of 1 is added below.
            let effort = EFFORT * (back.norm_sqr() - 1.0) / (GRID as f64 * weight);
            let mut rotated = polar(1.0, -angle * ahead as f64) * h.conj();
            let mut lag = Complex::from(h.norm_sqr() + effort);
            for j in 0..taps {
                own[j] += weight * lag.re;
                right[j] += weight * rotated.re;
                lag *= rotation;
                rotated *= rotation;
            }
        }
        own[0] += EFFORT;
        let normal = DMatrix::from_fn(taps + 1, taps + 1, |i, j| match (i == taps, j == taps) {
            (false, false) => own[i.abs_diff(j)],
            (true, true) => 0.0,
            _ => 1.0,
        });
        right[taps] = 1.0;
        let solved = normal.lu().solve(&right).filter(|f| f.iter().all(|f| f.is_finite()));
        let Some(solved) = solved else {
            return none("the least-squares problem of its inverse has no solution".into());
        };
        let mut f: Vec<f64> = solved.iter().take(taps).copied().collect();
        let sum: f64 = f.iter().sum();
        f.iter_mut().for_each(|f| *f /= sum * g);
        Ok(Preview { fir: Fir::new(block.ts(), f, ahead)?, recursion, block: block.clone() })
    }

    /// Preview on a whole record, which is the delay as a system [samples].
    pub fn ahead(&self) -> usize {
        self.fir.ahead()
    }

    /// The input of the block for a whole record of the displacement without offset, which is constant before its
    /// first sample and after its last.
    pub fn whole(&self, r: &[f64]) -> Vec<f64> {
        let (Some(recursion), Some(&first)) = (&self.recursion, r.first()) else { return self.fir.whole(r) };
        // The preview begins before the record.
        let before = std::iter::repeat_n(first, self.ahead());
        let mut x = self.fir.whole(&before.chain(r.iter().copied()).collect::<Vec<_>>());
        recursion.respond(&mut recursion.settled(x[0]), &mut x);
        x.split_off(self.ahead())
    }

    /// Frequency response F at `hz` [Hz] over a whole record.
    pub(super) fn response(&self, hz: f64) -> Complex<f64> {
        let recursion = self.recursion.as_ref().map_or(Complex::from(1.0), |recursion| phasor(recursion.response(hz)));
        phasor(self.fir.response(hz)) * recursion
    }

    /// |G F - 1| at `hz` [Hz]: the relative error for a sine of that frequency.
    pub fn error(&self, hz: f64) -> f64 {
        modulus(phasor(self.block.response(hz)) * self.response(hz) - 1.0)
    }

    /// The inverse as blocks of a program with a function each, `preview` and if needed `recursion`, initially settled
    /// at `at_rest`.
    pub(super) fn blocks(&self, at_rest: f64) -> Vec<Block> {
        let recursion = self.recursion.as_ref().map(|recursion| {
            let x = recursion.settled(at_rest / self.block.dc_gain());
            recursion.block_from("recursion", "the inverse of slow zeros: a difference equation", &x)
        });
        std::iter::once(self.fir.block(at_rest)).chain(recursion).collect()
    }

    /// True if there is a block `recursion`.
    pub(super) fn is_recursive(&self) -> bool {
        self.recursion.is_some()
    }
}

impl System for Preview {
    fn ts(&self) -> f64 {
        self.fir.ts()
    }

    fn order(&self) -> usize {
        self.fir.order() + self.recursion.as_ref().map_or(0, System::order)
    }

    fn settled(&self, r: f64) -> Vec<f64> {
        let recursion = self.recursion.as_ref().map(|recursion| recursion.settled(r / self.block.dc_gain()));
        [self.fir.settled(r), recursion.unwrap_or_default()].concat()
    }

    fn step(&self, x: &mut [f64], r: f64) -> f64 {
        let (past, x) = x.split_at_mut(self.fir.order());
        let z = self.fir.step(past, r);
        self.recursion.as_ref().map_or(z, |recursion| recursion.step(x, z))
    }
}

/// The inverse of the zeros inside the unit circle that has not decayed after so many samples. Zeros above a quarter of
/// the sampling rate are left to the least squares: a reference does not come near them, and their exact inverse rings.
fn recursion(block: &Arx, samples: usize) -> Result<Option<Arx>, Error> {
    block.inverse_of_zeros(|zero| zero.re > 0.0 && pow(zero.modulus(), samples as f64) > LEFT)
}

fn phasor(response: Response) -> Complex<f64> {
    polar(response.gain, response.phase)
}

/// Positions of the numbers that are not 0.
fn nonzero(numbers: &[f64]) -> Vec<usize> {
    numbers.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(k, _)| k).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// Poles of a beam, a delayed input, a sampling zero near -1 and one outside the unit circle.
    fn beam() -> Arx {
        Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 0.05, 0.149, 0.0976]).unwrap()
    }

    #[test]
    fn a_gain_with_a_delay_has_an_exact_inverse() {
        for (delay_samples, ahead) in [(0, 0), (0, 3), (2, 3)] {
            let block = Arx::new(1e-3, Vec::new(), [vec![0.0; delay_samples], vec![4.0]].concat()).unwrap();
            let fir = Preview::new(&block, FirDesign::delayed(ahead)).unwrap().fir;
            assert_eq!((fir.taps.len(), fir.ahead()), (ahead - delay_samples + 1, ahead));
            let x = fir.whole(&[1.0, 2.0, 5.0, 5.0, 5.0, 5.0, 5.0]);
            assert_eq!(
                block.resume(&mut block.settled(x[0]), &x)[delay_samples..4],
                [1.0, 2.0, 5.0, 5.0][delay_samples..]
            );
        }
    }

    #[test]
    fn block_after_inverse_is_exact_at_rest_and_accurate_at_low_frequencies() {
        let block = beam();
        assert!(block.zeros().iter().any(|z| z.modulus() > 1.5) && block.zeros().iter().any(|z| z.re < -0.9));
        let inverse = Preview::new(&block, FirDesign::WHOLE).unwrap();
        let r: Vec<f64> = (0..800).map(|t| 5.0 + (0.06 * f64::from(t)).sin().powi(3)).collect();
        let x = inverse.whole(&r);
        let y = block.resume(&mut block.settled(x[0]), &x);
        assert_close(&y[300..700], &r[300..700], 0.0, 1e-3);
        assert!(inverse.error(0.0) < 1e-12 && inverse.error(5.0) < 1e-5, "{}", inverse.error(5.0));
        assert_close(&inverse.whole(&[7.0; 9]), &[7.0 / block.dc_gain(); 9], 1e-12, 0.0);
        // The same for a delayed input.
        let delayed =
            Preview::new(&Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 0.1, 0.09]).unwrap(), FirDesign::WHOLE);
        assert!(delayed.as_ref().unwrap().error(0.0) < 1e-12 && delayed.unwrap().error(100.0) < 1e-4);
    }

    #[test]
    fn noise_and_ringing_stay_bounded_where_the_exact_inverse_rings() {
        // A zero on the unit circle at half the sampling rate: no exact inverse.
        let block = Arx::new(5e-4, vec![0.8], vec![0.1, 0.1]).unwrap();
        assert!(block.invert_whole(&[1.0, 2.0]).is_err());
        let inverse = Preview::new(&block, FirDesign::WHOLE).unwrap();
        let taps = &inverse.fir.taps;
        let noise_gain = taps.iter().map(|f| f * f).sum::<f64>().sqrt();
        assert!(inverse.error(100.0) < 1e-3 && noise_gain * block.dc_gain() < 20.0);
        let largest = taps.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        assert!(taps[0].abs().max(taps[taps.len() - 1].abs()) < 0.01 * largest);
    }

    /// A beam with a resonance at 160 Hz and a zero at 450 Hz, both with a damping of 3 %, sampled at this rate [Hz].
    fn sampled(rate: f64) -> Arx {
        let pair = |hz: f64| {
            let (angle, decay) = (2.0 * PI * hz / rate, libm::exp(-0.03 * 2.0 * PI * hz / rate));
            [2.0 * decay * angle.cos(), -decay * decay]
        };
        let ([a1, a2], [c1, c2]) = (pair(160.0), pair(450.0));
        Arx::new(1.0 / rate, vec![a1, a2], vec![0.0, 1.0, -c1, -c2]).unwrap()
    }

    #[test]
    fn the_inverse_of_a_beam_is_as_good_at_any_sampling_rate() {
        for rate in [2e3, 5e3, 2e4, 1e5] {
            let block = sampled(rate);
            for design in [FirDesign { ahead: 65, taps: 193 }, FirDesign::delayed(4)] {
                let inverse = Preview::new(&block, design).unwrap();
                let (at_50, at_150) = (inverse.error(50.0), inverse.error(150.0));
                assert!(at_50 < 2e-3 && at_150 < 2e-2, "{rate} Hz, {design:?}: {at_50}, {at_150}");
            }
        }
    }

    #[test]
    fn a_recursion_is_the_same_sample_by_sample_and_over_a_record_and_anticipates_its_beginning() {
        let inverse = Preview::new(&sampled(2e4), FirDesign { ahead: 65, taps: 193 }).unwrap();
        assert_eq!(inverse.recursion.as_ref().unwrap().order(), 2);
        // It moves from its first sample.
        let r: Vec<f64> = (0..3000).map(|t| 5.0 + (0.01 * f64::from(t)).sin().powi(3)).collect();
        let whole = inverse.whole(&r);
        let mut x = inverse.settled(r[0]);
        let delayed: Vec<f64> = r.iter().map(|r| inverse.step(&mut x, *r)).collect();
        assert_close(&delayed[65..], &whole[..r.len() - 65], 1e-12, 1e-12);
        let mut x = inverse.block.settled(whole[0]);
        let y: Vec<f64> = whole.iter().map(|z| inverse.block.step(&mut x, *z)).collect();
        assert_close(&y[..2900], &r[..2900], 0.0, 5e-3);
    }

    #[test]
    fn the_error_falls_with_the_preview() {
        let error = |ahead| Preview::new(&beam(), FirDesign::delayed(ahead)).unwrap().error(40.0);
        let errors = [1, 2, 4, 8, 16].map(error);
        assert!(errors.windows(2).all(|w| w[1] < w[0]), "{errors:?}");
    }

    #[test]
    fn a_block_without_static_gain_or_stability_has_no_inverse() {
        let refused = |a: Vec<f64>, b: Vec<f64>| {
            Preview::new(&Arx::new(1.0, a, b).unwrap(), FirDesign::WHOLE).unwrap_err().to_string()
        };
        assert!(refused(vec![1.0], vec![1.0]).contains("no bounded inverse"));
        assert!(refused(vec![], vec![1.0, -1.0]).contains("gain at 0 Hz is 0"));
        assert!(refused(vec![1.1], vec![1.0]).contains("unstable"));
        let none = FirDesign { taps: 3, ahead: 3 };
        assert!(Preview::new(&beam(), none).unwrap_err().to_string().starts_with("taps = 3: must be from 4"));
    }

    #[test]
    fn the_longest_delay_takes_the_most_taps() {
        assert_eq!(FirDesign::delayed(0), FirDesign { ahead: 0, taps: 48 });
        assert_eq!(FirDesign::delayed(488), FirDesign { ahead: 488, taps: MAX_TAPS });
    }
}
