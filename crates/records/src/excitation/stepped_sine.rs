//! Stepped sine: a sine held for equal times, a form of the paper's "periodic step-wise" test signal.
//!
//! `u = offset + amplitude sin(2 pi k / steps) / max_j sin(2 pi j / steps)` during the k-th part of the period. All
//! steps are held equally long, as far as whole samples allow. This shows if a model treats a held input as a falling
//! one. The paper states neither the form nor the number of steps; 7 per period come nearest to its Table 1 (the study
//! shows all from 4 to 40). If a step would be shorter than a sample, steps are left out. A
//! [`Staircase`](super::Staircase) has steps of equal height instead.
//!
//! Reference: Kuklisova Pavelkova, Estimation of Rate-Dependent Hammerstein Model of Piezo Bender Actuator, ICINCO
//! 2025, section 3.
//!
//! Why: docs/decisions/study-of-the-paper.md, "The study tests on a stepped sine of 7 steps".

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, FREQUENCY, OFFSET, Options, count, options};
use libm::sin;
use piezoid_numerics::error::Error;
use std::f64::consts::TAU;

options! {
    /// A sine in steps of equal length. The highest step reaches the amplitude, whatever their number: the input runs
    /// between the same ends as a sine of that amplitude.
    ///
    /// ```
    /// use piezoid::excitation::SteppedSine;
    /// let u = SteppedSine { amplitude: 2.0, frequency: 1.0, steps: 4, offset: 0.0 }.samples(0.125, 8)?;
    /// assert_eq!((u[0], u[2], u[3], u[6], u[7]), (0.0, 2.0, 2.0, -2.0, -2.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct SteppedSine {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Frequency, below half the sampling rate.
        frequency: f64 = 1.0, FREQUENCY;
        /// Steps per period, at least 3.
        steps: u32 = 7, count(3);
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl SteppedSine {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the frequency positive and below half the sampling rate, the steps at least 3.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        const ROUNDING: f64 = 1e-9; // sample 20 of 400 begins step 1 of 20 however the quotient rounds
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        let frequency = drive.shows("frequency", self.frequency)?;
        // Both of two steps would lie where the sine is zero.
        if self.steps < 3 {
            return Err(Error::parameter("steps", self.steps, "must be at least 3"));
        }
        let steps = f64::from(self.steps);
        let step = |k: f64| sin(TAU * k / steps);
        let quarter = (0.25 * steps).floor();
        let highest = step(quarter).max(step(quarter + 1.0));
        Ok(drive.periodic(frequency, n, |passed| step((passed * steps + ROUNDING).floor()) / highest))
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "stepped-sine",
    summary: "sine in steps of equal length: a form of the paper's periodic step-wise test signal",
    reference: "Kuklisova Pavelkova, ICINCO 2025, section 3",
    rows: SteppedSine::rows,
    generate: |arguments, ts, n| SteppedSine::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_equally_long_and_on_the_sine() {
        let u = SteppedSine { amplitude: 30.0, frequency: 5.0, steps: 20, offset: 0.0 }.samples(5e-4, 400).unwrap();
        for (k, step) in u.chunks(20).enumerate() {
            assert!(step.iter().all(|v| *v == step[0]), "step {k}");
            piezoid_testing::assert_close(&step[..1], &[30.0 * (TAU * k as f64 / 20.0).sin()], 0.0, 1e-12);
        }
    }

    #[test]
    fn the_highest_and_the_lowest_step_reach_the_amplitude_whatever_their_number() {
        for steps in 3..=41 {
            let u = SteppedSine { amplitude: 30.0, steps, ..SteppedSine::default() }.samples(1e-3, 1000).unwrap();
            let (low, high) = piezoid_numerics::series::ends(u.iter().copied());
            piezoid_testing::assert_close(&[low, high], &[-30.0, 30.0], 1e-12, 0.0);
        }
    }

    #[test]
    fn two_steps_are_refused_since_both_would_be_zero() {
        assert!(SteppedSine { steps: 2, ..SteppedSine::default() }.samples(1e-3, 10).is_err());
    }

    #[test]
    fn steps_shorter_than_a_sample_leave_the_sine() {
        let stepped = SteppedSine { frequency: 250.0, steps: 8, ..SteppedSine::default() }.samples(5e-4, 80).unwrap();
        let sine = super::super::Sine { frequency: 250.0, ..Default::default() }.samples(5e-4, 80).unwrap();
        piezoid_testing::assert_close(&stepped, &sine, 0.0, 1e-9);
    }
}
