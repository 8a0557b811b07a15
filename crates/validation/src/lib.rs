//! Validation: free run on data that was not used for identification, never one step ahead.
//!
//! The model uses only the input, which does not determine what happened before the record. A simulation starts at
//! rest, but a measured actuator has moved before. Of five initial conditions (settled at the first input, at rest,
//! after cycles over the whole range that ended with a rise or with a fall, in motion as in the record) the free run
//! uses the most likely one for its input, unless another has a clearly smaller error in the first tenth of the record;
//! the result states which. The first `skip` seconds are left out of the figures. Further results: errors by frequency
//! and amplitude ([`Bin`]), loops of record and model ([`LoopComparison`]), residual tests ([`Whiteness`]), the noise
//! floor ([`Floor`]), the drift of the error, remarks on extrapolation, and what the record does not test.
//! [`Linearity`] tests whether a record is linear, without a model.
//!
//! Reference: Ljung 1998, System Identification: Theory for the User, chapter 16.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod advice;
mod best_block;
mod bins;
mod drift;
mod extrapolation;
mod facts;
mod floor;
mod initial_condition;
#[cfg(test)]
mod kept;
mod long;
mod loops;
mod metrics;
mod remarks;
mod residual_noise;
mod small_signal;
mod undriven;
mod untested;
mod whiteness;

pub use bins::{Bin, Source};
pub use extrapolation::inner_reversals;
pub use floor::Floor;
pub use floor::{rough, summary};
pub use loops::{LoopComparison, LoopShape};
pub use metrics::Metrics;
pub use small_signal::Linearity;
pub use whiteness::Whiteness;

use self::drift::Drift;
use self::facts::{Facts, Shape, inner_reversals_of};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::series::mean;
use piezoid_numerics::system::System;
use piezoid_records::record::{Record, Units};
use piezoid_records::waveform::{cycles, period};
use serde::{Deserialize, Serialize};

/// Treatment of the mean error and the drift of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Offset {
    /// Both are kept: the offset is the model's own.
    #[default]
    Kept,
    /// The mean error is subtracted first, because sensors drift.
    Free,
    /// A constant and a line are subtracted first.
    Drift,
}

const OFFSETS: OptionKind = OptionKind::Choice(&[
    ("kept", "the model's own"),
    ("free", "estimated for each record, because sensors drift"),
    ("drift", "a constant and a linear drift are estimated for each record"),
]);

options! {
    /// Options of the comparison of a model with a record.
    #[derive(Copy)]
    pub struct ValidateOptions {
        /// Time at the start of each record that the error figures leave out.
        skip: f64 = 0.0, OptionRow::not_negative("s");
        /// Offset of the model.
        offset: Offset = Offset::Kept, OptionRow::new(OFFSETS);
    }
}

/// A free run compared with its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Error figures of the record from sample `start` on.
    pub metrics: Metrics,
    /// The free run over the whole record, with the removed mean error and drift added [record's unit]; empty for a
    /// record that is too long to be held.
    pub simulated: Vec<f64>,
    /// First sample that the error figures include.
    pub start: usize,
    /// Initial condition of the free run.
    pub initial_condition: InitialCondition,
    /// What was subtracted from the errors first.
    pub offset: Offset,
    /// The subtracted mean error; `None` if the offset is kept [record's unit].
    pub offset_removed: Option<f64>,
    /// Mean of y less that of the free run, once this is removed [record's unit].
    pub mean_error: f64,
    /// Slope of the error over time, in the figures or removed from them [record's unit / s].
    pub drift_per_s: f64,
    /// 100 rms error without this drift / standard deviation of y.
    pub nrmse_without_drift_percent: f64,
    /// Rms of the drift in the figures, if it is steady and makes much of the error [record's unit].
    pub named_drift: Option<f64>,
    /// The error by frequency: of cycles if the input oscillates, otherwise of spectra.
    pub by_frequency: Vec<Bin>,
    /// The error by amplitude of the cycles; empty if the input does not oscillate.
    pub by_amplitude: Vec<Bin>,
    /// The loops; empty if the input does not oscillate.
    pub loops: Vec<LoopComparison>,
    /// Tests of the residuals; `None` if there are none, or the record is too short.
    pub whiteness: Option<Whiteness>,
    /// The noise floor; `None` if neither periods of the input nor the spectrum show it.
    pub floor: Option<Floor>,
    /// The error in one sentence: noise, drift, and what a better model could gain; `None` if y is constant.
    pub summary: Option<String>,
    /// What would lower the error most, in one sentence; `None` if the error is near the noise or tiny, or a remark
    /// says it.
    pub advice: Option<String>,
    /// Remarks on the figures.
    pub remarks: Vec<String>,
    /// Properties of the model that this record does not test.
    pub not_covered: Vec<String>,
}

