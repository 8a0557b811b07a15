//! The discrete Fourier transform, X_k = sum over t of x_t exp(-2 pi i k t / n), rounded the same whatever vector unit
//! the machine has.

use nalgebra::Complex;
use rustfft::{Fft, FftPlannerScalar};
use std::sync::Arc;

/// The transform of `n` samples, planned once.
pub(crate) fn forward(n: usize) -> Arc<dyn Fft<f64>> {
    FftPlannerScalar::new().plan_fft_forward(n)
}

/// The sum of `cos(2 pi k t / n + phase)` over the harmonics k in `lines`, all below n, for t from 0 up to `n`.
pub(crate) fn cosines(lines: &[usize], phases: &[f64], fft: &dyn Fft<f64>) -> Vec<Complex<f64>> {
    // The forward transform of conjugate lines: its real part is the sum of cosines.
    let mut signal = vec![Complex::ZERO; fft.len()];
    for (k, phase) in lines.iter().zip(phases) {
        signal[*k] = Complex::cis(-phase);
    }
    fft.process(&mut signal);
    signal
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn the_sum_of_cosines_is_the_sum_that_it_replaces() {
        for n in [2, 7, 64, 500] {
            let lines: Vec<usize> = (1..n).step_by(3).collect();
            let phases: Vec<f64> = lines.iter().map(|k| (k * k % 7) as f64).collect();
            let line = |t: usize, k: usize, phase: f64| (TAU * (k * t % n) as f64 / n as f64 + phase).cos();
            let slow: Vec<f64> =
                (0..n).map(|t| lines.iter().zip(&phases).map(|(k, phase)| line(t, *k, *phase)).sum()).collect();
            let fast: Vec<f64> = cosines(&lines, &phases, &*forward(n)).iter().map(|v| v.re).collect();
            assert_close(&fast, &slow, 0.0, 1e-11);
        }
    }
}
