//! Spectra, by the discrete Fourier transform.

mod transform;

use crate::complex::{modulus, polar};
use libm::cos;
use nalgebra::Complex;
use std::f64::consts::PI;
pub use transform::Transform;

/// Width of a line in [`power`] [bins].
pub const LINE_WIDTH_BINS: usize = 8;

/// The power of `x` without its mean in each bin from 0 to n / 2. The window (Harris 1978, four terms,
/// doi:10.1109/PROC.1978.10837) makes a line eight bins wide without leakage, and weights the middle of `x` most.
pub fn power(x: &[f64]) -> Vec<f64> {
    weighted(x, harris(x.len()))
}

/// The same without a window: all samples have equal weight; at a distance of ten bins, a line may leak 1 % of its
/// power.
pub fn plain_power(x: &[f64]) -> Vec<f64> {
    weighted(x, |_| 1.0)
}

/// The spectrum with the window of [`power`], in bins from 0 to n / 2. In each bin, the mean square of white noise is
/// its variance.
pub fn spectrum(x: &[f64]) -> Vec<Complex<f64>> {
    let (bins, squares) = windowed(x, harris(x.len()));
    bins.into_iter().map(|c| c / squares.sqrt()).collect()
}

/// The amplitude of a sine in each bin from 0 to n / 2, with the window of [`power`].
pub fn amplitudes(x: &[f64]) -> Vec<f64> {
    let (bins, _) = windowed(x, harris(x.len()));
    let whole: f64 = (0..x.len()).map(harris(x.len())).sum();
    bins.iter().map(|c| 2.0 * modulus(*c) / whole).collect()
}

/// The power with a window, scaled so that the sum is the mean square.
fn weighted(x: &[f64], window: impl Fn(usize) -> f64) -> Vec<f64> {
    let n = x.len();
    let (bins, squares) = windowed(x, window);
    // Each bin also counts for its mirror image, except the first and, if n is even, the last.
    let scale = 1.0 / (n as f64 * squares);
    let sides = |k: usize| if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
    bins.iter().enumerate().map(|(k, c)| sides(k) * scale * c.norm_sqr()).collect()
}

/// The transform of `x` without its mean, with a window, in bins from 0 to n / 2; and the sum of squares of the window.
pub fn windowed(x: &[f64], window: impl Fn(usize) -> f64) -> (Vec<Complex<f64>>, f64) {
    let n = x.len();
    // The window is computed twice, not stored: a record may have ten million samples.
    let of_sample = |(total, sum, squares): (f64, f64, f64), (t, x): (usize, &f64)| {
        let w = window(t);
        (total + w, sum + x * w, squares + w * w)
    };
    let (total, sum, squares) = x.iter().enumerate().fold((0.0, 0.0, 0.0), of_sample);
    // The windowed mean: any other would give a line at 0 Hz.
    let mean = sum / total;
    let sample = |t: usize| (x[t] - mean) * window(t);
    if !n.is_multiple_of(2) {
        let mut bins: Vec<Complex<f64>> = (0..n).map(|t| Complex::from(sample(t))).collect();
        Transform::new(n).process(&mut bins);
        bins.truncate(n / 2 + 1);
        bins.shrink_to_fit();
        return (bins, squares);
    }
    let half = n / 2;
    let mut bins = packed(half, sample);
    Transform::new(half).process(&mut bins);
    for k in 0..half.div_ceil(2) {
        let (even, odd) = even_and_odd(bins[k], bins[(half - k) % half], twiddle(k, half));
        bins[k] = even + odd;
        match k {
            0 => bins.push((even - odd).conj()),
            _ => bins[half - k] = (even - odd).conj(),
        }
    }
    if half > 0 && half.is_multiple_of(2) {
        bins[half / 2] = bins[half / 2].conj();
    }
    (bins, squares)
}

/// Even and odd samples as the real and imaginary parts of a signal of half the length: its transform takes half of the
/// time and memory.
fn packed(half: usize, sample: impl Fn(usize) -> f64) -> Vec<Complex<f64>> {
    // One more bin follows.
    let mut packed = Vec::with_capacity(half + 1);
    packed.extend((0..half).map(|m| Complex::new(sample(2 * m), sample(2 * m + 1))));
    packed
}

/// exp(-pi i k / half).
fn twiddle(k: usize, half: usize) -> Complex<f64> {
    polar(1.0, -PI * k as f64 / half as f64)
}

/// From a bin k of a packed signal and its mirror image: the bin of the even samples, and that of the odd ones times
/// `twiddle`. The sum is that bin of the whole signal, and the conjugate of the difference is bin `half` - k.
fn even_and_odd(bin: Complex<f64>, mirror: Complex<f64>, twiddle: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let mirror = mirror.conj();
    ((bin + mirror) / 2.0, twiddle * (bin - mirror) * Complex::new(0.0, -0.5))
}

/// The window of four terms for `n` samples.
fn harris(n: usize) -> impl Fn(usize) -> f64 {
    move |t| {
        let angle = std::f64::consts::TAU * (t as f64 + 0.5) / n as f64;
        0.35875 - 0.48829 * cos(angle) + 0.14128 * cos(2.0 * angle) - 0.01168 * cos(3.0 * angle)
    }
}