/// Comparison of a model with records, by its free run.
pub trait Validate {
    /// Compares the free run of this model with a validation record, with the model's offset.
    ///
    /// # Errors
    /// The errors of [`Model::validate_with`].
    fn validate(&self, record: &Record) -> Result<Validation, Error> {
        self.validate_with(record, &ValidateOptions::default())
    }

    /// Compares the free run of this model with `record`.
    ///
    /// # Errors
    /// Returns an error if the sampling period of the record is no multiple of that of the model, the units cannot be
    /// converted, or the record is shorter than `skip`.
    fn validate_with(&self, record: &Record, options: &ValidateOptions) -> Result<Validation, Error> {
        self.validate_end(record, record.len(), options)
    }

    /// The same if the outputs from sample `from` on are held out: the initial condition follows from those before.
    ///
    /// # Errors
    /// The same.
    fn validate_end(&self, record: &Record, from: usize, options: &ValidateOptions) -> Result<Validation, Error>;
}

impl Validate for Model {
    fn validate_end(&self, record: &Record, from: usize, options: &ValidateOptions) -> Result<Validation, Error> {
        let whole = record.at("the model", self.ts())?;
        let every = whole.every() / record.every();
        let k = factor(self, whole.ts(), record.units())?;
        let free = options.offset != Offset::Kept;
        let (mut simulated, initial_condition) = initial_condition::free_run_from(self, &whole, from * every, k, free);
        if every > 1 {
            simulated = simulated.into_iter().step_by(every).collect();
        }
        Validation::compared(Some(self), record, (simulated, initial_condition), options)
    }
}

/// The factor from the output unit of a model to that of a record with these units and this sampling period [s].
fn factor(model: &Model, ts: f64, units: &Units) -> Result<f64, Error> {
    Record::same_sampling("the model", model.ts(), "the record", ts)?;
    output_factor(model.units(), units)
}

/// The factor from the output unit `own` of a model to that of a record with these `units`.
///
/// # Errors
/// Returns an error if the inputs have different units, or the outputs units that cannot be converted.
pub fn output_factor(own: &Units, units: &Units) -> Result<f64, Error> {
    if units.u != own.u {
        return Err(Error::units("the input of the record", &units.u, &own.u));
    }
    Units::factor(&own.y, &units.y).ok_or_else(|| Error::units("the output of the record", &units.y, &own.y))
}

/// An error if a free run has a sample that is not finite.
///
/// # Errors
/// Returns an error with the first such sample.
pub fn require_finite(simulated: &[f64]) -> Result<(), Error> {
    let diverges = |t: usize| format!("the free run is {} at sample {t}: it diverges", simulated[t]);
    let found = simulated.iter().position(|y| !y.is_finite());
    found.map_or(Ok(()), |t| Err(Error::Content(diverges(t))))
}

impl Validation {
    /// The same comparison for a free run over a whole record that any other simulator computed. There are no remarks
    /// on a model, and the initial condition is that of the simulator, not the one in the result.
    ///
    /// ```
    /// use piezoid::validation::ValidateOptions;
    /// // Whole periods, whose mean is 0.
    /// let u: Vec<f64> = (0..400).map(|t| (std::f64::consts::TAU * f64::from(t) / 100.0).sin()).collect();
    /// let record = piezoid::Record::new(1e-3, u.clone(), u.iter().map(|u| 2.0 * u).collect())?;
    /// let own: Vec<f64> = u.iter().map(|u| 1.8 * u).collect();
    /// let validation = piezoid_validation::Validation::of_run(&record, own, &ValidateOptions::default())?;
    /// assert!((validation.metrics.nrmse_percent - 10.0).abs() < 1e-9);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the run has another length than the record, or samples that are not finite; the errors of
    /// `skip`.
    pub fn of_run(record: &Record, simulated: Vec<f64>, options: &ValidateOptions) -> Result<Self, Error> {
        if simulated.len() != record.len() {
            let (found, expected) = (simulated.len(), record.len());
            let text = format!("the free run has {found} samples, but the input has {expected}: return one for each");
            return Err(Error::Content(text));
        }
        require_finite(&simulated)?;
        Validation::compared(None, record, (simulated, InitialCondition::Rest), options)
    }

