//! The discrete Fourier transform, and sums of many cosines by way of it.
//!
//! `X_k = sum over t of x_t exp(-2 pi i k t / n)`. A power of two of samples is halved and halved again (Cooley and
//! Tukey, DOI 10.1090/S0025-5718-1965-0178586-1). Any other number becomes a convolution of such a length by writing
//! `2 k t = k^2 + t^2 - (t - k)^2` (Bluestein, DOI 10.1109/TAU.1970.1162132).

use nalgebra::Complex;
use std::f64::consts::{PI, TAU};

/// The transform of a power of two of samples.
pub(super) struct Fft {
    /// `exp(-2 pi i k / n)` over half a turn.
    roots: Vec<Complex<f64>>,
}

impl Fft {
    /// For `n` samples, a power of two.
    pub(super) fn new(n: usize) -> Self {
        Fft { roots: (0..n / 2).map(|k| Complex::cis(-TAU * k as f64 / n as f64)).collect() }
    }

    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        2 * self.roots.len()
    }

    /// Puts the transform in the place of the samples, of which there must be [`len`](Fft::len).
    pub(super) fn transform(&self, x: &mut [Complex<f64>]) {
        let n = self.len();
        for i in 0..n {
            let j = i.reverse_bits() >> (usize::BITS - n.trailing_zeros());
            if i < j {
                x.swap(i, j);
            }
        }
        let mut half = 1;
        while half < n {
            let stride = n / (2 * half);
            for block in x.chunks_exact_mut(2 * half) {
                let (even, odd) = block.split_at_mut(half);
                for ((e, o), root) in even.iter_mut().zip(odd).zip(self.roots.iter().step_by(stride)) {
                    let turned = *o * root;
                    *o = *e - turned;
                    *e += turned;
                }
            }
            half *= 2;
        }
    }
}

/// The sum of `cos(2 pi k t / n + phase)` over the harmonics k in `lines`, all below n, for t from 0 up to `n`.
pub(super) fn cosines(lines: &[usize], phases: &[f64], n: usize) -> Vec<f64> {
    // exp(i pi t^2 / n), the angle reduced in integers.
    let chirp = |t: usize| Complex::cis(PI * (t as u64 * t as u64 % (2 * n as u64)) as f64 / n as f64);
    let fft = Fft::new((2 * n).next_power_of_two());
    let mut signal = vec![Complex::ZERO; fft.len()];
    for (k, phase) in lines.iter().zip(phases) {
        signal[*k] = Complex::cis(*phase) * chirp(*k);
    }
    let mut kernel = vec![Complex::ZERO; fft.len()];
    for t in 0..n {
        kernel[t] = chirp(t).conj();
        kernel[(fft.len() - t) % fft.len()] = kernel[t];
    }
    fft.transform(&mut signal);
    fft.transform(&mut kernel);
    // The inverse transform is the conjugate of the transform of the conjugate, over the length.
    signal.iter_mut().zip(&kernel).for_each(|(s, k)| *s = (*s * k).conj());
    fft.transform(&mut signal);
    let scale = 1.0 / fft.len() as f64;
    signal.iter().take(n).enumerate().map(|(t, s)| scale * (s.conj() * chirp(t)).re).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn the_transform_is_the_sum_that_defines_it() {
        let x: Vec<Complex<f64>> = (0..16).map(|t| Complex::new(f64::from(t * t % 7), f64::from(t % 3))).collect();
        let mut fast = x.clone();
        Fft::new(16).transform(&mut fast);
        for (k, fast) in fast.iter().enumerate() {
            let turn = |t: usize| Complex::cis(-TAU * (k * t) as f64 / 16.0);
            let slow: Complex<f64> = x.iter().enumerate().map(|(t, x)| x * turn(t)).sum();
            assert_close(&[fast.re, fast.im], &[slow.re, slow.im], 0.0, 1e-12);
        }
    }

    #[test]
    fn the_sum_of_cosines_is_the_sum_that_it_replaces() {
        for n in [2, 7, 64, 500] {
            let lines: Vec<usize> = (1..n).step_by(3).collect();
            let phases: Vec<f64> = lines.iter().map(|k| (k * k % 7) as f64).collect();
            let line = |t: usize, k: usize, phase: f64| (TAU * (k * t % n) as f64 / n as f64 + phase).cos();
            let slow: Vec<f64> =
                (0..n).map(|t| lines.iter().zip(&phases).map(|(k, phase)| line(t, *k, *phase)).sum()).collect();
            assert_close(&cosines(&lines, &phases, n), &slow, 0.0, 1e-11);
        }
    }
}
