//! The input delay [s], not only in whole samples.
//!
//! It is the tau in G(s) = exp(-tau s) (feed-through + modes) of the best free run with the fewest modes that explain
//! the records. Lags too fast to be distinguished from a delay, such as an amplifier's or a sensor filter's, count as
//! delay. An output logged just before its input acts has no delay from sampling; an output logged after it has a delay
//! of -Ts.
//!
//! To check it, compare it with the delay from the phase of a difference equation at low frequency
//! ([`ModalForm::delay`](super::ModalForm)). If the two differ, the assumed modes are wrong.

use super::fit_modes::ModalFit;
use super::output_error::Refinement;
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_records::record::Record;

/// Maximum number of modes tried.
const MAX_MODES: usize = 4;

/// One more mode is accepted if it lowers the rms of the free run by this share.
const MIN_RMS_DECREASE: f64 = 0.2;

impl ModalFit {
    /// The fit with the fewest modes that explain `records`: its `delay` is their input delay, searched between -1 and
    /// `longest` samples.
    ///
    /// ```
    /// use piezoid::{Record, excitation::Prbs, linear::{ModalFit, Refinement}, plant::Plant, progress::Stage};
    /// let plant = Plant::named("pl140", 5e-4)?;
    /// let u = Prbs::default().samples(5e-4, 2047)?;
    /// let record = Record::new(5e-4, u.clone(), plant.run(&u).y)?;
    /// let found = ModalFit::of_fewest_modes(&[record], 2, &Refinement::default(), &mut Stage::ignore)?;
    /// // Its amplifier has a lag of 0.1 ms, a fifth of a sample.
    /// assert!((found.delay.value - 1e-4).abs() < 2e-6 && found.modes.len() == 2);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`ModalFit::fit`].
    pub fn of_fewest_modes(
        records: &[Record],
        longest: usize,
        settings: &Refinement,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let mut modes = ModalFit::fit(records, 1, longest, settings, progress)?;
        for n in 2..=MAX_MODES {
            match ModalFit::fit(records, n, longest, settings, progress) {
                Ok(more) if more.minimum.cost.sqrt() < (1.0 - MIN_RMS_DECREASE) * modes.minimum.cost.sqrt() => {
                    modes = more
                }
                Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
                _ => break,
            }
        }
        Ok(modes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::modal_error::tests::held;
    use crate::linear::{Orders, OutputError, Uncertain};
    use piezoid_numerics::progress::Stage;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 5e-4;

    #[test]
    fn a_delay_of_whole_or_fractional_samples_is_found_within_its_uncertainty() {
        for (seed, delay) in [(1, -TS), (2, 0.0), (3, 1.7e-4), (4, TS), (5, 1.35e-3)] {
            let truth = held(&[(166.3, 0.03, 27.0)], 3.0, delay);
            let u = Prbs::default().samples(TS, 2047).unwrap();
            let y = truth.simulate(&u).iter().zip(noise(seed, 2047)).map(|(y, e)| y + 0.3 * e).collect();
            let record = [Record::new(TS, u, y).unwrap()];
            let settings = Refinement::default();
            let found = ModalFit::of_fewest_modes(&record, 3, &settings, &mut Stage::ignore).unwrap();
            let Uncertain { value, error } = found.delay;
            assert_close(&[value], &[delay], 0.0, 4.0 * error);
            assert!(error < 2e-6 && found.modes.len() == 1, "{error}");
            // The phase does not distinguish feed-through from a mode: one sample on its share.
            let orders = Orders { delay: found.arx.delay(), ..Orders::of(2) };
            let by_phase =
                OutputError::fit(&record, orders, &settings, &mut Stage::ignore).unwrap().arx.modal_form().delay;
            assert_close(&[by_phase], &[delay], 0.0, 6e-5);
        }
    }
}