    fn compared(
        model: Option<&Model>,
        record: &Record,
        (mut simulated, initial_condition): (Vec<f64>, InitialCondition),
        options: &ValidateOptions,
    ) -> Result<Self, Error> {
        let free_offset = options.offset != Offset::Kept;
        let start = Record::span(options.skip, f64::INFINITY, record.ts(), record.len())?.start;
        let counted = if start == 0 { record.clone() } else { record.slice(start..record.len())? };
        // Its search needs memory for the whole record: before the errors are there.
        let period = period(counted.u());
        let run = &simulated[start..];
        let found = Drift::of(&errors(counted.y(), run), run, record.ts());
        let slope = if options.offset == Offset::Drift { found.slope } else { 0.0 };
        if free_offset {
            let middle = start as f64 + 0.5 * (counted.len() as f64 - 1.0);
            simulated.iter_mut().enumerate().for_each(|(t, y)| *y += found.mean + slope * (t as f64 - middle));
        }
        let cycles = cycles(counted.u(), counted.ts());
        let run = ComparedRun { record: &counted, simulated: &simulated[start..] };
        let metrics = Metrics::of(counted.y(), run.simulated);
        let errors = errors(counted.y(), run.simulated);
        let drift = Drift::of(&errors, run.simulated, record.ts());
        let (u, y) = (counted.u(), counted.y());
        let mut bins = bins::CycleBins::default();
        cycles.iter().for_each(|cycle| bins.add(y, run.simulated, cycle));
        let (loops, [by_frequency, by_amplitude]) = (loops::loops(&counted, run.simulated, &cycles), bins.bins());
        let (facts, shape) = (model.map(|model| Facts::of(model, &counted)), Shape::of(y, run.simulated));
        let figures = Figures {
            metrics,
            start,
            initial_condition,
            options,
            found,
            drift,
            mean_error: mean(y) - mean(run.simulated),
            by_frequency: if cycles.is_empty() { bins::by_spectrum(&run) } else { by_frequency },
            by_amplitude,
            whiteness: Whiteness::of(u, &errors),
            floor: Floor::of(&run, period, &errors, &metrics, &drift),
            loops,
            facts,
            inner_reversals: model.map_or(0, |model| inner_reversals_of(model, u)),
            shape,
        };
        Ok(figures.validation(model, record.ts(), &record.units().y, simulated))
    }
}

/// What a validation is made of.
struct Figures<'a> {
    metrics: Metrics,
    start: usize,
    initial_condition: InitialCondition,
    options: &'a ValidateOptions,
    /// Mean error and drift as found, and the drift that is left once they are removed as the options say.
    found: Drift,
    drift: Drift,
    mean_error: f64,
    by_frequency: Vec<Bin>,
    by_amplitude: Vec<Bin>,
    whiteness: Option<Whiteness>,
    floor: Option<Floor>,
    loops: Vec<LoopComparison>,
    /// `None` without a model.
    facts: Option<Facts>,
    inner_reversals: usize,
    shape: Shape,
}

impl Figures<'_> {
    /// The validation of a record with sampling period `ts` [s] and an output in `unit`.
    fn validation(self, model: Option<&Model>, ts: f64, unit: &str, simulated: Vec<f64>) -> Validation {
        let Figures { metrics, drift, found, floor, loops, .. } = self;
        let comparison = model.zip(self.facts.as_ref()).map(|(model, facts)| remarks::Comparison {
            model,
            ts,
            unit,
            metrics: &metrics,
            drift: &drift,
            loops: &loops,
            facts,
            inner_reversals: self.inner_reversals,
            shape: &self.shape,
        });
        let named = drift.is_named.then_some(100.0 * drift.rms / metrics.std);
        let advice = advice::Residual {
            metrics: &metrics,
            drift: &drift,
            shape: &self.shape,
            whiteness: self.whiteness.as_ref(),
            floor: floor.as_ref(),
            comparison: comparison.as_ref(),
            unit,
        }
        .advice();
        let above = |bins: Vec<Bin>| bins.into_iter().map(|bin| bin.above(floor.map(|floor| floor.rms))).collect();
        Validation {
            metrics,
            start: self.start,
            initial_condition: self.initial_condition,
            offset: self.options.offset,
            offset_removed: (self.options.offset != Offset::Kept).then_some(found.mean),
            mean_error: self.mean_error,
            drift_per_s: found.slope / ts,
            named_drift: drift.is_named.then_some(drift.rms),
            nrmse_without_drift_percent: 100.0 * (metrics.mse - drift.rms.powi(2)).max(0.0).sqrt() / metrics.std,
            by_frequency: above(self.by_frequency),
            by_amplitude: above(self.by_amplitude),
            whiteness: self.whiteness,
            floor,
            summary: summary(&metrics, floor.as_ref(), named),
            advice,
            remarks: comparison.as_ref().map_or(Vec::new(), remarks::remarks),
            not_covered: comparison.as_ref().map_or(Vec::new(), remarks::not_covered),
            loops,
            simulated,
        }
    }
}

