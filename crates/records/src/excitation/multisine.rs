//! Multisine: equal cosines at multiples of one base frequency, with phases that keep the peak low.
//!
//! `u(t) = offset + amplitude s(t) / max |s|`, with `s(t) = sum over k of cos(2 pi k t / N + phi_k)`. The period has N
//! = round(period / ts) samples, and the harmonics k are those with `frequency_low <= k / (N ts) <= frequency_high`:
//! the band is narrowed to the grid of the period, so whole periods have no leakage. With `odd`, only odd k are used:
//! even harmonics of the output then come from the actuator's nonlinearity. The phases start as Schroeder's (seed 0) or
//! at random (each other seed gives another realisation), and are improved by clipping (see `crest.rs`). The peak is
//! that of the samples.
//!
//! Reference: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012,
//! DOI 10.1002/9781118287422; Schroeder, DOI 10.1109/TIT.1970.1054411.

use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, OptionKind, OptionRow, Options, count, options};
use super::{Excitation, PINTELON_SCHOUKENS, crest};
use piezoid_numerics::error::Error;
use piezoid_numerics::fourier;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

options! {
    /// A periodic sum of cosines with a flat spectrum inside its band and nothing outside.
    ///
    /// ```
    /// use piezoid::excitation::Multisine;
    /// let multisine = Multisine { frequency_low: 1.0, frequency_high: 400.0, period: 1.0, ..Multisine::default() };
    /// let u = multisine.samples(5e-4, 4000)?;
    /// assert_eq!(u[..2000], u[2000..]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Multisine {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Lower end of the band, above 0.
        frequency_low: f64 = 1.0, FREQUENCY;
        /// Upper end of the band, below half the sampling rate.
        frequency_high: f64 = 100.0, FREQUENCY;
        /// Period of the signal; 0 means the whole duration.
        period: f64 = 0.0, OptionRow::not_negative("s");
        /// 1: odd harmonics only, so that nonlinearity shows at the even ones; 0: all.
        odd: bool = false, OptionRow::new(OptionKind::Bit);
        /// Phases of the sines: 0 gives Schroeder's phases, any other seed random phases.
        seed: u32 = 0, count(0);
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

/// Maximum number of samples per period: lowering the peak takes eight times as many complex numbers.
const LONGEST: usize = 4_000_000;

impl Multisine {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive. The band must be positive, below half the sampling rate, and contain a harmonic
    /// of the period. The period must not be negative.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let samples = self.period_samples(ts, n)?;
        let lines = self.harmonics(&drive, samples, ts)?;
        let phases = crest::lowered(&lines, self.start(lines.len()));
        let shape = fourier::cosines(&lines, &phases, &fourier::Transform::new(samples));
        let peak = shape.iter().fold(0.0, |peak: f64, s| peak.max(s.re.abs()));
        Ok((0..n).map(|t| drive.voltage(shape[t % samples].re / peak)).collect())
    }

    /// Samples per period.
    fn period_samples(&self, ts: f64, n: usize) -> Result<usize, Error> {
        let samples = if self.period == 0.0 { n as f64 } else { (self.period / ts).round() };
        if (2.0..=LONGEST as f64).contains(&samples) {
            return Ok(samples as usize);
        }
        let rule = format!("must have from 2 to {LONGEST} samples, not {samples}, at ts = {ts} s; 0 is the duration");
        Err(Error::parameter("period", format!("{} s", self.period), rule))
    }

    /// The harmonics in the band, ascending, of a period of `samples` every `ts` [s].
    fn harmonics(&self, drive: &Drive, samples: usize, ts: f64) -> Result<Vec<usize>, Error> {
        const ROUNDING: f64 = 1e-9; // 10 Hz x 0.1 s is harmonic 1 however the product rounds
        let low = drive.shows("frequency_low", self.frequency_low)?;
        let high = drive.shows("frequency_high", self.frequency_high)?;
        let period = samples as f64 * ts;
        let first = (low * period * (1.0 - ROUNDING)).ceil() as usize;
        let last = (high * period * (1.0 + ROUNDING)).floor() as usize;
        let lines: Vec<usize> = (first..=last).filter(|k| 2 * k < samples && (!self.odd || k % 2 == 1)).collect();
        if lines.is_empty() {
            let which = if self.odd { "odd multiple" } else { "multiple" };
            let base = 1.0 / period;
            let rule = format!(
                "no {which} of {base} Hz lies between frequency_low = {low} Hz and this frequency; it must be above \
                 frequency_low: widen the band or lengthen the period"
            );
            return Err(Error::parameter("frequency_high", format!("{high} Hz"), rule));
        }
        Ok(lines)
    }

    /// The initial phases [rad].
    fn start(&self, count: usize) -> Vec<f64> {
        if self.seed == 0 {
            return crest::schroeder(count);
        }
        let mut random = ChaCha8Rng::seed_from_u64(u64::from(self.seed));
        (0..count).map(|_| TAU * random.random::<f64>()).collect()
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "multisine",
    summary: "sines of equal amplitude over a band, with a low crest factor: no leakage, for frequency responses",
    reference: PINTELON_SCHOUKENS,
    rows: Multisine::rows,
    generate: |arguments, ts, n| Multisine::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// Amplitude of harmonic `k` of one period.
    fn amplitude(u: &[f64], k: usize) -> f64 {
        let n = u.len();
        let turn = |t: usize| (TAU * ((k * t) % n) as f64 / n as f64).sin_cos();
        let (s, c) = (0..n).fold((0.0, 0.0), |(s, c), t| (s + u[t] * turn(t).0, c + u[t] * turn(t).1));
        2.0 * f64::hypot(s, c) / n as f64
    }

    #[test]
    fn the_spectrum_is_flat_in_the_band_and_empty_outside() {
        for odd in [false, true] {
            let multisine = Multisine { frequency_low: 20.0, frequency_high: 60.0, odd, ..Multisine::default() };
            let u = multisine.samples(1e-3, 500).unwrap(); // harmonics of 2 Hz
            let inside = |k: usize| (10..=30).contains(&k) && !(odd && k.is_multiple_of(2));
            let level = amplitude(&u, 11);
            let expected: Vec<f64> = (1..250).map(|k| if inside(k) { level } else { 0.0 }).collect();
            let found: Vec<f64> = (1..250).map(|k| amplitude(&u, k)).collect();
            assert_close(&found, &expected, 0.0, 1e-12);
        }
    }

    #[test]
    fn the_amplitude_is_the_peak_and_the_rms_comes_close_to_it() {
        for (seed, crest) in [(0, 1.5), (1, 1.55), (2, 1.55)] {
            let multisine = Multisine { amplitude: 30.0, frequency_high: 400.0, seed, ..Multisine::default() };
            let u = multisine.samples(5e-4, 4000).unwrap();
            let peak = u.iter().fold(0.0, |peak: f64, v| peak.max(v.abs()));
            let rms = (u.iter().map(|v| v * v).sum::<f64>() / 4000.0).sqrt();
            assert_eq!(peak, 30.0);
            assert!(peak / rms < crest, "seed {seed}: crest factor {}", peak / rms);
        }
    }

    #[test]
    fn each_seed_is_another_realisation() {
        let realisation = |seed| Multisine { seed, ..Multisine::default() }.samples(1e-3, 1000).unwrap();
        assert_eq!(realisation(1), realisation(1));
        assert_ne!(realisation(1), realisation(2));
        assert_ne!(realisation(1), realisation(0));
    }

    #[test]
    fn a_band_without_a_harmonic_is_refused() {
        let narrow = Multisine { frequency_low: 1.1, frequency_high: 1.9, ..Multisine::default() };
        assert!(narrow.samples(1e-3, 1000).unwrap_err().to_string().contains("no multiple of 1 Hz"));
        let even = Multisine { frequency_low: 2.0, frequency_high: 2.0, odd: true, ..Multisine::default() };
        assert!(even.samples(1e-3, 1000).unwrap_err().to_string().contains("no odd multiple"));
        assert!(Multisine { frequency_high: 500.0, ..Multisine::default() }.samples(1e-3, 1000).is_err());
        assert!(Multisine { period: -1.0, ..Multisine::default() }.samples(1e-3, 1000).is_err());
        assert!(Multisine { period: 1e-9, ..Multisine::default() }.samples(1e-3, 1000).is_err());
    }
}
