//! Sine: `u(t) = offset + amplitude sin(2 pi frequency t)`.
//!
//! The signal of the paper's loops (section 2.3). It starts at the offset and rises. One sine has one frequency and
//! cannot identify the five parameters of the ARX block; use [`Prbs`](super::Prbs) or [`Multisine`](super::Multisine)
//! for this.
//!
//! Reference: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012,
//! DOI 10.1002/9781118287422.

use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, options};
use super::{Excitation, PINTELON_SCHOUKENS};
use libm::sin;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine that starts at the offset and rises.
    ///
    /// ```
    /// use piezoid::excitation::Sine;
    /// let u = Sine { amplitude: 30.0, frequency: 5.0, ..Sine::default() }.samples(5e-4, 400)?;
    /// assert_eq!((u[0], u[100]), (0.0, 30.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Sine {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl Sine {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        Ok(drive.periodic(frequency, n, |passed| sin(TAU * passed)))
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "sine",
    summary: "sine: the same hysteresis loop repeatedly",
    reference: PINTELON_SCHOUKENS,
    rows: Sine::rows,
    generate: |arguments, ts, n| Sine::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_starts_at_the_offset_rises_and_repeats() {
        let u = Sine { amplitude: 30.0, frequency: 5.0, offset: 2.0 }.samples(5e-4, 801).unwrap();
        assert!(u[0] == 2.0 && u[1] > u[0]);
        assert_eq!((u[100], u[300]), (32.0, -28.0));
        piezoid_testing::assert_close(&u[400..], &u[..401], 0.0, 1e-9);
    }

    #[test]
    fn a_sine_that_the_samples_cannot_show_is_refused() {
        assert!(Sine { frequency: 1000.0, ..Sine::default() }.samples(5e-4, 10).is_err());
        assert!(Sine { amplitude: -1.0, ..Sine::default() }.samples(5e-4, 10).is_err());
    }
}
