//! Linear blocks from the hidden variable to the output, as the start of the joint fit, and separation of their creep.
//!
//! ```text
//! G = r q^-d / (1 - p q^-1) + rest,    p slower than the fastest lag of the ladder
//! ```
//! The ladder of creep has such poles itself; two in series cannot be distinguished.

use super::JointOptions;
use crate::creep::Lag;
use crate::error::Error;
use crate::linear::{Arx, Orders, OutputError, Pole, Refinement};
use crate::progress::Stage;
use crate::record::Record;
use crate::system::System;
use std::f64::consts::TAU;

/// Increase of the sum of squares up to which a longer delay is accepted.
pub(super) const SAME_COST: f64 = 1.01;

/// The frequency below which a real pole counts as creep, which has its own block [Hz].
pub(super) fn slowest_pole(settings: &JointOptions, lags: &[Lag]) -> f64 {
    lags.first().filter(|_| settings.creep).map_or(0.0, |lag| 1.0 / (TAU * lag.tau_s))
}

/// A pole of the block that counts as creep.
pub(super) fn creep_pole(arx: &Arx, slowest: f64) -> Option<Pole> {
    arx.poles().into_iter().find(|pole| is_lag(pole) && pole.hz < slowest)
}

/// The frequency of a lag as long as the longest record [Hz]. A slower lag is a constant to the records, with
/// undetermined gain.
pub(super) fn slowest_observable<'r>(records: impl Iterator<Item = &'r Record>) -> f64 {
    1.0 / (TAU * records.map(Record::duration).fold(f64::MIN_POSITIVE, f64::max))
}

/// The block with lags slower than `slowest` [Hz] replaced by lags of that frequency, which changes its static gain.
pub(super) fn with_slow_lags_limited(arx: Arx, slowest: f64) -> Result<Arx, Error> {
    let ts = arx.ts();
    let mut denominator = arx.denominator();
    for pole in arx.poles().into_iter().filter(|pole| is_lag(pole) && pole.hz < slowest) {
        let rest = without_factor(&denominator, pole.z.re);
        let p = (-TAU * slowest * ts).exp();
        let shifted = std::iter::once(0.0).chain(rest.iter().map(|c| -p * c));
        denominator = rest.iter().chain(&[0.0]).zip(shifted).map(|(c, s)| c + s).collect();
    }
    Arx::new(ts, denominator[1..].iter().map(|a| -a).collect(), arx.b().to_vec())
}

/// Smallest damping of the mode of an actuator.
const LEAST_DAMPING: f64 = 2e-3;

/// True if every mode is damped. One that is not would be a sine of any size in each record.
pub(super) fn is_damped(arx: &Arx) -> bool {
    arx.poles().iter().all(|pole| pole.damping >= LEAST_DAMPING)
}

pub(super) fn is_lag(pole: &Pole) -> bool {
    pole.z.im == 0.0 && pole.z.re > 0.0
}

/// A linear block from z to y, and its squared error.
pub(super) struct Dynamics {
    pub(super) arx: Arx,
    pub(super) cost: f64,
}

impl Dynamics {
    /// The block without its creep poles: G less r q^-d / (1 - p q^-1) for each. `None` if only a gain remains.
    pub(super) fn without_creep(mut self, slowest: f64) -> Result<Option<Self>, Error> {
        while let Some(pole) = creep_pole(&self.arx, slowest) {
            if self.arx.a().len() == 1 {
                return Ok(None);
            }
            let (p, delay) = (pole.z.re, self.arx.delay());
            let rest = without_factor(&self.arx.denominator(), p);
            let at = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum / p + c);
            let mut b = self.arx.b()[delay..].to_vec();
            let r = at(&b) / at(&rest);
            b.resize(b.len().max(rest.len()), 0.0);
            b.iter_mut().zip(&rest).for_each(|(b, a)| *b -= r * a);
            let b = [vec![0.0; delay], without_factor(&b, p)].concat();
            self.arx = Arx::new(self.arx.ts(), rest[1..].iter().map(|a| -a).collect(), b)?;
        }
        Ok(Some(self).filter(|rest| rest.arx.dc_gain() != 0.0))
    }
}

/// The polynomial c in q^-1 divided by its factor 1 - p q^-1.
pub(super) fn without_factor(c: &[f64], p: f64) -> Vec<f64> {
    let mut last = 0.0;
    c[..c.len() - 1]
        .iter()
        .map(|c| {
            last = c + p * last;
            last
        })
        .collect()
}