/// The part of a record that counts, and its free run.
#[derive(Debug, Clone, Copy)]
struct ComparedRun<'a> {
    record: &'a Record,
    simulated: &'a [f64],
}

/// Measured minus simulated.
fn errors(y: &[f64], simulated: &[f64]) -> Vec<f64> {
    y.iter().zip(simulated).map(|(y, s)| y - s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_testing::{assert_close, noise};
    use std::sync::Arc;

    #[test]
    fn a_drift_is_named_with_the_model_s_offset_or_a_free_one_and_removed_if_asked() {
        let ts = 1e-3;
        let u: Vec<f64> = (0..4000).map(|t| 10.0 * (0.03 * f64::from(t)).sin()).collect();
        let model =
            Model::new(Arc::new(Proportional::new(ts, 1.0).unwrap()), Arx::gain(ts, 1.0).unwrap(), 0.0).unwrap();
        let e = noise(2, 4000);
        let y = u.iter().zip(&e).enumerate().map(|(t, (u, e))| u + 4e-5 * (t as f64 - 2000.0) + 0.005 * e).collect();
        let record = Record::new(ts, u, y).unwrap();
        let validated = |offset| model.validate_with(&record, &ValidateOptions { offset, skip: 0.5 }).unwrap();
        for offset in [Offset::Kept, Offset::Free] {
            let validation = validated(offset);
            assert_close(&[validation.drift_per_s], &[0.04], 0.02, 0.0);
            assert!(
                validation.remarks.iter().any(|r| r.contains("a drift of 0.04 um/s makes 0.")),
                "{:?}",
                validation.remarks
            );
            assert!(validation.summary.unwrap().contains("of which drift 0."));
        }
        let (free, rest) = (validated(Offset::Free), validated(Offset::Drift));
        assert_close(&[rest.metrics.rmse, rest.floor.unwrap().rms], &[0.005; 2], 0.1, 0.0);
        let without = free.nrmse_without_drift_percent;
        assert_close(&[without, rest.nrmse_without_drift_percent], &[rest.metrics.nrmse_percent; 2], 1e-3, 0.0);
        assert_close(&[rest.drift_per_s], &[free.drift_per_s], 1e-9, 0.0);
        assert_eq!(rest.remarks, Vec::<String>::new());
        // The line goes on before the counted part.
        assert_close(&[rest.simulated[0] - record.u()[0]], &[-0.08], 0.05, 0.0);
    }

    #[test]
    fn a_model_and_a_record_have_the_same_period_and_units_that_can_be_converted() {
        let model =
            Model::new(Arc::new(Proportional::new(1e-3, 1.0).unwrap()), Arx::gain(1e-3, 1.0).unwrap(), 0.0).unwrap();
        let units = |u: &str, y: &str| Units { u: u.into(), y: y.into() };
        assert_eq!(factor(&model, 1e-3, &units("V", "nm")), Ok(1e3));
        for (ts, units) in [(1e-3, units("mA", "um")), (1e-3, units("V", "V")), (2e-3, units("V", "um"))] {
            assert!(factor(&model, ts, &units).is_err(), "{ts} {units:?}");
        }
    }

    #[test]
    fn any_free_run_is_compared_if_it_is_complete_and_finite() {
        let u: Vec<f64> = (0..400).map(|t| (std::f64::consts::TAU * f64::from(t) / 100.0).sin()).collect();
        let record = Record::new(1e-3, u.clone(), u.iter().map(|u| 2.0 * u).collect()).unwrap();
        let options = ValidateOptions::default();
        let own: Vec<f64> = u.iter().map(|u| 1.8 * u).collect();
        let found = Validation::of_run(&record, own.clone(), &options).unwrap();
        assert_close(&[found.metrics.nrmse_percent, found.mean_error], &[10.0, 0.0], 1e-9, 1e-12);
        assert_eq!((found.remarks, found.not_covered, found.simulated), (vec![], vec![], own.clone()));
        let message = Validation::of_run(&record, own[1..].to_vec(), &options).unwrap_err().to_string();
        assert!(message.contains("has 399 samples, but the input has 400"), "{message}");
        let mut diverging = own;
        diverging[7] = f64::INFINITY;
        let message = Validation::of_run(&record, diverging, &options).unwrap_err().to_string();
        assert!(message.contains("inf at sample 7"), "{message}");
    }
}
