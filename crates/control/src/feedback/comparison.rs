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

#[cfg(test)]
mod tests {
    use super::super::{MarginTarget, Scheme};
    use super::*;
    use crate::compensation::FeedForwardSettings;
    use piezoid_models::hammerstein::Model;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_records::excitation::{Limits, Sine};
    use piezoid_records::record::Units;
    use piezoid_twins::Preset;
    use std::ops::ControlFlow;
    use std::sync::Arc;

    const TS: f64 = 5e-4;

    fn sine(amplitude: f64, n: usize) -> Vec<f64> {
        Sine { amplitude, frequency: 20.0, ..Sine::default() }.samples(TS, n).unwrap()
    }

    /// A scheme tuned on a gain of 35 um/V.
    fn tuned(name: &str, ts: f64, y: &str) -> TunedScheme {
        let model = Model::new(Arc::new(Proportional::new(ts, 1.0).unwrap()), Arx::gain(ts, 35.0).unwrap(), 0.0);
        let model = model.unwrap().with_units(Units { u: "V".into(), y: y.into() });
        let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
        let settings = FeedForwardSettings { limits, ..FeedForwardSettings::default() };
        TunedScheme::new(Scheme::named(name).unwrap(), &model, settings, 0, &MarginTarget::default()).unwrap()
    }

    fn compared(schemes: Vec<TunedScheme>, references: Vec<NamedReference>) -> Result<Comparison, Error> {
        let actuator: SimulatedActuator = Preset::find("pl140").unwrap().spec().into();
        Comparison::run(("pl140", &actuator), schemes, references, 3, None, &mut Stage::ignore)
    }

    fn two() -> Vec<TunedScheme> {
        vec![tuned("gain", TS, "um"), tuned("pi", TS, "um")]
    }

    #[test]
    fn whole_periods_of_a_quarter_of_a_second_do_not_count() {
        for (n, from) in [(2000, 500), (600, 300), (250, 100)] {
            assert_eq!(NamedReference::new("sine", TS, sine(3.0, n)).from, from, "{n}");
        }
        let ramp = NamedReference::new("ramp", TS, (0..500).map(f64::from).collect());
        assert_eq!((ramp.from, ramp.height(), &*ramp.name), (0, 499.0, "ramp"));
    }

    #[test]
    fn every_scheme_follows_every_reference_on_the_same_actuator() {
        let references = ["small", "large"].into_iter().zip([100.0, 500.0]);
        let references: Vec<_> =
            references.map(|(name, size)| NamedReference::new(name, TS, sine(size, 1000))).collect();
        let found = compared(two(), references.clone()).unwrap();
        assert_eq!((found.unit(), &*found.plant, &found.references), ("um", "pl140", &references));
        let actuator: SimulatedActuator = Preset::find("pl140").unwrap().spec().into();
        let document = found.to_json();
        for (k, (expected, scheme)) in two().iter().zip(&found.results).enumerate() {
            assert_eq!(scheme.name(), expected.scheme.name());
            let plant = actuator.plant(expected.model(), 3).unwrap();
            for (i, (reference, result)) in references.iter().zip(&scheme.attempts).enumerate() {
                let result = result.as_ref().unwrap();
                let feed_forward = expected.feed_forward(&*plant, &reference.r).unwrap();
                let run = expected.run(&*plant, &reference.r, &feed_forward).unwrap();
                assert_eq!(result.tracking, run.tracking(500, 2.0 * [100.0, 500.0][i]));
                let written = &document["schemes"][k]["tracking"][i];
                assert_eq!(written["rms"], result.tracking.rms);
                assert_eq!(written["percent_of_stroke"], result.tracking.percent_of_stroke);
                let highest = run.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
                assert_eq!((result.run.max_abs_voltage(), &written["highest_voltage"]), (highest, &json!(highest)));
                assert_eq!((&written["reference"], &written["limited"]), (&json!(reference.name), &json!(run.limited)));
            }
        }
        assert_eq!(document["schemes"][1]["scheme"], "pi");
        assert!(document["schemes"][1]["least_bandwidth_hz"].as_f64().unwrap() > 1.0);
        assert!(document["schemes"][0]["margins"].is_null() && document["schemes"][0]["tolerance"].is_null());
        assert_eq!(document["references"][1], json!({"name": "large", "samples": 1000, "from": 500, "height": 1000.0}));
    }

    #[test]
    fn what_cannot_be_compared_is_an_error() {
        let message =
            |schemes, r: Vec<f64>| compared(schemes, vec![NamedReference::new("r", TS, r)]).unwrap_err().to_string();
        assert!(compared(two(), vec![]).unwrap_err().to_string().contains("must be one each at least"));
        assert!(message(vec![], sine(9.0, 400)).contains("must be one each at least"));
        assert!(message(two(), vec![7.0; 400]).contains("reference = r: must not be constant"));
        let slow = vec![tuned("gain", TS, "um"), tuned("gain", 1e-3, "um")];
        assert!(message(slow, sine(9.0, 400)).contains("the first model"));
        let millimetres = vec![tuned("gain", TS, "um"), tuned("pi", TS, "mm")];
        assert!(message(millimetres, sine(9.0, 400)).contains("the output of the model of pi"));
        // Out of reach for every scheme with a feed-forward by the model.
        assert!(message(vec![tuned("feed-forward", TS, "um")], sine(5000.0, 400)).contains("reduce its amplitude"));
    }

    #[test]
    fn a_comparison_can_be_cancelled_between_schemes() {
        let actuator: SimulatedActuator = Preset::find("pl140").unwrap().spec().into();
        let references = vec![NamedReference::new("sine", TS, sine(100.0, 400))];
        let mut stages = Vec::new();
        let progress = &mut |stage: Stage| {
            stages.push((stage.done, stage.total));
            if stage.done == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let error = Comparison::run(("pl140", &actuator), two(), references, 0, None, progress).unwrap_err();
        assert_eq!(error, Error::Cancelled { what: "schemes".into(), done: 1, total: 2 });
        assert_eq!(stages, [(0, 2), (1, 2)]);
    }

    #[test]
    fn only_a_scheme_that_can_follow_is_tried_on_other_plants() {
        let actuator: SimulatedActuator = Preset::find("pl140").unwrap().spec().into();
        let tolerance = Tolerance { draws: 2, ..Tolerance::default() };
        let schemes = vec![tuned("feed-forward", TS, "um"), tuned("gain", TS, "um")];
        let references = vec![NamedReference::new("far", TS, sine(2000.0, 400))];
        let (named, stage) = (("pl140", &actuator), &mut Stage::ignore);
        let found = Comparison::run(named, schemes, references, 3, Some(&tolerance), stage).unwrap();
        let draws = |result: &SchemeResult| result.spread.as_ref().map(|spread| spread.trials.len());
        assert_eq!(found.results.iter().map(draws).collect::<Vec<_>>(), [None, Some(2)]);
        let document = found.to_json();
        let [refused, run] = [0, 1].map(|k| &document["schemes"][k]);
        assert!(refused["tracking"][0]["refused"].as_str().unwrap().contains("reduce its amplitude"), "{refused}");
        assert!(refused["tolerance"].is_null() && run["tolerance"]["unstable"].is_null(), "{document}");
        assert_eq!(run["tolerance"]["draws"], 2);
    }
}
