//! Triangle: straight ramps between `offset - amplitude` and `offset + amplitude`.
//!
//! The slope is constant, `|du/dt| = 4 amplitude frequency` [V/s]. The load therefore draws a constant current, and a
//! rate-dependent loop is measured at a single rate. It starts at the offset and rises. Its harmonics are odd and fall
//! with the square of their number; near the resonance they ring.
//!
//! Reference: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012,
//! DOI 10.1002/9781118287422.

use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, options};
use super::{Excitation, PINTELON_SCHOUKENS};
use piezoid_numerics::error::Error;

options! {
    /// Ramps up and down, starting upwards from the offset.
    ///
    /// ```
    /// use piezoid::excitation::Triangle;
    /// let u = Triangle { amplitude: 2.0, frequency: 1.0, offset: 0.0 }.samples(0.125, 8)?;
    /// assert_eq!(u, [0.0, 1.0, 2.0, 1.0, 0.0, -1.0, -2.0, -1.0]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Triangle {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl Triangle {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        Ok(drive.periodic(frequency, n, triangle))
    }
}

/// Rises from 0 to 1, falls to -1 and returns to 0 while `passed` goes from 0 to 1.
fn triangle(passed: f64) -> f64 {
    if passed < 0.25 {
        4.0 * passed
    } else if passed < 0.75 {
        2.0 - 4.0 * passed
    } else {
        4.0 * passed - 4.0
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "triangle",
    summary: "triangle wave: a loop at constant rate of the input",
    reference: PINTELON_SCHOUKENS,
    rows: Triangle::rows,
    generate: |arguments, ts, n| Triangle::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_of_a_triangle_is_equally_high() {
        let u = Triangle { amplitude: 30.0, frequency: 5.0, offset: -1.0 }.samples(5e-4, 801).unwrap();
        assert!(u[0] == -1.0 && u[1] > u[0]);
        let steps: Vec<f64> = u.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        piezoid_testing::assert_close(&steps, &[4.0 * 30.0 * 5.0 * 5e-4; 800], 0.0, 1e-9);
    }
}
