//! The input delay [s], not only in whole samples.
//!
//! It is the tau in G(s) = exp(-tau s) (feed-through + modes) of the best free run with the fewest modes that explain
//! the records. Lags too fast to be distinguished from a delay, such as an amplifier's or a sensor filter's, count as
//! delay. An output logged just before its input acts has no delay from sampling; an output logged after it has a delay
//! of -Ts.
//!
//! For comparison, the delay is also computed from the phase of a difference equation at low frequency (`modes.rs`). If
//! the two differ, the assumed modes are wrong.

use super::fit_modes::ModalFit;
use super::output_error::{OutputError, Refinement};
use super::regression::Orders;
use super::uncertainty::Uncertain;
use crate::error::Error;
use crate::progress::Progress;
use crate::record::Record;

/// A delay with its standard error.
#[derive(Debug, Clone, PartialEq)]
pub struct Delay {
    /// tau [s]; the standard error accounts for noise only.
    pub seconds: Uncertain,
    /// The delay from the phase at low frequency [s].
    pub by_phase: f64,
    /// The modes of the same fit.
    pub modes: ModalFit,
}

/// Maximum number of modes tried.
const MOST: usize = 4;

/// One more mode is accepted if it lowers the rms of the free run by this share.
const WORTH: f64 = 0.2;

impl Delay {
    /// The input delay of `records`, searched between -1 and `longest` samples.
    ///
    /// ```
    /// use piezoid::{Record, linear::{Delay, Refinement}, plant::{Plant, Preset}, excitation::Prbs};
    /// let plant = Plant::named("pl140", 5e-4)?;
    /// let u = Prbs::default().samples(5e-4, 2047)?;
    /// let record = Record::new(5e-4, u.clone(), plant.run(&u).y.iter().map(|y| 1e6 * y).collect())?;
    /// let delay = Delay::find(&[record], 2, &Refinement::default(), &mut piezoid::progress::silent)?;
    /// // Its amplifier has a lag of 0.1 ms, a fifth of a sample.
    /// assert!((delay.seconds.value - 1e-4).abs() < 2e-6 && delay.modes.modes.len() == 2);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`ModalFit::fit`].
    pub fn find(
        records: &[Record],
        longest: usize,
        settings: &Refinement,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let mut modes = ModalFit::fit(records, 1, longest, settings, progress)?;
        for n in 2..=MOST {
            match ModalFit::fit(records, n, longest, settings, progress) {
                Ok(more) if more.minimum.cost.sqrt() < (1.0 - WORTH) * modes.minimum.cost.sqrt() => modes = more,
                Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
                _ => break,
            }
        }
        let orders = Orders { delay: modes.arx.delay(), ..Orders::of(2 * modes.modes.len()) };
        let by_phase = OutputError::fit(records, orders, settings, progress)?.arx.reading().delay;
        Ok(Delay { seconds: modes.delay, by_phase, modes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Prbs;
    use crate::linear::modal_error::tests::held;
    use crate::progress::silent;
    use crate::system::System;
    use crate::testing::{assert_close, noise};

    const TS: f64 = 5e-4;

    #[test]
    fn a_delay_of_whole_or_fractional_samples_is_found_within_its_uncertainty() {
        for (seed, delay) in [(1, -TS), (2, 0.0), (3, 1.7e-4), (4, TS), (5, 1.35e-3)] {
            let truth = held(&[(166.3, 0.03, 27.0)], 3.0, delay);
            let u = Prbs::default().samples(TS, 2047).unwrap();
            let y = truth.simulate(&u).iter().zip(noise(seed, 2047)).map(|(y, e)| y + 0.3 * e).collect();
            let record = [Record::new(TS, u, y).unwrap()];
            let found = Delay::find(&record, 3, &Refinement::default(), &mut silent).unwrap();
            let Uncertain { value, error } = found.seconds;
            assert_close(&[value], &[delay], 0.0, 4.0 * error);
            assert!(error < 2e-6 && found.modes.modes.len() == 1, "{error}");
            // The phase does not distinguish feed-through from a mode: one sample on its share.
            assert_close(&[found.by_phase], &[delay], 0.0, 6e-5);
        }
    }
}
