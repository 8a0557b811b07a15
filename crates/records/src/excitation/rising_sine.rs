//! Rising sine: loops that grow from zero to the full amplitude.
//!
//! `u(t) = offset + amplitude g(t) sin(2 pi frequency t)`, where `g(t) = min(1, t / (T - 1/frequency))` and T is the
//! whole duration. The amplitude grows linearly and is reached one period before the end, so the last loop is the
//! complete major loop. No two earlier reversals are at the same voltage, and each loop wipes out the one before.
//! Together they exercise the first-order reversal curves, which determine a Preisach model. More periods mean a finer
//! growth, which resolves the density more finely.
//!
//! Reference: Mayergoyz, Mathematical Models of Hysteresis, Physical Review Letters 56(15), 1986,
//! DOI 10.1103/PhysRevLett.56.1518.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, options};
use libm::sin;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine whose amplitude grows linearly, with one last period at full amplitude.
    ///
    /// ```
    /// use piezoid::excitation::RisingSine;
    /// let u = RisingSine { amplitude: 30.0, frequency: 5.0, offset: 0.0 }.samples(5e-4, 8000)?;
    /// assert!(u[..400].iter().all(|v| v.abs() < 2.0));
    /// assert_eq!(u.iter().fold(0.0, |peak: f64, v| peak.max(*v)), 30.0);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct RisingSine {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl RisingSine {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate, and the duration at
    /// least two periods: one for the growth, and the last one.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        let period = 1.0 / (frequency * ts);
        if (n as f64) < 2.0 * period - 0.5 {
            let remedy = format!("two periods of {frequency} Hz; lengthen the duration or raise the frequency");
            let need = (2.0 * period).round() as usize;
            return Err(Error::TooShort { what: "a rising sine".into(), have: n, need, remedy });
        }
        let rise = n as f64 - period;
        let growth = |t: usize| (t as f64 / rise).min(1.0);
        Ok((0..n).map(|t| drive.voltage(growth(t) * sin(TAU * drive.passed(frequency, t)))).collect())
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "rising-sine",
    summary: "sine of growing amplitude: a family of loops that exercises the first-order reversal curves",
    reference: "Mayergoyz, Phys. Rev. Lett. 56(15), 1986, DOI 10.1103/PhysRevLett.56.1518",
    rows: RisingSine::rows,
    generate: |arguments, ts, n| RisingSine::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_loop_contains_the_one_before_and_the_last_is_complete() {
        let u = RisingSine { amplitude: 30.0, frequency: 5.0, offset: 1.0 }.samples(5e-4, 4000).unwrap();
        assert!(u[0] == 1.0 && u[2] > u[1] && u[1] > u[0]);
        let ends: Vec<(f64, f64)> = u
            .chunks(400)
            .map(|period| period.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v))))
            .collect();
        assert!(ends.windows(2).all(|w| w[1].0 < w[0].0 && w[1].1 > w[0].1), "{ends:?}");
        assert_eq!(ends[9], (-29.0, 31.0));
    }

    #[test]
    fn a_duration_without_room_to_rise_is_refused() {
        let sine = RisingSine { frequency: 5.0, ..RisingSine::default() };
        assert!(sine.samples(5e-4, 800).is_ok());
        assert!(sine.samples(5e-4, 799).unwrap_err().to_string().contains("at least 800 are needed"));
    }
}
