//! Decaying sine: demagnetisation, loops that shrink to zero.
//!
//! `u(t) = offset + amplitude (1 - t / T) sin(2 pi frequency t)`, where T is the whole duration. Each loop is smaller
//! than the one before by the same voltage, so no reversal is left that later ones do not wipe out: the hysteresis ends
//! in the middle of its loop, whatever was before. Its remanence is that of the last step, half of amplitude / periods.
//!
//! Reference: Mayergoyz, Mathematical Models of Hysteresis, Springer, 1991, DOI 10.1007/978-1-4612-3028-1 (the
//! demagnetised state). It does not do: creep, which goes on after it.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, options};
use libm::sin;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine whose amplitude decays linearly to zero.
    ///
    /// ```
    /// use piezoid_records::excitation::DecayingSine;
    /// let u = DecayingSine { amplitude: 30.0, frequency: 10.0, offset: 5.0 }.samples(5e-4, 4001)?;
    /// assert_eq!((u[0], u[4000]), (5.0, 5.0));
    /// assert!(u.iter().all(|v| (v - 5.0).abs() < 30.0) && u[3800..].iter().all(|v| (v - 5.0).abs() < 1.5));
    /// # Ok::<(), piezoid_numerics::error::Error>(())
    /// ```
    pub struct DecayingSine {
        /// Amplitude at the start: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

/// Fewest periods: the steps are then at most a fifth of the amplitude.
const FEWEST: f64 = 5.0;

impl DecayingSine {
    /// `n` samples [V], every `ts` [s]; the last one is the offset.
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate, and the duration at
    /// least five periods.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        let period = 1.0 / (frequency * ts);
        if (n as f64) < FEWEST * period - 0.5 {
            let remedy = format!("{FEWEST} periods of {frequency} Hz; lengthen the duration or raise the frequency");
            let need = (FEWEST * period).round() as usize;
            return Err(Error::TooShort { what: "a decaying sine".into(), have: n, need, remedy });
        }
        let left = |t: usize| 1.0 - t as f64 / (n - 1) as f64;
        Ok((0..n).map(|t| drive.voltage(left(t) * sin(TAU * drive.passed(frequency, t)))).collect())
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "decaying-sine",
    summary: "sine of falling amplitude: demagnetisation, to the middle of the loop",
    reference: "Mayergoyz, Mathematical Models of Hysteresis, 1991, DOI 10.1007/978-1-4612-3028-1",
    rows: DecayingSine::rows,
    generate: |arguments, ts, n| DecayingSine::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_loop_lies_within_the_one_before() {
        let u = DecayingSine { amplitude: 30.0, frequency: 5.0, offset: 1.0 }.samples(5e-4, 4001).unwrap();
        let ends: Vec<(f64, f64)> = u[..4000]
            .chunks(400)
            .map(|period| period.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v))))
            .collect();
        assert!(ends.windows(2).all(|w| w[1].0 > w[0].0 && w[1].1 < w[0].1), "{ends:?}");
        assert!(ends[0].1 > 29.0 && ends[9].1 - ends[9].0 < 6.0 && u[4000] == 1.0, "{ends:?}");
    }

    #[test]
    fn a_duration_with_few_periods_is_refused() {
        let sine = DecayingSine { frequency: 5.0, ..DecayingSine::default() };
        assert!(sine.samples(5e-4, 2000).is_ok());
        assert!(sine.samples(5e-4, 1999).unwrap_err().to_string().contains("at least 2000 are needed"));
    }
}
