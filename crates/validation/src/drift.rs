//! The linear trend of the error of a record: a drift of its sensor or of its temperature, which is not the model's.

use piezoid_numerics::series::{dot, mean, range};

/// Share of the rms error about its mean, and of all of it, from which a drift is named.
const NAMED: [f64; 2] = [0.5, 0.25];

/// A drift goes on: over the whole record and over either half of it, the slope that the free run does not explain lies
/// between these shares of the slope of the line. Creep that the model lacks slows down more.
const STEADY_SLOPE_RATIO: std::ops::RangeInclusive<f64> = 0.6..=1.6;

/// Fastest drift that is named, over the peak-to-peak of the free run [1 / s]. Sensors and temperatures drift more
/// slowly.
const MAX_DRIFT_RATE: f64 = 0.01;

/// The straight line through the error of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drift {
    /// Mean error.
    pub mean: f64,
    /// Slope per sample.
    pub(super) slope: f64,
    /// Rms of the line about its mean.
    pub(super) rms: f64,
    /// True if the line makes much of the error, in both halves of the record.
    pub(super) is_named: bool,
}

impl Drift {
    /// Of the errors of a free run, with sampling period `ts` [s].
    pub(crate) fn of(errors: &[f64], simulated: &[f64], ts: f64) -> Self {
        let n = errors.len() as f64;
        let time: Vec<f64> = (0..errors.len()).map(|t| t as f64 - 0.5 * (n - 1.0)).collect();
        let slope = dot(&time, errors) / dot(&time, &time).max(1.0);
        let rms = slope.abs() * ((n * n - 1.0) / 12.0).sqrt();
        let (mean, square) = (mean(errors), dot(errors, errors) / n);
        let large = rms > NAMED[0] * (square - mean * mean).max(0.0).sqrt() && rms > NAMED[1] * square.sqrt();
        let is_slow = slope.abs() < MAX_DRIFT_RATE * range(simulated) * ts;
        let middle = errors.len() / 2;
        let goes_on = || {
            [0..errors.len(), 0..middle, middle..errors.len()].into_iter().all(|part| {
                let own = beside(&time[part.clone()], &simulated[part.clone()], &errors[part]);
                STEADY_SLOPE_RATIO.contains(&(own / slope))
            })
        };
        Drift { mean, slope, rms, is_named: large && is_slow && goes_on() }
    }
}

/// The coefficient of `t` in the regression of `e` on a constant, `t` and `s`. A slow input under a wrong gain looks
/// like a drift.
fn beside(t: &[f64], s: &[f64], e: &[f64]) -> f64 {
    let product = |a: &[f64], b: &[f64]| dot(a, b) - a.len() as f64 * mean(a) * mean(b);
    let (tt, ts, ss) = (product(t, t), product(t, s), product(s, s));
    let (te, se) = (product(t, e), product(s, e));
    let determinant = tt * ss - ts * ts;
    // Without a response, the error alone has the slope.
    if determinant > 1e-9 * tt * ss { (te * ss - ts * se) / determinant } else { te / tt }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 1e-3;
    const N: usize = 4000;

    fn of(error: impl Fn(f64) -> f64, run: impl Fn(f64) -> f64) -> Drift {
        let errors: Vec<f64> = noise(1, N).iter().enumerate().map(|(t, e)| error(t as f64 * TS) + 0.002 * e).collect();
        Drift::of(&errors, &(0..N).map(|t| run(t as f64 * TS)).collect::<Vec<_>>(), TS)
    }

    fn sine(t: f64) -> f64 {
        10.0 * (18.0 * t).sin()
    }

    #[test]
    fn the_line_through_an_error_is_found_and_named_if_it_makes_half_of_it() {
        let drift = of(|t| 0.5 + 0.04 * t, sine);
        assert_close(&[drift.slope / TS, drift.rms], &[0.04, 0.04 * 4.0 / 12f64.sqrt()], 0.01, 0.0);
        assert_close(&[drift.mean], &[0.58], 0.01, 0.0);
        assert!(!drift.is_named, "the offset is larger");
        assert!(of(|t| 0.04 * (t - 2.0), sine).is_named);
        assert!(!of(|t| 0.04 * (t - 2.0) + 0.02 * sine(t), sine).is_named, "the error of the gain is larger");
    }

    #[test]
    fn a_wrong_gain_missing_creep_and_what_is_too_fast_for_a_sensor_are_not_named_drift() {
        let scan = |t: f64| 10.0 * t + sine(t);
        assert!(!of(|t| 0.01 * (scan(t) - 20.0), scan).is_named, "the gain of a slow scan");
        assert!(!of(|t| 0.1 * ((t + 0.05).ln() - 0.4), sine).is_named, "creep");
        assert!(!of(|t| 0.3 * (t - 2.0), sine).is_named, "1.5 % of stroke per second");
    }
}