/// The block of order `n` from z to y with a static gain of the sign of `gain`, and the longest accepted delay up to
/// `latest`.
///
/// # Errors
/// Returns an error if no delay gives a gain of that sign.
pub(super) fn dynamics(hidden: &[Record], n: usize, latest: usize, gain: f64) -> Result<Dynamics, Error> {
    let mut delays = vec![latest, latest / 2, 0];
    delays.dedup();
    let of = |delay: usize| {
        let found =
            OutputError::fit(hidden, Orders { delay, ..Orders::of(n) }, &Refinement::default(), &mut Stage::ignore)?;
        if found.arx.dc_gain() * gain > 0.0 {
            return Ok(Dynamics { arx: found.arx, cost: found.minimum.cost });
        }
        let because = "the sign of its static gain differs from that of the records: choose another order, or add a \
                       small-signal PRBS record"
            .into();
        Err(Error::Unidentifiable { what: format!("a linear block of order {n}"), because })
    };
    let (found, refused): (Vec<_>, Vec<_>) = delays.into_iter().map(of).partition(Result::is_ok);
    let found: Vec<_> = found.into_iter().flatten().collect();
    let least = found.iter().map(|one| one.cost).fold(f64::INFINITY, f64::min);
    match found.into_iter().find(|one| one.cost <= SAME_COST * least) {
        Some(one) => Ok(one),
        None => Err(refused.into_iter().find_map(Result::err).unwrap_or(Error::Content("no delay was tried".into()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn without_its_creep_a_block_is_its_fast_part() {
        // Delayed by two samples: a resonance, and a lag of 2 s with a tenth of its gain.
        let fast = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 0.0, 3.4, 3.3]).unwrap();
        let p = (-5e-4f64 / 2.0).exp();
        let slow = Arx::new(5e-4, vec![p], vec![0.0, 0.0, 0.1 * fast.dc_gain() * (1.0 - p)]).unwrap();
        let a = vec![1.7424 + p, -0.9453 - 1.7424 * p, 0.9453 * p];
        let [first, second] = [3.4, 3.3];
        let r = slow.b()[2];
        let b = vec![0.0, 0.0, first + r, second - first * p - 1.7424 * r, -second * p + 0.9453 * r];
        let both = Arx::new(5e-4, a, b).unwrap();
        let impulse: Vec<f64> = (0..200).map(|t| f64::from(u8::from(t == 0))).collect();
        let sum: Vec<f64> = fast.simulate(&impulse).iter().zip(slow.simulate(&impulse)).map(|(q, s)| q + s).collect();
        assert_close(&both.simulate(&impulse), &sum, 1e-9, 1e-9);

        let rest = Dynamics { arx: both, cost: 0.0 }.without_creep(3.0).unwrap().unwrap().arx;
        assert_eq!((rest.a().len(), rest.delay()), (2, 2));
        assert_close(&rest.simulate(&impulse), &fast.simulate(&impulse), 1e-6, 1e-6);
    }

    #[test]
    fn a_block_of_creep_alone_is_removed_and_one_without_creep_stays() {
        let lag = Arx::new(5e-4, vec![0.9999], vec![1.0]).unwrap();
        assert!(Dynamics { arx: lag.clone(), cost: 0.0 }.without_creep(3.0).unwrap().is_none());
        assert_eq!(Dynamics { arx: lag.clone(), cost: 0.0 }.without_creep(0.001).unwrap().unwrap().arx, lag);
    }

    #[test]
    fn lags_slower_than_the_records_are_limited_and_everything_else_stays() {
        let p = |hz: f64| (-TAU * hz * 5e-4).exp();
        let block = |p: f64| {
            let a = vec![1.7424 + p, -0.9453 - 1.7424 * p, 0.9453 * p];
            Arx::new(5e-4, a, vec![0.0, 3.4, 3.3]).unwrap()
        };
        assert_close(with_slow_lags_limited(block(p(0.01)), 0.5).unwrap().a(), block(p(0.5)).a(), 1e-9, 0.0);
        assert_eq!(with_slow_lags_limited(block(p(1.0)), 0.5).unwrap().b(), block(p(1.0)).b());
        assert_eq!(with_slow_lags_limited(block(p(1.0)), 0.5).unwrap().a(), block(p(1.0)).a());
    }
}
