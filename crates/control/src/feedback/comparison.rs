//! Comparison of several schemes on one plant along several references.
//!
//! The error is r - y of the measurement, with sensor noise. It counts from a start sample of each reference: for a
//! periodic one after the whole periods that cover a quarter of a second. Percentages refer to the peak-to-peak value
//! of the reference.

use super::{ClosedLoopRun, FeedForwardResult, SimulatedActuator, Spread, Tolerance, Tracking, TunedScheme};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_records::waveform::period;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Time that does not count at the start of a periodic reference [s].
const SETTLING: f64 = 0.25;

/// A reference by name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedReference {
    /// Its name.
    pub name: String,
    /// The reference [output unit].
    pub r: Vec<f64>,
    /// The first sample that counts.
    pub from: usize,
}

impl NamedReference {
    /// `r` every `ts` [s]; counts after its first periods if it is periodic, otherwise from its start.
    pub fn new(name: impl Into<String>, ts: f64, r: Vec<f64>) -> Self {
        let begun = |period: usize| (SETTLING / ts / period as f64).ceil() as usize * period;
        let from = period(&r).map_or(0, |period| begun(period).min(r.len() / period / 2 * period).max(period));
        NamedReference { name: name.into(), r, from }
    }

    /// Peak-to-peak value [output unit].
    pub fn height(&self) -> f64 {
        let (low, high) = ends(self.r.iter().copied());
        high - low
    }
}

/// Result of one scheme along one reference.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceResult {
    /// The feed-forward.
    pub feed_forward: FeedForwardResult,
    /// The run.
    pub run: ClosedLoopRun,
    /// Tracking error.
    pub tracking: Tracking,
}

/// Results of one scheme.
#[derive(Debug, Clone)]
pub struct SchemeResult {
    /// The tuned scheme.
    pub tuned: TunedScheme,
    /// One result per reference, or the error of the scheme.
    pub attempts: Vec<Result<ReferenceResult, Error>>,
    /// Results on plants within a tolerance, along the first reference, if requested.
    pub spread: Option<Spread>,
}

impl SchemeResult {
    /// The scheme's name.
    pub fn name(&self) -> String {
        self.tuned.scheme.name()
    }
}

/// Several schemes, compared.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Name of the plant.
    pub plant: String,
    /// The references.
    pub references: Vec<NamedReference>,
    /// The schemes, in the order given.
    pub results: Vec<SchemeResult>,
    /// Notes on omissions, one sentence each.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Runs every scheme along every reference on an actuator; with a tolerance also on those drawn around it, along
    /// the first reference.
    ///
    /// # Errors
    /// Returns an error if no scheme can follow a reference; an error of one scheme alone is part of its results.
    /// Further errors: models with different sampling or units, an empty list, and cancellation.
    pub fn run(
        (name, actuator): (&str, &SimulatedActuator),
        schemes: Vec<TunedScheme>,
        references: Vec<NamedReference>,
        seed: u64,
        tolerance: Option<&Tolerance>,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let (Some(first), false) = (schemes.first(), references.is_empty()) else {
            return Err(Error::parameter("schemes and references", "none", "must be one each at least"));
        };
        let (ts, units) = (first.model().ts(), first.model().units());
        for tuned in &schemes {
            Record::same_sampling("the first model", ts, "another", tuned.model().ts())?;
            let (found, expected) = (tuned.model().units().y.clone(), units.y.clone());
            if found != expected {
                return Err(Error::Units {
                    what: format!("the output of the model of {}", tuned.scheme.name()),
                    found,
                    expected,
                });
            }
        }
        if let Some(constant) = references.iter().find(|reference| reference.height() <= 0.0) {
            return Err(Error::parameter("reference", &constant.name, "must not be constant"));
        }
        let plant = actuator.plant(first.model(), seed)?;
        let attempt = |tuned: &TunedScheme, reference: &NamedReference| -> Result<ReferenceResult, Error> {
            let feed_forward = tuned.feed_forward(&*plant, &reference.r)?;
            let run = tuned.run(&*plant, &reference.r, &feed_forward)?;
            let tracking = run.tracking(reference.from, reference.height());
            Ok(ReferenceResult { feed_forward, run, tracking })
        };
        let mut results = Vec::with_capacity(schemes.len());
        let total = schemes.len();
        for (done, tuned) in schemes.into_iter().enumerate() {
            let what = "schemes";
            if progress(Stage::new(what, done, total)).is_break() {
                return Err(Error::Cancelled { what: what.into(), done, total });
            }
            let attempts: Vec<_> = references.par_iter().map(|reference| attempt(&tuned, reference)).collect();
            let spread = match tolerance {
                Some(tolerance) if attempts[0].is_ok() => {
                    Some(tolerance.trials(actuator, &tuned, &references[0].r, references[0].from, progress)?)
                }
                _ => None,
            };
            results.push(SchemeResult { tuned, attempts, spread });
        }
        // If every scheme fails, the reference is wrong.
        let refused = |k: &usize| results.iter().all(|d| d.attempts[*k].is_err());
        let none = (0..references.len()).find(refused);
        if let Some(Err(error)) = none.map(|k| results[0].attempts.swap_remove(k)) {
            return Err(error);
        }
        Ok(Comparison { plant: name.into(), references, results, notes: Vec::new() })
    }
}

impl Comparison {
    /// Unit of references and displacements.
    pub fn unit(&self) -> &str {
        self.results.first().map_or("", |d| &d.tuned.model().units().y)
    }

    /// All results as one document: `references`, then `schemes`, each with its `margins`, `tracking` per reference,
    /// and `tolerance`.
    pub fn to_json(&self) -> Value {
        let attempt = |reference: &NamedReference, attempt: &Result<ReferenceResult, Error>| match attempt {
            Err(error) => json!({"reference": reference.name, "refused": error.to_string()}),
            Ok(ReferenceResult { feed_forward, run, tracking }) => json!({
                "reference": reference.name,
                "rms": tracking.rms,
                "max": tracking.max,
                "percent_of_stroke": tracking.percent_of_stroke,
                "effort": tracking.effort,
                "highest_voltage": run.max_abs_voltage(),
                "limited": run.limited,
                "trials": feed_forward.trials,
                "notes": feed_forward.notes,
            }),
        };
        let spread = |d: &SchemeResult, spread: &Spread| {
            json!({
                "draws": spread.trials.len(),
                "unstable": d.tuned.scheme.law.map(|_| spread.unstable()),
                "percent_of_stroke": spread.trials.iter().map(|t| t.tracking.percent_of_stroke).collect::<Vec<_>>(),
            })
        };
        let scheme = |d: &SchemeResult| {
            json!({
                "scheme": d.name(),
                "margins": d.tuned.margins(),
                "least_bandwidth_hz": d.tuned.least_bandwidth_hz(),
                "tracking": self.references.iter().zip(&d.attempts).map(|(w, a)| attempt(w, a)).collect::<Vec<_>>(),
                "tolerance": d.spread.as_ref().map(|s| spread(d, s)),
            })
        };
        let reference =
            |w: &NamedReference| json!({"name": w.name, "samples": w.r.len(), "from": w.from, "height": w.height()});
        json!({
            "plant": self.plant,
            "unit": self.unit(),
            "references": self.references.iter().map(reference).collect::<Vec<_>>(),
            "schemes": self.results.iter().map(scheme).collect::<Vec<_>>(),
        })
    }
}
