//! Power of the input in a band: whether a resonance there can be identified.

use piezoid_numerics::fourier::power;

/// A band with less than this share of the input's power counts as not excited.
const MIN_POWER_SHARE: f64 = 1e-4;

/// The band of half an octave on both sides of a frequency [Hz], which shows a resonance there.
pub fn around(hz: f64) -> (f64, f64) {
    (hz / 2f64.sqrt(), hz * 2f64.sqrt())
}

/// True if an input, with sampling period `ts` [s], has significant power in a band [Hz].
pub fn excites(u: &[f64], ts: f64, band: (f64, f64)) -> bool {
    share(u, ts, band) > MIN_POWER_SHARE
}

/// The share of the input's power in a band [Hz]; 0 for a constant input.
fn share(u: &[f64], ts: f64, (low, high): (f64, f64)) -> f64 {
    let spectrum = power(u);
    let bin = 1.0 / (u.len() as f64 * ts);
    let within = (1..spectrum.len()).filter(|k| (low..=high).contains(&(*k as f64 * bin)));
    let (band, all) = (within.map(|k| spectrum[k]).sum::<f64>(), spectrum.iter().skip(1).sum::<f64>());
    if all > 0.0 { band / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_sine_does_not_excite_a_band_that_a_prbs_excites() {
        let ts = 5e-4;
        let sine: Vec<f64> =
            (0..4000).map(|t| 28.0 * (std::f64::consts::TAU * 7.0 * f64::from(t) * ts).sin()).collect();
        let prbs = crate::excitation::Prbs::default().samples(ts, 4094).unwrap();
        assert!(!excites(&sine, ts, (100.0, 200.0)) && excites(&prbs, ts, (100.0, 200.0)));
        assert!(excites(&sine, ts, around(7.0)) && !excites(&[2.0; 100], ts, around(7.0)));
    }
}
