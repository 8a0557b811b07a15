//! The inverse of the linear block as a filter with preview.
//!
//! ```text
//! minimise  mean over f of  W(f) |G(f) F(f) / g - 1|^2 + m |F(f)|^2      g = G(0),  F(0) = 1 / g
//! W = 1 / (1 + (f / f_c)^2)^2
//! ```
//! For zeros outside the unit circle a stable inverse needs preview. Zeros near it, such as the sampling zeros close to
//! -1, make it ring and amplify noise. Weighted least squares with a price m on effort gives up accuracy where it
//! matters least: references are slow, so errors are weighted by W, and F fades at frequencies where it would cost too
//! much. At 0 Hz F is exact. [`Preview::error`] gives the error elsewhere.
//!
//! Reference: S. Devasia, D. Chen & B. Paden, IEEE Trans. Autom. Control 41, 930 (1996), DOI 10.1109/9.508898
//! (preview); M. Tomizuka, J. Dyn. Syst. Meas. Control 109, 65 (1987), DOI 10.1115/1.3143822 (zeros that cannot be
//! cancelled). It does not do: zeros near 1 that are slower than the filter is long; the iterations of
//! [`super::FeedForward`] correct for them.
//!
//! Why: docs/decisions/compensation.md, "The linear block is inverted over frequency".

use super::fir::Fir;
use nalgebra::{Complex, DMatrix, DVector};
use piezoid_models::linear::Arx;
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
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    fir: Fir,
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
            return Ok(Preview { fir: Fir::new(block.ts(), f, ahead)?, block: block.clone() });
        }
        // Correlations of the weighted response give the normal equations; the last row fixes the gain at 0 Hz.
        let mut own = vec![0.0; taps];
        let mut right = DVector::zeros(taps + 1);
        for k in 0..GRID {
            let angle = PI * (k as f64 + 0.5) / GRID as f64;
            let r = block.response(0.5 * angle / (PI * block.ts()));
            let h = polar(r.gain, r.phase) / g;
            let weight = (1.0 + (angle / (PI * CORNER)).powi(2)).powi(-2) / GRID as f64;
            let rotation = polar(1.0, angle);
            let (mut rotated, mut lag) = (polar(1.0, -angle * ahead as f64) * h.conj(), Complex::from(h.norm_sqr()));
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
        Ok(Preview { fir: Fir::new(block.ts(), f, ahead)?, block: block.clone() })
    }

    /// The filter: its input is the displacement without offset, its output the input of the block.
    pub fn fir(&self) -> &Fir {
        &self.fir
    }

    /// |G F - 1| at `hz` [Hz]: the relative error for a sine of that frequency.
    pub fn error(&self, hz: f64) -> f64 {
        let (g, f) = (self.block.response(hz), self.fir.response(hz));
        modulus(polar(g.gain * f.gain, g.phase + f.phase) - 1.0)
    }
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
            let fir = Preview::new(&block, FirDesign::delayed(ahead)).unwrap().fir().clone();
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
        let x = inverse.fir().whole(&r);
        let y = block.resume(&mut block.settled(x[0]), &x);
        assert_close(&y[300..700], &r[300..700], 0.0, 1e-3);
        assert!(inverse.error(0.0) < 1e-12 && inverse.error(5.0) < 1e-5, "{}", inverse.error(5.0));
        assert_close(&inverse.fir().whole(&[7.0; 9]), &[7.0 / block.dc_gain(); 9], 1e-12, 0.0);
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
        let taps = &inverse.fir().taps;
        let noise_gain = taps.iter().map(|f| f * f).sum::<f64>().sqrt();
        assert!(inverse.error(100.0) < 1e-3 && noise_gain * block.dc_gain() < 20.0);
        let largest = taps.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        assert!(taps[0].abs().max(taps[taps.len() - 1].abs()) < 0.01 * largest);
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
}
