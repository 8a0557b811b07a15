//! Lags of the linear block that are creep, and poles that no actuator has.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "Slow real poles are creep".

use libm::exp;
use piezoid_models::creep::Lag;
use piezoid_models::linear::{Arx, Pole};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// Damping ratio above which a pair of poles is not a mode.
pub(crate) const MAX_MODE_DAMPING: f64 = 0.5;

/// Smallest damping ratio of the mode of an actuator.
pub(crate) const MIN_MODE_DAMPING: f64 = 2e-3;

/// The frequency below which a pole that does not ring counts as creep, which has its own block [Hz]; 0 without lags of
/// creep.
pub(crate) fn slowest_pole(lags: &[Lag]) -> f64 {
    lags.first().map_or(0.0, |lag| 1.0 / (TAU * lag.tau_s))
}

/// A pole of the block that counts as creep.
pub(crate) fn creep_pole(arx: &Arx, slowest: f64) -> Option<Pole> {
    let rings = |pole: &Pole| pole.damping < MAX_MODE_DAMPING || pole.z.re < 0.0;
    arx.poles().into_iter().find(|pole| !rings(pole) && pole.hz < slowest)
}

/// The frequency of a lag as long as the longest record [Hz]. A slower lag is a constant to the records, with
/// undetermined gain.
pub(crate) fn slowest_observable<'r>(records: impl Iterator<Item = &'r Record>) -> f64 {
    1.0 / (TAU * records.map(Record::duration).fold(f64::MIN_POSITIVE, f64::max))
}

/// The block with lags slower than `slowest` [Hz], and unstable ones, replaced by lags of that frequency, which changes
/// its static gain.
pub(crate) fn with_slow_lags_limited(arx: Arx, slowest: f64) -> Result<Arx, Error> {
    let ts = arx.ts();
    let p = exp(-TAU * slowest * ts);
    let mut denominator = arx.denominator();
    for pole in arx.poles().into_iter().filter(|pole| is_lag(pole) && pole.z.re > p) {
        let rest = without_factor(&denominator, pole.z.re);
        let shifted = std::iter::once(0.0).chain(rest.iter().map(|c| -p * c));
        denominator = rest.iter().chain(&[0.0]).zip(shifted).map(|(c, s)| c + s).collect();
    }
    Arx::new(ts, denominator[1..].iter().map(|a| -a).collect(), arx.b().to_vec())
}

/// True if every mode is damped. One that is not would be a sine of any size in each record.
pub(super) fn is_damped(arx: &Arx) -> bool {
    arx.poles().iter().all(|pole| pole.damping >= MIN_MODE_DAMPING)
}

pub(crate) fn is_lag(pole: &Pole) -> bool {
    pole.z.im == 0.0 && pole.z.re > 0.0
}

/// The polynomial c in q^-1 divided by its factor 1 - p q^-1.
pub(crate) fn without_factor(c: &[f64], p: f64) -> Vec<f64> {
    let mut last = 0.0;
    c[..c.len() - 1]
        .iter()
        .map(|c| {
            last = c + p * last;
            last
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;
    use piezoid_testing::assert_close;

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

    #[test]
    fn a_slow_pole_that_does_not_ring_is_creep() {
        assert!(creep_pole(&pair(1e-3, 0.2, 0.6), 16.0).is_some());
        assert!(creep_pole(&pair(1e-3, 0.2, 0.1), 16.0).is_none(), "it rings");
        assert!(creep_pole(&pair(1e-3, 40.0, 0.6), 16.0).is_none(), "it is fast");
        assert!(creep_pole(&Arx::new(1e-3, vec![0.999], vec![0.1]).unwrap(), 16.0).is_some());
    }
}
