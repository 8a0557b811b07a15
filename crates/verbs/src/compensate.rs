//! The voltage for a requested displacement.

use super::verdict::StatedVerdict;
use super::{DataFile, File, OnPlant, Smoothing, Verdict, blamed, smoothing, verdict};
use libm::hypot;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_control::compensation::{Compensated, FeedForward, FeedForwardSettings};
use piezoid_control::feedback::SimulatedActuator;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
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
        let (ts, units, reach, verdict) = (model.ts(), model.units().clone(), inverse.reach(), model.verdict());
        let (smoothing, on_plant) = (None, None);
        Ok(Compensation { ts, units, requested: r, shaped, compensated, reach, verdict, smoothing, on_plant })
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
    /// error at a tenth of the stroke, because smaller loops have not been measured. `None` if the file of the model
    /// does not say how good it is.
    pub fn expected_rms(&self) -> Option<f64> {
        const LEAST: f64 = 0.1;
        let (metrics, _) = self.metrics();
        let (verdict, stroke) = (self.verdict.as_ref()?, self.reach.1 - self.reach.0);
        let of_model = 0.01 * verdict.error_percent * metrics.peak_to_peak.max(LEAST * stroke);
        let noise = 0.01 * verdict.noise_percent.unwrap_or(0.0) * stroke;
        Some(hypot(of_model.max(noise), metrics.rmse))
    }

    /// The figures as a document. `rmse`, `max_abs` and `rms_pp_percent` are errors of the inverse alone, on the model.
    pub fn to_json(&self) -> Value {
        let ((metrics, requested), result) = (self.metrics(), &self.compensated);
        json!({
            "unit": self.units.y, "n": metrics.n, "rmse": metrics.rmse, "max_abs": metrics.max_abs,
            "rms_pp_percent": metrics.rms_pp_percent, "clipped": result.clipped, "reach": self.reach,
            "usage": result.usage, "notes": result.notes, "requested": requested,
            "expected_rms": self.expected_rms(), "verdict": self.verdict, "smoothing": self.smoothing,
            "on_plant": self.on_plant,
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
