//! Chirp: a sine of constant amplitude whose frequency sweeps from `f0` to `f1`.
//!
//! `u(t) = offset + amplitude sin(phi(t))` with, over the duration T,
//! linear `phi = 2 pi (f0 t + (f1 - f0) t^2 / (2 T))`: equal time in every hertz;
//! logarithmic `phi = 2 pi f0 T / ln(f1/f0) ((f1/f0)^(t/T) - 1)`: equal time in every octave, for wide bands.
//! Both start at the offset and rise. The amplitude is not faded in or out, so the spectrum ripples near the ends of
//! the band.
//!
//! Reference: Mueller and Massarani, Transfer-Function Measurement with Sweeps, J. Audio Eng. Soc. 49(6), 2001. The
//! values are those of `scipy.signal.chirp` with phi = -90.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, OptionKind, OptionRow, Options, options};
use libm::{expm1, log, sin};
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine of moving frequency.
    ///
    /// ```
    /// use piezoid::excitation::Chirp;
    /// let chirp = Chirp { frequency_start: 1.0, frequency_end: 400.0, logarithmic: true, ..Chirp::default() };
    /// assert_eq!(chirp.samples(5e-4, 20_000)?[0], 0.0);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Chirp {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency at the beginning.
        frequency_start: f64 = 1.0, FREQUENCY;
        /// Frequency at the end of the duration.
        frequency_end: f64 = 100.0, FREQUENCY;
        /// 0: linear sweep (equal time per hertz); 1: logarithmic sweep (equal time per octave).
        logarithmic: bool = false, OptionRow::new(OptionKind::Bit);
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl Chirp {
    /// `n` samples [V], every `ts` [s]; the sweep lasts for all of them.
    ///
    /// # Errors
    /// The amplitude must be positive, both frequencies positive and below half the sampling rate.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let f0 = drive.shows("frequency_start", self.frequency_start)?;
        let f1 = drive.shows("frequency_end", self.frequency_end)?;
        let duration = n as f64 * ts;
        let octaves = log(f1 / f0);
        let periods = |t: f64| match self.logarithmic {
            true if octaves != 0.0 => f0 * duration / octaves * expm1(octaves * t / duration),
            _ => f0 * t + (f1 - f0) * t * t / (2.0 * duration),
        };
        Ok((0..n).map(|t| drive.voltage(sin(TAU * periods(t as f64 * ts).fract()))).collect())
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "chirp",
    summary: "sine of sweeping frequency, linear or logarithmic",
    reference: "Mueller and Massarani, J. Audio Eng. Soc. 49(6), 2001",
    rows: Chirp::rows,
    generate: |arguments, ts, n| Chirp::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of upward zero crossings of `u`.
    fn crossings(u: &[f64]) -> usize {
        u.windows(2).filter(|w| w[0] < 0.0 && w[1] >= 0.0).count()
    }

    #[test]
    fn a_linear_chirp_is_at_its_mean_frequency_half_way_and_a_logarithmic_one_at_the_geometric_mean() {
        let linear =
            Chirp { amplitude: 30.0, frequency_start: 10.0, frequency_end: 250.0, logarithmic: false, offset: 0.0 };
        let log = Chirp { logarithmic: true, ..linear.clone() };
        for (chirp, middle) in [(linear, 130.0), (log, 50.0)] {
            let u = chirp.samples(5e-4, 40_000).unwrap();
            assert!(u[0] == 0.0 && u[1] > 0.0);
            let counted = crossings(&u[19_000..21_000]) as f64; // one second
            assert!((counted - middle).abs() <= 1.0, "{counted} Hz instead of {middle} Hz");
        }
    }

    #[test]
    fn a_sweep_from_a_frequency_to_itself_is_a_sine() {
        let sine = super::super::Sine { amplitude: 1.0, frequency: 20.0, offset: 0.0 }.samples(1e-3, 500).unwrap();
        for logarithmic in [false, true] {
            let chirp = Chirp { frequency_start: 20.0, frequency_end: 20.0, logarithmic, ..Chirp::default() };
            piezoid_testing::assert_close(&chirp.samples(1e-3, 500).unwrap(), &sine, 0.0, 1e-10);
        }
    }

    #[test]
    fn a_band_beyond_half_the_sampling_rate_is_refused() {
        let error = Chirp { frequency_end: 500.0, ..Chirp::default() }.samples(1e-3, 10).unwrap_err();
        assert!(error.to_string().starts_with("frequency_end = 500 Hz"), "{error}");
    }
}
