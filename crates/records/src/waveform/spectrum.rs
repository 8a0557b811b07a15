//! The amplitude spectrum of a signal, for figures.

use piezoid_numerics::fourier::amplitudes;

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
    fn a_few_samples_have_no_spectrum() {
        assert_eq!(spectrum(&[1.0, 2.0, 3.0], 1.0), (Vec::new(), Vec::new()));
    }
}
