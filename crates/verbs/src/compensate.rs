//! The voltage for a requested displacement.

use super::verdict::StatedVerdict;
use super::{DataFile, File, OnPlant, Smoothing, Verdict, blamed, smoothing, verdict};
use libm::hypot;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_control::compensation::{Compensated, FeedForward, FeedForwardSettings};
use piezoid_control::feedback::SimulatedActuator;
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::excitation::LimitOptions;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::record::Units;
use piezoid_validation::Metrics;
use serde_json::{Value, json};

options! {
    /// How to compensate.
    pub struct CompensateOptions {
        /// Clip the voltage to the limits, instead of refusing a reference that exceeds them.
        clip: bool = false, OptionRow::new(OptionKind::Switch);
        /// Largest number of iterations that correct the error left in the model's free run.
        iterations: usize = 0, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Error of the model over peak-to-peak, if a validation found a larger one than its file states.
        model_error: Option<f64> = None, OptionRow::not_negative("%");
    } with limits: LimitOptions with shape: Shaping
}

/// The voltage for a reference, and the displacement that the model predicts.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensation {
    /// Sampling period [s].
    pub ts: f64,
    /// Units of voltage and displacement.
    pub units: Units,
    /// The reference as requested [output unit].
    pub requested: Vec<f64>,
    /// The reference after shaping [output unit].
    pub shaped: Vec<f64>,
    /// The voltage, and the displacement that the model predicts.
    pub compensated: Compensated,
    /// The lowest and the highest displacement that can be held [output unit].
    pub reach: (f64, f64),
    /// How good the model was at its identification, if its file says so.
    pub verdict: Option<Verdict>,
    /// Error of the model by its file or by a validation, whichever is larger [% of peak-to-peak].
    pub model_error: Option<f64>,
    /// True if the voltage leaves the range or the rates of the training data, where the error is not known.
    pub is_beyond: bool,
    /// The smoothing that keeps the voltage within the rates of the training data, where it exceeds them; `None` if it
    /// was not looked for ([`CompensateOptions::smoothing`]).
    pub smoothing: Option<Smoothing>,
    /// The path on a simulated actuator, if one was named.
    pub on_plant: Option<OnPlant>,
}

impl CompensateOptions {
    /// Settings of the feed-forward.
    ///
    /// # Errors
    /// The errors of [`LimitOptions::limits`].
    pub fn settings(&self) -> Result<FeedForwardSettings, Error> {
        Ok(FeedForwardSettings { iterations: self.iterations, ..FeedForwardSettings::within(&self.limits, self.clip)? })
    }

    /// The voltage for the reference `r` [output unit].
    ///
    /// # Errors
    /// Returns an error for inconsistent limits, a model without an inverse, and a reference that cannot be shaped or
    /// reached.
    pub fn of(&self, model: &Model, r: Vec<f64>) -> Result<Compensation, Error> {
        let inverse = FeedForward::new(model, self.settings()?)?;
        let shaped = self.shape.of(model, r.clone())?;
        let compensated = inverse.whole(&shaped)?;
        let found = Compensation::new(model, r, shaped, (compensated, inverse.reach()));
        let model_error = found.model_error.into_iter().chain(self.model_error).reduce(f64::max);
        Ok(Compensation { model_error, ..found })
    }

    /// The smoothing that keeps the voltage of this result within the rates of the training data, from a dozen
    /// inversions; `None` if it is within, if the rates are not known, and if the path is too long for that.
    pub fn smoothing(&self, model: &Model, found: &Compensation) -> Option<Smoothing> {
        Smoothing::of(self, model, &found.requested, &found.compensated)
    }

    /// The error of [`of`](Self::of) for the reference `r`; if that cannot be reached or exceeds limits, with the
    /// smoothing that resolves it, from a dozen inversions.
    pub fn advised(&self, model: &Model, r: &[f64], error: Error) -> Error {
        smoothing::advised(self, model, r, error)
    }

    /// The same with the model and the reference from files, with the [`smoothing`](Self::smoothing), and played on a
    /// simulated actuator if one is named.
    ///
    /// # Errors
    /// The errors of [`CompensateOptions::of`], and errors for files without a model or a reference.
    pub fn run(
        &self,
        model: &File,
        reference: &DataFile,
        columns: &ColumnSelection,
        plant: Option<(&str, &SimulatedActuator)>,
    ) -> Result<Compensation, Error> {
        let (file, model) = (model, model.model()?);
        let r = reference.reference(columns, &model)?;
        let result = self.of(&model, r.clone()).map_err(|error| self.advised(&model, &r, error));
        let played = |found: Compensation| -> Result<Compensation, Error> {
            let smoothing = self.smoothing(&model, &found);
            let on_plant = plant.map(|plant| OnPlant::of(plant, &model, &found, self.settings()?)).transpose()?;
            Ok(Compensation { smoothing, on_plant, ..found })
        };
        result.and_then(played).map_err(|e| blamed(e, file).about(&reference.name))
    }
}

