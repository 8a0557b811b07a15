//! What would lower the error of a free run most, in one sentence.
//!
//! ```text
//! mse = mean^2 + drift^2 + gain^2 + input^2 + noise^2 + rest^2
//! ```
//! mean and drift are those of the error, gain is what another gain would remove, input what else is linear in the
//! input at one lag ([`Whiteness`]), and noise the [`Floor`]. The largest part decides, so the sentence begins where
//! most is to be gained. There is none if the error is near the noise, or far below what sensors resolve, whatever
//! tests of the residuals find: in a long record they find parts that are far too small to matter. A drift is named by
//! a remark.
//!
//! It does not do: parts that the record does not separate, such as creep and the drift of a sensor.

use super::{Floor, Metrics, Whiteness, extrapolation, facts::Shape, remarks::Comparison};
use crate::drift::Drift;
use crate::floor::rough;
use piezoid_numerics::number::round;

/// Error over noise up to which nothing is advised: what a better model could gain is then about the noise itself.
const NEAR_NOISE_RATIO: f64 = 1.5;

/// Error over peak-to-peak up to which nothing is advised [%]: few sensors are more linear.
const TINY_PERCENT: f64 = 0.2;

/// Correlation with the input that is significant in theory, but not worth a sentence.
const MIN_CORRELATION: f64 = 0.1;

/// What the advice is taken from.
pub(super) struct Residual<'a> {
    pub(super) metrics: &'a Metrics,
    pub(super) drift: &'a Drift,
    pub(super) shape: &'a Shape,
    pub(super) whiteness: Option<&'a Whiteness>,
    pub(super) floor: Option<&'a Floor>,
    /// `None` without a model.
    pub(super) comparison: Option<&'a Comparison<'a>>,
    /// Unit of the output.
    pub(super) unit: &'a str,
}

impl Residual<'_> {
    /// The sentence; `None` if nothing is worth doing, or a remark says it.
    pub(super) fn advice(&self) -> Option<String> {
        let Metrics { mse, peak_to_peak, n, .. } = *self.metrics;
        let tiny = 0.01 * TINY_PERCENT * peak_to_peak;
        // A constant is an error of every displacement, so the whole stroke counts, also for a small signal.
        let mean = Some(self.drift.mean.abs()).filter(|mean| *mean > tiny * self.stroke_ratio()).unwrap_or(0.0);
        let scatter = (mse - self.drift.mean.powi(2)).max(0.0);
        let rmse = (scatter + mean * mean).sqrt();
        let noise = self.floor.map_or(0.0, |floor| floor.rms);
        let is_noise = self.floor.is_none() && self.whiteness.is_some_and(|w| w.is_white() && input(w).is_none());
        let is_undefined = !rmse.is_finite() || peak_to_peak <= 0.0;
        if is_undefined || rmse <= tiny || rmse <= NEAR_NOISE_RATIO * noise || is_noise && mean == 0.0 {
            return None;
        }
        let drift = if self.drift.is_named { self.drift.rms } else { 0.0 };
        let scatter = (scatter - drift.powi(2)).max(0.0);
        let (factor, size) = self.shape.factor_and_size(n);
        let gain = Some(((factor - 1.0) * size).abs()).filter(|gain| gain.is_finite()).unwrap_or(0.0);
        let (correlation, lag) = self.whiteness.and_then(input).unwrap_or((0.0, 0));
        let follows = (correlation.powi(2) * scatter - gain.powi(2)).max(0.0).sqrt();
        let rest = (scatter - gain.powi(2) - follows.powi(2) - noise.powi(2)).max(0.0).sqrt();
        let largest = mean.max(drift).max(gain).max(follows).max(rest);
        let is_outside = self.comparison.is_some_and(extrapolation::is_outside);
        let size = format!("{} of the {} {} rms error", rough(largest), rough(rmse), self.unit);
        Some(match largest {
            // A remark speaks of it.
            x if x == drift => return None,
            x if x == mean => format!(
                "{size} is a constant: set the offset to free, if the zero of the sensor or of the voltage moves from \
                 record to record"
            ),
            _ if is_outside => format!(
                "{size} is on a record that leaves the training data (see the remarks): identify the model again with \
                 this record, or one like it"
            ),
            x if x == gain => format!(
                "{size} is a gain that is {} times that of the model: check scale and temperature of the sensor, or \
                 identify the model again with a record like this one",
                round(factor)
            ),
            x if x == follows && lag < 0 => format!(
                "{size} precedes the input by {} samples: check that the record was measured in open loop, and the \
                 delay of the model",
                -lag
            ),
            x if x == follows => format!(
                "{size} follows the input by {lag} samples: add a small-signal record (a PRBS or a multisine) to the \
                 training data, or allow a higher order"
            ),
            _ => format!(
                "{size} is neither noise nor linear in the input: identify the model again with a record like this one, \
                 if none was among the training data, or compare other operators"
            ),
        })
    }
}

