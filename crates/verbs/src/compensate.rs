//! The voltage for a requested displacement.

use super::same_actuator::matched;
use super::verdict::StatedVerdict;
use super::{DataFile, File, Verdict, blamed, verdict};
use libm::hypot;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_control::compensation::{Compensated, FeedForward, FeedForwardSettings};
use piezoid_control::feedback::{MarginTarget, NamedReference, Scheme, SimulatedActuator, TunedScheme};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::system::System;
use piezoid_records::excitation::LimitOptions;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::record::Units;
use piezoid_validation::Metrics;
use serde::{Serialize, Serializer};
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
    /// The path on a simulated actuator, if one was named.
    pub on_plant: Option<OnPlant>,
}

/// A path on a simulated actuator, without the noise of its sensor: with a constant gain, and with the compensated
/// voltage.
#[derive(Debug, Clone, PartialEq)]
pub struct OnPlant {
    /// Name of the actuator.
    pub plant: String,
    /// Displacements with the constant gain, and with the compensated voltage [output unit].
    pub displacements: [Vec<f64>; 2],
    /// Their errors against the path, from its first sample that counts (see [`NamedReference::new`]).
    pub errors: [Metrics; 2],
    /// Lowest and highest rms error of the compensated voltage on random stand-ins, in 8 of 10 of them [output unit];
    /// `None` for a twin.
    pub spread: Option<[f64; 2]>,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
}

/// Number of random stand-ins, and how many of them are left out on either side.
const DRAWS: u64 = 20;
const LEFT_OUT: usize = 2;

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
        Ok(Compensation { ts, units, requested: r, shaped, compensated, reach, verdict, on_plant: None })
    }

    /// The same, played on a simulated actuator.
    ///
    /// # Errors
    /// The errors of [`CompensateOptions::of`], and of [`SimulatedActuator::plant`].
    pub fn on(
        &self,
        model: &Model,
        r: Vec<f64>,
        plant: Option<(&str, &SimulatedActuator)>,
    ) -> Result<Compensation, Error> {
        let mut result = self.of(model, r)?;
        result.on_plant = plant.map(|plant| self.played(model, &result, plant)).transpose()?;
        Ok(result)
    }

    fn played(
        &self,
        model: &Model,
        result: &Compensation,
        (name, actuator): (&str, &SimulatedActuator),
    ) -> Result<OnPlant, Error> {
        let (settings, r) = (self.settings()?, &result.shaped);
        let (actuator, note) = matched((name, actuator), model, &settings)?;
        let actuator = actuator.with_noise(0.0, &model.units().y)?;
        let plant = actuator.plant(model, 0)?;
        let scheme = TunedScheme::new(Scheme::named("gain")?, model, settings, 0, &MarginTarget::default())?;
        let with_gain = settings.limits.clip(&scheme.feed_forward(&*plant, r)?.u, model.ts())?;
        let NamedReference { from, .. } = NamedReference::new(name, model.ts(), r.clone());
        let play =
            |plant: &dyn System, u: &[f64]| plant.resume(&mut plant.settled(u.first().copied().unwrap_or_default()), u);
        let error = |y: &[f64]| Metrics::of(&r[from..], &y[from..]);
        let displacements = [&with_gain, &result.compensated.u].map(|u| play(&*plant, u));
        let errors = displacements.each_ref().map(|y| error(y));
        let draw = |i: u64| -> Result<f64, Error> {
            let drawn = actuator.drawn(0.0, 0, i)?.plant(model, 0)?;
            Ok(error(&play(&*drawn, &result.compensated.u)).rmse)
        };
        let spread = match actuator {
            SimulatedActuator::Twin(_) => None,
            SimulatedActuator::StandIn(_) => {
                let mut drawn = (0..DRAWS).map(draw).collect::<Result<Vec<f64>, Error>>()?;
                drawn.sort_by(f64::total_cmp);
                Some([drawn[LEFT_OUT], drawn[drawn.len() - 1 - LEFT_OUT]])
            }
        };
        Ok(OnPlant { plant: name.into(), displacements, errors, spread, notes: note.into_iter().collect() })
    }

    /// The same with the model and the reference from files.
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
        let result = self.on(&model, reference.reference(columns, &model)?, plant);
        result.map_err(|e| blamed(e, file).about(&reference.name))
    }
}

/// Its figures.
impl Serialize for OnPlant {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let [before, after] = &self.errors;
        let figures = json!({
            "plant": self.plant, "gain": before, "compensated": after, "spread": self.spread, "notes": self.notes,
        });
        figures.serialize(to)
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
            "expected_rms": self.expected_rms(), "verdict": self.verdict, "on_plant": self.on_plant,
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
