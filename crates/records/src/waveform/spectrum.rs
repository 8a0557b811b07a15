//! The amplitude spectrum of a signal, for figures.

use libm::pow;
use piezoid_numerics::fourier::amplitudes;
use piezoid_numerics::series::largest;

/// Frequencies [Hz] above 0, and the amplitudes there, in the unit of `x`, without its mean; `ts` is the sampling
/// period [s]. Half a bin beside the frequency of a sine, the amplitude is 9 % lower (Harris 1978). Empty for fewer
/// than four samples.
pub fn spectrum(x: &[f64], ts: f64) -> (Vec<f64>, Vec<f64>) {
    if x.len() < 4 {
        return (Vec::new(), Vec::new());
    }
    let amplitude = amplitudes(x).split_off(1);
    let hz = (1..=amplitude.len()).map(|k| k as f64 / (x.len() as f64 * ts)).collect();
    (hz, amplitude)
}

/// A spectrum in at most so many points for a logarithmic axis: in each of its bands of frequencies the largest
/// amplitude, at its frequency, and in `others` the largest amplitudes there.
pub fn thinned(hz: &[f64], amplitude: &[f64], others: &[&[f64]], most: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = hz.len();
    // The lines of low frequency stay single until a band holds more than one.
    let single = single_lines(n, most);
    let bands = most.saturating_sub(single).max(1);
    let limit = |k: usize| match n <= most {
        true => k,
        false if k <= single => k,
        false => (single as f64 * pow(n as f64 / single as f64, (k - single) as f64 / bands as f64)) as usize,
    };
    let count = if n <= most { n } else { single + bands };
    let mut found = (Vec::with_capacity(count), vec![Vec::with_capacity(count); 1 + others.len()]);
    for k in 0..count {
        let band = limit(k).min(n)..if k + 1 == count { n } else { limit(k + 1).min(n) };
        let Some(top) = band.clone().max_by(|p, q| amplitude[*p].total_cmp(&amplitude[*q])) else { continue };
        found.0.push(hz[top]);
        found.1[0].push(amplitude[top]);
        for (thin, other) in found.1[1..].iter_mut().zip(others) {
            thin.push(largest(&other[band.clone()]));
        }
    }
    found
}

/// The number of first lines that are as far apart as the bands after them, for `n` lines in `most` points.
fn single_lines(n: usize, most: usize) -> usize {
    let is_apart = |single: &usize| {
        let ratio = pow(n as f64 / *single as f64, 1.0 / (most - single) as f64);
        *single as f64 * (ratio - 1.0) >= 1.0
    };
    (1..most).find(is_apart).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine of 2.5 about 40, `cycles` in 1000 samples.
    fn sine(cycles: f64) -> Vec<f64> {
        (0..1000).map(|t| 40.0 + 2.5 * (TAU * cycles * f64::from(t) / 1000.0).sin()).collect()
    }

    #[test]
    fn a_sine_has_its_amplitude_at_its_frequency_whatever_its_mean() {
        let (hz, amplitude) = spectrum(&sine(64.0), 1e-3);
        assert_eq!((hz.len(), hz[0], hz[499]), (500, 1.0, 500.0));
        assert!((amplitude[63] - 2.5).abs() < 1e-9, "{}", amplitude[63]);
        let far = amplitude.iter().enumerate().filter(|(k, _)| k.abs_diff(63) > 4);
        assert!(far.into_iter().all(|(_, a)| *a < 1e-3));
        let (_, beside) = spectrum(&sine(64.5), 1e-3);
        assert!((beside[63] / 2.5 - 0.91).abs() < 0.01, "{}", beside[63]);
    }

    #[test]
    fn the_amplitudes_are_those_of_the_plain_sums() {
        let x: Vec<f64> = (0..37).map(|t| f64::from(t * t % 23)).collect();
        let angle = |k: usize, t: f64| TAU * k as f64 * t / 37.0;
        let weight = |t: f64| {
            let at = |m: usize| angle(m, t + 0.5).cos();
            0.35875 - 0.48829 * at(1) + 0.14128 * at(2) - 0.01168 * at(3)
        };
        let sum = |of: &dyn Fn(f64) -> f64| (0..37).map(|t| of(f64::from(t)) * weight(f64::from(t))).sum::<f64>();
        let whole = sum(&|_| 1.0);
        let mean = sum(&|t| x[t as usize]) / whole;
        let (_, amplitude) = spectrum(&x, 1.0);
        for k in 1..=18 {
            let part = |turn: fn(f64) -> f64| sum(&|t| (x[t as usize] - mean) * turn(angle(k, t)));
            let plain = 2.0 * part(f64::cos).hypot(part(f64::sin)) / whole;
            assert!((amplitude[k - 1] - plain).abs() < 1e-12 * 23.0, "{k}: {} {plain}", amplitude[k - 1]);
        }
    }

    #[test]
    fn a_thinned_spectrum_keeps_its_lines_and_the_low_frequencies() {
        let n = 100_000;
        let lines = [3, 70, 5000, 99_998];
        let x: Vec<f64> = (0..2 * n)
            .map(|t| lines.iter().map(|k| (TAU * *k as f64 * t as f64 / (2 * n) as f64).sin()).sum())
            .collect();
        let (hz, amplitude) = spectrum(&x, 1.0);
        let (thin, amplitudes) = thinned(&hz, &amplitude, &[&amplitude, &hz], 500);
        assert!(thin.len() <= 500 && thin.is_sorted() && amplitudes.iter().all(|a| a.len() == thin.len()));
        assert_eq!(thin[..40], hz[..40]);
        for k in lines {
            let at = thin.iter().position(|f| *f == hz[k - 1]).unwrap();
            assert!((amplitudes[0][at] - 1.0).abs() < 1e-9 && amplitudes[1][at] == amplitudes[0][at]);
        }
        assert_eq!(amplitudes[2].last(), hz.last());
        assert_eq!(thinned(&hz[..500], &amplitude[..500], &[], 500), (hz[..500].into(), vec![amplitude[..500].into()]));
        assert_eq!(thinned(&[], &[], &[], 500), (Vec::new(), vec![Vec::new()]));
    }

    #[test]
    fn a_few_samples_have_no_spectrum() {
        assert_eq!(spectrum(&[1.0, 2.0, 3.0], 1.0), (Vec::new(), Vec::new()));
    }
}