impl Compensation {
    pub(super) fn new(
        model: &Model,
        requested: Vec<f64>,
        shaped: Vec<f64>,
        (compensated, reach): (Compensated, (f64, f64)),
    ) -> Self {
        let (ts, verdict) = (model.ts(), model.verdict());
        Compensation {
            ts,
            units: model.units().clone(),
            requested,
            shaped,
            reach,
            model_error: verdict.as_ref().map(|verdict| verdict.error_percent),
            is_beyond: model.identified().is_some_and(|known| {
                let (low, high) = ends(compensated.u.iter().copied());
                !known.spans([low, high]) || known.is_slower_than(Domain::slew_of(&compensated.u, ts))
            }),
            compensated,
            verdict,
            smoothing: None,
            on_plant: None,
        }
    }

    /// How good the model is, in words.
    pub fn proven(&self) -> String {
        verdict::proven(self.verdict.as_ref())
    }

    /// Errors of the free run against the shaped reference, and, if it differs, against the requested one.
    pub fn metrics(&self) -> (Metrics, Option<Metrics>) {
        let of = |r: &[f64]| Metrics::of(r, &self.compensated.reached);
        (of(&self.shaped), (self.shaped != self.requested).then(|| of(&self.requested)))
    }

    /// The rms error to expect of the actuator [output unit]: that of the model on held-out records, over the same
    /// peak-to-peak, and that which the inverse leaves. The error of the model is at least its noise, and at least its
    /// error at a tenth of the stroke, because smaller loops have not been measured. Where the voltage
    /// [leaves](Self::is_beyond) the training data, this is a lower bound. `None` if it is not known how good the model
    /// is.
    pub fn expected_rms(&self) -> Option<f64> {
        const LEAST: f64 = 0.1;
        let (metrics, _) = self.metrics();
        let stroke = self.reach.1 - self.reach.0;
        let of_model = 0.01 * self.model_error? * metrics.peak_to_peak.max(LEAST * stroke);
        let noise = self.verdict.as_ref().and_then(|verdict| verdict.noise_percent);
        let noise = 0.01 * noise.unwrap_or(0.0) * stroke;
        Some(hypot(of_model.max(noise), metrics.rmse))
    }

    /// The figures as a document. `rmse`, `max_abs` and `rms_pp_percent` are errors of the inverse alone, on the model.
    pub fn to_json(&self) -> Value {
        let ((metrics, requested), result) = (self.metrics(), &self.compensated);
        json!({
            "unit": self.units.y, "n": metrics.n, "rmse": metrics.rmse, "max_abs": metrics.max_abs,
            "rms_pp_percent": metrics.rms_pp_percent, "clipped": result.clipped, "reach": self.reach,
            "usage": result.usage, "notes": result.notes, "requested": requested,
            "expected_rms": self.expected_rms(), "is_beyond": self.is_beyond, "verdict": self.verdict,
            "smoothing": self.smoothing, "on_plant": self.on_plant,
        })
    }

    /// Voltage and shaped reference as a file of this name.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let (u, r) = (format!("u_{}", self.units.u), format!("r_{}", self.units.y));
        Table::write(name, self.ts, &[(&u, &self.compensated.u), (&r, &self.shaped)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::options::Options;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    const TS: f64 = 1e-3;

    fn sine(height: f64, hz: f64) -> Vec<f64> {
        (0..2000).map(|t| height * (TAU * hz * TS * f64::from(t)).cos()).collect()
    }

    /// 1 um/V, identified on +-10 V at 5 Hz with an error of 0.5 %.
    fn model() -> Model {
        let verdict = json!({"error_percent": 0.5, "measured": "free run on held-out parts", "noise_percent": null,
            "u": [-10.0, 10.0], "unit": "V", "hz": [5.0, 5.0], "unproven": []});
        let model = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), Arx::gain(TS, 1.0).unwrap(), 0.0);
        let known = Domain::of_input(&sine(10.0, 5.0), TS);
        model.unwrap().with_identified(known).with_provenance(json!({ "verdict": verdict }))
    }

    #[test]
    fn the_error_to_expect_is_the_larger_of_identification_and_validation() {
        let expected = |model_error: Option<f64>| {
            let options = CompensateOptions { model_error, ..CompensateOptions::default() };
            options.of(&model(), sine(8.0, 3.0)).unwrap().expected_rms().unwrap()
        };
        let found = [None, Some(0.2), Some(3.0)].map(expected);
        assert_close(&found, &[0.08, 0.08, 0.48], 1e-9, 0.0);
    }

    #[test]
    fn a_path_beyond_the_range_or_the_rates_of_the_training_data_is_known() {
        let is_beyond = |r: Vec<f64>| CompensateOptions::default().of(&model(), r).unwrap().is_beyond;
        assert!(!is_beyond(sine(10.0, 5.0)) && is_beyond(sine(10.3, 3.0)) && is_beyond(sine(8.0, 9.0)));
        let unknown = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), Arx::gain(TS, 1.0).unwrap(), 0.0);
        let options = CompensateOptions::from_json(json!({"low": -50, "high": 50})).unwrap();
        assert!(!options.of(&unknown.unwrap(), sine(20.0, 3.0)).unwrap().is_beyond);
    }
}