impl Residual<'_> {
    /// The range of the training data over that of the record, at least 1.
    fn stroke_ratio(&self) -> f64 {
        let range = |u: [f64; 2]| u[1] - u[0];
        let ratio = self.comparison.and_then(Comparison::domains).map(|(known, here)| range(known.u) / range(here.u));
        ratio.filter(|ratio| ratio.is_finite()).map_or(1.0, |ratio| ratio.max(1.0))
    }
}

/// The correlation with the input that is largest, and its lag [samples], if it is significant and matters.
fn input(whiteness: &Whiteness) -> Option<(f64, isize)> {
    let found = whiteness.largest_correlation();
    (whiteness.correlates_with_input() && found.0.abs() > MIN_CORRELATION).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::Residual;
    use crate::drift::Drift;
    use crate::facts::Shape;
    use crate::{Floor, Metrics, Offset, Validate, ValidateOptions, Validation};
    use piezoid_models::hammerstein::{Domain, Model};
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_records::excitation::Prbs;
    use piezoid_records::record::Record;
    use piezoid_testing::noise;
    use std::sync::Arc;

    const TS: f64 = 5e-4;
    const N: usize = 8000;

    fn prbs() -> Vec<f64> {
        Prbs { order: 13, amplitude: 10.0, ..Prbs::default() }.samples(TS, N).unwrap()
    }

    fn sine() -> Vec<f64> {
        (0..N).map(|t| 10.0 * (0.0311 * t as f64).sin()).collect()
    }

    /// A gain of 10, validated on an output `y(t, u)` with white noise of 0.02.
    fn validated(u: Vec<f64>, identified: f64, y: impl Fn(usize, &[f64]) -> f64) -> Validation {
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let domain: Vec<f64> = u.iter().map(|u| identified * u).collect();
        let model = Model::new(gain, Arx::gain(TS, 10.0).unwrap(), 0.0).unwrap();
        let model = model.with_identified(Domain::of_input(&domain, TS));
        let y = noise(9, N).iter().enumerate().map(|(t, e)| y(t, &u) + 0.02 * e).collect();
        model.validate_with(&Record::new(TS, u, y).unwrap(), &ValidateOptions::default()).unwrap()
    }

    #[test]
    fn nothing_is_advised_near_the_noise_or_for_a_tiny_error_whatever_the_tests_find() {
        assert_eq!(validated(prbs(), 1.0, |t, u| 10.0 * u[t]).advice, None);
        // 0.1 % of the stroke follows the input, five times the noise: the tests of 8000 samples find it.
        let tiny = validated(prbs(), 1.0, |t, u| 10.0 * u[t] + 0.02 * u[t.saturating_sub(7)]);
        assert!(!tiny.whiteness.unwrap().verdict[1].contains("uncorrelated") && tiny.metrics.rms_pp_percent > 0.09);
        assert!(tiny.floor.unwrap().error_over_floor > 3.0, "{:?}", tiny.floor);
        assert_eq!(tiny.advice, None);
    }

    #[test]
    fn the_advice_begins_where_most_is_to_be_gained() {
        type Output = fn(usize, &[f64]) -> f64;
        let examples: [(Vec<f64>, f64, Output, &str); 7] = [
            (sine(), 1.0, |t, u| 10.0 * u[t] + 3.0, "is a constant: set the offset to free"),
            (sine(), 1.0, |t, u| 10.3 * u[t] + 0.1, "is a gain that is 1.03"),
            (prbs(), 1.0, |t, u| 10.0 * u[t] + 0.4 * u[t.saturating_sub(7)], "follows the input by 7 samples: add a"),
            (prbs(), 1.0, |t, u| 10.0 * u[t] + 0.4 * u[(t + 7).min(N - 1)], "precedes the input by 7 samples"),
            (sine(), 1.0, |t, u| 10.0 * u[t] + 0.02 * (u[t] * u[t] - 50.0), "is neither noise nor linear in the input"),
            (sine(), 0.5, |t, u| 10.0 * u[t] + 0.02 * (u[t] * u[t] - 50.0), "leaves the training data (see the"),
            (sine(), 0.5, |t, u| 10.0 * u[t] + 3.0, "is a constant: set the offset to free"),
        ];
        for (u, identified, y, says) in examples {
            let advice = validated(u, identified, y).advice.unwrap();
            assert!(advice.contains(says) && advice.contains(" um rms error "), "{says}: {advice}");
        }
    }

    #[test]
    fn a_constant_of_a_small_signal_is_compared_with_the_whole_stroke() {
        let small = |identified: f64| validated(prbs(), identified, |t, u| 10.0 * u[t] + 1.0).advice;
        assert!(small(1.0).unwrap().contains("is a constant") && small(10.0).is_none());
    }

    #[test]
    fn a_drift_is_left_to_its_remark_and_a_free_offset_is_no_advice() {
        let drifts = validated(prbs(), 1.0, |t, u| 10.0 * u[t] + 3e-4 * (t as f64 - 4000.0));
        assert!(drifts.remarks.iter().any(|r| r.contains("a drift of")) && drifts.advice.is_none(), "{drifts:?}");
        let record = Record::new(TS, sine(), sine().iter().map(|u| 10.0 * u + 3.0).collect()).unwrap();
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(gain, Arx::gain(TS, 10.0).unwrap(), 0.0).unwrap();
        let of = |offset| model.validate_with(&record, &ValidateOptions { offset, skip: 0.0 }).unwrap().advice;
        assert!(of(Offset::Kept).is_some() && of(Offset::Free).is_none());
    }

    /// The advice on a mean square, with a mean, a drift of this rms, a gain for a free run of this size, and noise.
    fn advised(mse: f64, (mean, drift): (f64, f64), is_named: bool, gain: (f64, f64), noise: f64) -> Option<String> {
        let metrics = Metrics { n: 4, mse, peak_to_peak: 100.0, ..Metrics::of(&[0.0, 1.0], &[0.0, 1.0]) };
        let simulated = [-gain.1, gain.1, -gain.1, gain.1];
        let floor = Floor {
            source: "spectrum",
            period: None,
            periods: None,
            hum_hz: None,
            rms: noise,
            rms_pp_percent: 0.0,
            nrmse_percent: 0.0,
            error_over_floor: 0.0,
            reducible_nrmse_percent: 0.0,
        };
        let residual = Residual {
            metrics: &metrics,
            drift: &Drift { mean, slope: 0.0, rms: drift, is_named },
            shape: &Shape::of(&simulated.map(|s| gain.0 * s), &simulated),
            whiteness: None,
            floor: Some(&floor),
            comparison: None,
            unit: "um",
        };
        residual.advice()
    }

    #[test]
    fn the_largest_part_of_the_error_is_named_if_it_is_neither_tiny_nor_noise() {
        let (still, same) = ((0.0, 0.0), (1.0, 10.0));
        // A fifth of a percent of 100, and three halves of the noise.
        for nothing in [
            advised(0.199f64.powi(2), still, false, same, 0.01),
            advised(1.0, still, false, same, 0.67),
            advised(1.0, (0.0, 0.75), true, same, 0.01),
            advised(f64::INFINITY, still, false, same, 0.01),
        ] {
            assert_eq!(nothing, None);
        }
        for (advice, says) in [
            (advised(0.201f64.powi(2), still, false, same, 0.01), "0.2 of the 0.2 um rms error is neither"),
            (advised(1.0, still, false, same, 0.66), "0.75 of the 1 um rms error is neither"),
            (advised(1.0, (0.0, 0.75), false, same, 0.01), "1 of the 1 um rms error is neither"),
            (advised(1.0, (0.6, 0.0), false, same, 0.01), "0.8 of the 1 um rms error is neither"),
            (advised(1.0, (-0.6, 0.0), false, same, 0.6), "0.6 of the 1 um rms error is a constant"),
            // A constant of less than a fifth of a percent of the stroke does not count.
            (advised(1.0, (0.15, 0.0), false, same, 0.01), "0.99 of the 0.99 um rms error is neither"),
            (advised(1.0, (0.25, 0.0), false, same, 0.01), "0.97 of the 1 um rms error is neither"),
            (advised(1.0, still, false, (1.05, 16.0), 0.01), "0.8 of the 1 um rms error is a gain that is 1.05 times"),
            (advised(1.0, still, false, (0.95, 16.0), 0.01), "0.8 of the 1 um rms error is a gain that is 0.95 times"),
            (advised(1.0, still, false, (1.05, 13.0), 0.01), "0.76 of the 1 um rms error is neither"),
        ] {
            let advice = advice.unwrap();
            assert!(advice.starts_with(says), "{says}: {advice}");
        }
    }
}
