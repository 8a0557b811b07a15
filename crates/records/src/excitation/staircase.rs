//! Staircase: a sine rounded to evenly spaced levels.
//!
//! `u = offset + amplitude (2 l / (levels - 1) - 1)`, where `l` is the level from 0 to `levels - 1` nearest to `sin(2
//! pi frequency t)`. The level is held between jumps. This shows if a model treats a held input as a falling one. With
//! an odd number of levels, one is at the offset; with an even number, the staircase starts at the next level above. If
//! the sine is half way between two levels, the upper one is taken. A [`SteppedSine`](super::SteppedSine) has steps of
//! equal length instead.
//!
//! Reference: Kuklisova Pavelkova, Estimation of Rate-Dependent Hammerstein Model of Piezo Bender Actuator, ICINCO
//! 2025, section 3: a step-wise test signal, of unstated form.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, count, options};
use libm::sin;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine in steps.
    ///
    /// ```
    /// use piezoid::excitation::Staircase;
    /// let u = Staircase { amplitude: 2.0, frequency: 1.0, levels: 5, offset: 0.0 }.samples(0.05, 8)?;
    /// assert_eq!(u, [0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Staircase {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Number of evenly spaced levels, at least 2.
        levels: u32 = 20, count(2);
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl Staircase {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate, the levels at least 2.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        if self.levels < 2 {
            return Err(Error::parameter("levels", self.levels, "must be at least 2"));
        }
        let jumps = f64::from(self.levels - 1);
        Ok(drive.periodic(frequency, n, |passed| nearest(sin(TAU * passed), jumps)))
    }
}

/// The level nearest to `s`, of those that divide -1 to 1 into equal `jumps`. If two levels are equally near, the upper
/// one is taken, even if the sine is slightly below because of rounding.
fn nearest(s: f64, jumps: f64) -> f64 {
    const ROUNDING: f64 = 1e-9;
    let level = (0.5 * (s + 1.0) * jumps + 0.5 + ROUNDING).floor();
    2.0 * level / jumps - 1.0
}

pub(super) const ROW: Excitation = Excitation {
    name: "staircase",
    summary: "sine in steps of equal height: shows whether a model treats a held input as a falling one",
    reference: "Kuklisova Pavelkova, ICINCO 2025, section 3",
    rows: Staircase::rows,
    generate: |arguments, ts, n| Staircase::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_staircase_visits_every_level_and_no_other() {
        let staircase = Staircase { amplitude: 19.0, frequency: 5.0, levels: 20, offset: 0.0 };
        let u = staircase.samples(5e-4, 400).unwrap();
        let mut levels: Vec<i64> = u.iter().map(|v| v.round() as i64).collect();
        assert!(u.iter().zip(&levels).all(|(v, l)| (v - *l as f64).abs() < 1e-12));
        levels.sort_unstable();
        levels.dedup();
        assert_eq!(levels, (-19..=19).step_by(2).collect::<Vec<i64>>());
    }

    #[test]
    fn a_staircase_starts_next_to_the_offset_and_climbs_to_the_top() {
        for levels in [2, 5, 20, 21] {
            let u = Staircase { levels, ..Staircase::default() }.samples(1e-3, 1000).unwrap();
            assert!((0.0..=1.0 / f64::from(levels - 1) + 1e-12).contains(&u[0]), "{levels}: {}", u[0]);
            assert!(u[..250].windows(2).all(|w| w[1] >= w[0]) && u[250] == 1.0, "{levels}");
            assert!(u[250..750].windows(2).all(|w| w[1] <= w[0]) && u[750] == -1.0, "{levels}");
        }
    }

    #[test]
    fn every_period_is_the_same_however_the_sine_rounds() {
        let u = Staircase { frequency: 5.0, ..Staircase::default() }.samples(5e-4, 40_000).unwrap();
        assert!(u.chunks(400).all(|period| period == &u[..400]));
    }

    #[test]
    fn one_level_is_no_staircase() {
        assert!(Staircase { levels: 1, ..Staircase::default() }.samples(1e-3, 10).is_err());
    }
}