/// The sums of x_t x_(t - p) over t, for each lag p from 0 to n / 2, of `n` samples x.
pub fn autocorrelation(n: usize, x: impl Fn(usize) -> f64) -> Vec<f64> {
    // At twice this length, no lag up to n / 2 meets its own image.
    let half = fast((n + n / 2).div_ceil(2) + 1);
    let mut bins = packed(half, |t| if t < n { x(t) } else { 0.0 });
    let fft = Transform::new(half);
    fft.process(&mut bins);
    // The powers at k and half a turn further: their mean and half their difference, packed in the same way, are the
    // spectrum of the products.
    let products = |k: usize, bin: Complex<f64>, mirror: Complex<f64>| -> Complex<f64> {
        let twiddle = twiddle(k, half);
        let (even, odd) = even_and_odd(bin, mirror, twiddle);
        let mean = even.norm_sqr() + odd.norm_sqr();
        twiddle.conj() * Complex::new(0.0, 2.0 * (even * odd.conj()).re) + mean
    };
    for k in 0..=half / 2 {
        let mirror = (half - k) % half;
        let (one, other) = (bins[k], bins[mirror]);
        // The forward transform of the conjugate is the conjugate of the inverse.
        bins[k] = products(k, one, other).conj();
        bins[mirror] = products(mirror, other, one).conj();
    }
    fft.process(&mut bins);
    let products = bins.iter().flat_map(|c| [c.re, -c.im]);
    products.take(n / 2 + 1).map(|sum| sum / half as f64).collect()
}

/// The smallest length from `n` on that is a power of two or three times one: its transform is fast.
fn fast(n: usize) -> usize {
    n.next_power_of_two().min(3 * n.div_ceil(3).next_power_of_two())
}

/// The sum of `cos(2 pi k t / n + phase)` over the harmonics k in `lines`, all below n, for t from 0 up to `n`.
pub fn cosines(lines: &[usize], phases: &[f64], fft: &Transform) -> Vec<Complex<f64>> {
    // The forward transform of conjugate lines: its real part is the sum of cosines.
    let mut signal = vec![Complex::ZERO; fft.len()];
    for (k, phase) in lines.iter().zip(phases) {
        signal[*k] = polar(1.0, -phase);
    }
    fft.process(&mut signal);
    signal
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn the_total_power_is_the_mean_square_and_a_line_has_its_width() {
        let x: Vec<f64> = (0..1000).map(|t| 7.0 + 3.0 * (TAU * 0.1234 * f64::from(t)).sin()).collect();
        let power = power(&x);
        assert_close(&[power.iter().sum()], &[4.5], 1e-3, 0.0);
        let line: f64 = power[123 - LINE_WIDTH_BINS / 2..=124 + LINE_WIDTH_BINS / 2].iter().sum();
        assert!(line > 0.9999 * 4.5, "{line}");
    }

    #[test]
    fn the_transform_of_half_the_length_equals_the_direct_sums() {
        for n in [1, 2, 4, 6, 9, 30, 62, 500] {
            let x: Vec<f64> = (0..n).map(|t| ((t * t) as f64).sin() + 0.3).collect();
            let mean = x.iter().sum::<f64>() / n as f64;
            let bin = |k: usize| {
                (0..n).map(|t| polar(x[t] - mean, -TAU * (k * t % n) as f64 / n as f64)).sum::<Complex<f64>>()
            };
            let (bins, squares) = windowed(&x, |_| 1.0);
            let parts = |bins: Vec<Complex<f64>>| bins.iter().flat_map(|c| [c.re, c.im]).collect::<Vec<_>>();
            assert_close(&parts(bins), &parts((0..=n / 2).map(bin).collect()), 0.0, 1e-11);
            assert_eq!(squares, n as f64);
        }
    }

    #[test]
    fn the_fast_autocorrelation_equals_the_direct_sums() {
        for n in [1, 2, 3, 7, 64, 501] {
            let x: Vec<f64> = (0..n).map(|t| ((t * t) as f64).sin() + 0.3).collect();
            let slow: Vec<f64> = (0..=n / 2).map(|p| x[p..].iter().zip(&x).map(|(a, b)| a * b).sum()).collect();
            assert_close(&autocorrelation(n, |t| x[t]), &slow, 0.0, 1e-12);
        }
    }

    #[test]
    fn the_fast_sum_of_cosines_equals_the_direct_sum() {
        for n in [2, 7, 64, 500] {
            let lines: Vec<usize> = (1..n).step_by(3).collect();
            let phases: Vec<f64> = lines.iter().map(|k| (k * k % 7) as f64).collect();
            let line = |t: usize, k: usize, phase: f64| (TAU * (k * t % n) as f64 / n as f64 + phase).cos();
            let slow: Vec<f64> =
                (0..n).map(|t| lines.iter().zip(&phases).map(|(k, phase)| line(t, *k, *phase)).sum()).collect();
            let fast: Vec<f64> = cosines(&lines, &phases, &Transform::new(n)).iter().map(|v| v.re).collect();
            assert_close(&fast, &slow, 0.0, 1e-11);
        }
    }
}
