//! The Hammerstein model: hysteresis, then creep, then linear dynamics, then an offset.
//!
//! ```text
//! u -> (driver) -> hysteresis -> z -> creep -> linear -> + offset -> y
//! ```
//! A model may also have mechanics with hysteresis in feedback ([`crate::feedback`]), which then give its response; the
//! blocks in series approximate them where an inverse or a margin needs blocks.
//!
//! The driver is a separate block if it is known; otherwise the linear block includes its effect on small steps.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "No further nonlinearity pays".

mod domain;
mod effort;
mod hidden;
mod initial_condition;
mod inverse;
mod loops;
mod program;
mod summary;

pub use domain::Domain;
pub use initial_condition::InitialCondition;
pub use loops::{HiddenLoop, LoopPoints, MIN_OPEN_AGREEMENT, named, remarks};

use crate::creep::{Creep, Lag};
use crate::driver::DriverModel;
use crate::feedback::{FeedbackDocument, FeedbackModel, Intersample};
use crate::hysteresis::{self, Hysteresis};
use crate::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::record::{Record, Units};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::Arc;

/// Samples that each block processes before the next one: few enough for the nearest cache.
const BLOCK_SAMPLES: usize = 512;

/// Samples whose voltages behind a driver are kept at a time.
const DRIVER_BLOCK_SAMPLES: usize = 64;

/// Largest text of a model [bytes]. Those that are identified have less than 1 MiB; parsed, a text takes 16 times its
/// size.
const MAX_MODEL_BYTES: usize = 16 << 20;

/// The schema number of model files.
const SCHEMA: u64 = 1;

/// u -> hysteresis -> creep -> linear -> y, with the units of the records that it was identified from.
///
/// State: that of the hysteresis block, then of creep, then of the linear block; with a driver also its voltage and the
/// z at that instant. With mechanics in feedback it is their state alone.
///
/// ```
/// use piezoid::{System, hammerstein::Model, hysteresis::Proportional, linear::Arx};
/// use std::sync::Arc;
/// let hysteresis = Arc::new(Proportional::new(5e-4, 1.0)?);
/// let model = Model::new(hysteresis, Arx::gain(5e-4, 33.0)?, 2.0)?;
/// assert_eq!(model.simulate(&[0.0, 1.0]), [2.0, 35.0]);
/// let again = Model::from_json(&model.to_json())?;
/// assert_eq!(again.simulate(&[0.0, 1.0]), [2.0, 35.0]);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    driver: Option<DriverModel>,
    hysteresis: Arc<dyn Hysteresis>,
    creep: Creep,
    linear: Arx,
    offset: f64,
    units: Units,
    feedback: Option<Arc<FeedbackModel>>,
    identified: Option<Domain>,
    provenance: Value,
}

/// True if the numbers and units are equal to the bit, however the models were identified.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.numbers() == other.numbers()
    }
}

impl Model {
    /// Its file without the provenance.
    fn numbers(&self) -> String {
        self.clone().with_provenance(Value::Null).to_json()
    }

    /// The blocks in series; `offset` [output unit] is added to the output.
    ///
    /// # Errors
    /// Returns an error if the blocks have different sampling periods or the offset is not finite.
    pub fn new(hysteresis: Arc<dyn Hysteresis>, linear: Arx, offset: f64) -> Result<Self, Error> {
        Model::from_blocks(None, hysteresis, linear, offset)
    }

    /// The same behind a driver. The hysteresis block is sampled [`DriverModel::SUBSTEPS`] times faster than the linear
    /// block.
    ///
    /// # Errors
    /// The errors of [`Model::new`].
    pub fn from_blocks(
        driver: Option<DriverModel>,
        hysteresis: Arc<dyn Hysteresis>,
        linear: Arx,
        offset: f64,
    ) -> Result<Self, Error> {
        let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
        Record::same_sampling("the hysteresis block", hysteresis.ts() * faster, "the linear block", linear.ts())?;
        piezoid_numerics::error::finite("offset", &[offset])?;
        let (creep, units) = (Creep::new(linear.ts(), Vec::new())?, Units::default());
        let (feedback, identified, provenance) = (None, None, Value::Null);
        Ok(Model { driver, hysteresis, creep, linear, offset, units, feedback, identified, provenance })
    }

    /// The same model with creep between the hysteresis and the linear block.
    ///
    /// # Errors
    /// Returns an error if the sampling periods differ.
    pub fn with_creep(self, creep: Creep) -> Result<Self, Error> {
        Record::same_sampling("creep", creep.ts(), "the linear block", self.linear.ts())?;
        Ok(Model { creep, ..self })
    }

    /// The same model with another linear block.
    pub fn with_linear(self, linear: Arx) -> Result<Self, Error> {
        Record::same_sampling("the linear block", linear.ts(), "creep", self.creep.ts())?;
        Ok(Model { linear, ..self })
    }

    /// The same model whose response is that of `feedback`; its blocks in series approximate it.
    ///
    /// # Errors
    /// Returns an error if the sampling periods differ.
    pub fn with_feedback(self, feedback: FeedbackModel) -> Result<Self, Error> {
        Record::same_sampling("the feedback model", feedback.ts(), "the linear block", self.linear.ts())?;
        Ok(Model { feedback: Some(Arc::new(feedback)), ..self })
    }

    /// The blocks in series alone.
    pub fn without_feedback(&self) -> Self {
        Model { feedback: None, ..self.clone() }
    }

    /// The same model with other units.
    pub fn with_units(self, units: Units) -> Self {
        Model { units, ..self }
    }

    /// The same model with its provenance, stored as `fit` in its file.
    pub fn with_provenance(self, provenance: Value) -> Self {
        Model { provenance, ..self }
    }

    /// The same model with the range of the data it was identified from, stored as `identified` in its file.
    pub fn with_identified(self, domain: Domain) -> Self {
        Model { identified: Some(domain), ..self }
    }

    /// The driver; `None` if it is unknown.
    pub fn driver(&self) -> Option<&DriverModel> {
        self.driver.as_ref()
    }

    /// The block from u to z.
    pub fn hysteresis(&self) -> &dyn Hysteresis {
        &*self.hysteresis
    }

    /// The creep block; it has no lags if there is no creep.
    pub fn creep(&self) -> &Creep {
        &self.creep
    }

    /// The block from z with creep to y.
    pub fn linear(&self) -> &Arx {
        &self.linear
    }

    /// Offset of the output [output unit].
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Mechanics with hysteresis in feedback, which give the response; `None` if the blocks in series do.
    pub fn feedback(&self) -> Option<&FeedbackModel> {
        self.feedback.as_deref()
    }

    /// Units of input and output.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The range of the data it was identified from; `None` if unknown.
    pub fn identified(&self) -> Option<&Domain> {
        self.identified.as_ref()
    }

    /// The range of inputs it was identified from, otherwise the range of its hysteresis.
    pub fn known_inputs(&self) -> Option<(f64, f64)> {
        self.identified().map(|domain| (domain.u[0], domain.u[1])).or(self.hysteresis().range())
    }

    /// The provenance of the model; null if unknown.
    pub fn provenance(&self) -> &Value {
        &self.provenance
    }

    /// The model as a JSON document; the same model gives the same bytes.
    pub fn to_json(&self) -> String {
        let document = Document {
            piezoid: SCHEMA,
            ts: self.linear.ts(),
            units: self.units.clone(),
            driver: self.driver,
            hysteresis: hysteresis::save(&*self.hysteresis),
            creep: Some(self.creep.lags().to_vec()).filter(|lags| !lags.is_empty()),
            linear: LinearDocument { a: self.linear.a().to_vec(), b: self.linear.b().to_vec() },
            offset: self.offset,
            feedback: self.feedback().map(FeedbackModel::document),
            identified: self.identified,
            fit: self.provenance.clone(),
        };
        // A document of strings and finite numbers always serialises.
        serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
    }

    /// Reads a document written by [`Model::to_json`].
    ///
    /// # Errors
    /// Returns an error, with the place and what to do, if the text is not JSON, not a model, or has another schema
    /// number; and if it has more than 16 MiB.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        if text.len() > MAX_MODEL_BYTES {
            let [size, most] = [text.len(), MAX_MODEL_BYTES].map(|bytes| bytes.div_ceil(1 << 20));
            return Err(Error::Content(format!("not a model file: it has {size} MiB, and models at most {most} MiB")));
        }
        let value: Value = serde_json::from_str(text)
            .map_err(|e| Error::Content(format!("not a complete JSON document, perhaps cut short ({e})")))?;
        match &value["piezoid"] {
            Value::Number(n) if n.as_u64() == Some(SCHEMA) => {}
            Value::Null => {
                return Err(Error::Content("not a model file: it has no \"piezoid\" schema number".into()));
            }
            other => {
                return Err(Error::Content(format!(
                    "the model file has schema number {other}, but this version reads {SCHEMA}: read it with the \
                     version that wrote it"
                )));
            }
        }
        let d: Document = serde_json::from_value(value).map_err(|e| Error::Content(format!("model file: {e}")))?;
        let driver = d.driver.map(|d| DriverModel::new(d.lag_s, d.slew)).transpose()?;
        let linear = Arx::new(d.ts, d.linear.a, d.linear.b)?;
        let ts = if driver.is_some() { d.ts / DriverModel::SUBSTEPS as f64 } else { d.ts };
        let model = Model::from_blocks(driver, hysteresis::load(&d.hysteresis, ts)?, linear, d.offset)?;
        let model = model.with_creep(Creep::new(d.ts, d.creep.unwrap_or_default())?)?;
        let identified = d.identified.map(Domain::checked).transpose()?;
        let model = Model { identified, ..model.with_units(d.units).with_provenance(d.fit) };
        match d.feedback {
            Some(document) => model.with_feedback(FeedbackModel::load(d.ts, document)?),
            None => Ok(model),
        }
    }
}

/// A model file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    piezoid: u64,
    ts: f64,
    #[serde(default)]
    units: Units,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    driver: Option<DriverModel>,
    hysteresis: Value,
    #[serde(default)]
    creep: Option<Vec<Lag>>,
    linear: LinearDocument,
    #[serde(default)]
    offset: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    feedback: Option<FeedbackDocument>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    identified: Option<Domain>,
    #[serde(default)]
    fit: Value,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LinearDocument {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Model {
    /// The response of hysteresis and creep to the input, from rest: the input of the linear block.
    pub fn simulate_before_linear(&self, u: &[f64]) -> Vec<f64> {
        let (mut x, mut z) = (self.initial_blocks(), u.to_vec());
        let [hysteresis, creep, _, driver] = self.parts(&mut x);
        self.hidden(hysteresis, driver, &mut z);
        self.creep.respond(creep, &mut z);
        z
    }

    /// The response from the state `x`, which is advanced to the end of the run, to an input that is known as a whole:
    /// a band-limited one is interpolated. Otherwise that of [`System::resume`].
    pub fn follow(&self, x: &mut [f64], u: &[f64]) -> Vec<f64> {
        match &self.feedback {
            Some(feedback) => feedback.follow(x, u),
            None => self.resume(x, u),
        }
    }

    /// Standard deviation of the response to the input `u` from the state `x`, after each sample [output unit]; `None`
    /// if the operator states none, and with mechanics in feedback. It is that of z times the static gain: errors of a
    /// hysteresis change as slowly as its input.
    pub fn deviation(&self, x: &[f64], u: &[f64]) -> Option<Vec<f64>> {
        let mut x = x.to_vec();
        let creep: f64 = self.creep.lags().iter().map(|lag| lag.gain).sum();
        let gain = (self.linear.dc_gain() * (1.0 + creep)).abs();
        let [hysteresis, _, _, driver] = self.feedback.is_none().then(|| self.parts(&mut x))?;
        let after = |&u: &f64| {
            self.hidden(hysteresis, driver, &mut [u]);
            Some(gain * self.hysteresis.deviation(hysteresis)?)
        };
        u.iter().map(after).collect()
    }

    /// The place of creep in the state, and its lags.
    pub fn creep_of_state(&self) -> (usize, &[Lag]) {
        match self.feedback() {
            Some(feedback) => {
                let dynamics = feedback.dynamics();
                (feedback.hysteresis().order() + 2 * dynamics.modes.len(), &dynamics.creep)
            }
            None => (self.hysteresis.order(), self.creep.lags()),
        }
    }

    /// True if [`follow`](Model::follow) depends on inputs to come, so that a run in parts differs from the whole run.
    pub fn interpolates(&self) -> bool {
        self.feedback().is_some_and(|feedback| feedback.dynamics().intersample == Intersample::BandLimited)
    }

    /// One-step prediction: `y[t]` from `u` up to t and measured `y` up to t-1. The actuator is at rest before the
    /// first sample.
    ///
    /// # Errors
    /// Returns an error if the series have different lengths.
    pub fn predict(&self, u: &[f64], y: &[f64]) -> Result<Vec<f64>, Error> {
        if u.len() != y.len() {
            return Err(Error::Lengths { left: "u".into(), left_len: u.len(), right: "y".into(), right_len: y.len() });
        }
        if self.feedback.is_some() {
            // The error of the free run goes on as the linear block lets it.
            let run = self.follow(&mut self.initial(), u);
            let errors: Vec<f64> = y.iter().zip(&run).map(|(y, run)| y - run).collect();
            let expected = self.linear.predict(&vec![0.0; errors.len()], &errors);
            return Ok(run.iter().zip(expected).map(|(run, error)| run + error).collect());
        }
        let measured: Vec<f64> = y.iter().map(|y| y - self.offset).collect();
        let predicted = self.linear.predict(&self.simulate_before_linear(u), &measured);
        Ok(predicted.iter().map(|y| y + self.offset).collect())
    }

    /// The blocks in series at rest.
    fn initial_blocks(&self) -> Vec<f64> {
        let mut x = [self.hysteresis.initial(), self.creep.initial(), self.linear.initial()].concat();
        x.extend(self.driver.iter().flat_map(|_| [0.0; 2]));
        x
    }

    /// The blocks in series, settled at the input `u`.
    fn settled_blocks(&self, u: f64) -> Vec<f64> {
        let mut x = self.hysteresis.settled(u);
        let z = self.hysteresis.step(&mut x.clone(), u);
        let creep = self.creep.settled(z);
        let crept = self.creep.step(&mut creep.clone(), z);
        x.extend(creep);
        x.extend(self.linear.settled(crept));
        x.extend(self.driver.iter().flat_map(|_| [u, z]));
        x
    }

    /// The parts of a state of the blocks in series: hysteresis, creep, linear, driver.
    fn parts<'x>(&self, x: &'x mut [f64]) -> [&'x mut [f64]; 4] {
        let (hysteresis, x) = x.split_at_mut(self.hysteresis.order());
        let (creep, x) = x.split_at_mut(self.creep.order());
        let (linear, driver) = x.split_at_mut(self.linear.order());
        [hysteresis, creep, linear, driver]
    }

    /// Replaces the inputs in `signal` by z, and updates the states of hysteresis block and driver.
    fn hidden(&self, hysteresis: &mut [f64], driver: &mut [f64], signal: &mut [f64]) {
        let (Some(d), [v, z]) = (&self.driver, driver) else { return self.hysteresis.respond(hysteresis, signal) };
        let h = self.ts() / DriverModel::SUBSTEPS as f64;
        for stretch in signal.chunks_mut(DRIVER_BLOCK_SAMPLES) {
            let mut observed = [[0.0; DriverModel::SUBSTEPS]; DRIVER_BLOCK_SAMPLES];
            let observed = &mut observed[..stretch.len()];
            for (voltages, u) in observed.iter_mut().zip(&*stretch) {
                for voltage in voltages {
                    *v = d.advance(*v, *u, h);
                    *voltage = *v;
                }
            }
            self.hysteresis.respond(hysteresis, observed.as_flattened_mut());
            for (mean, after) in stretch.iter_mut().zip(observed) {
                let mut twice = 0.0;
                for next in *after {
                    twice += *z + next;
                    *z = next;
                }
                *mean = twice / (2 * DriverModel::SUBSTEPS) as f64;
            }
        }
    }
}

impl System for Model {
    fn ts(&self) -> f64 {
        self.linear.ts()
    }

    fn order(&self) -> usize {
        let driver = if self.driver.is_some() { 2 } else { 0 };
        let blocks = || self.hysteresis.order() + self.creep.order() + self.linear.order() + driver;
        self.feedback().map_or_else(blocks, FeedbackModel::order)
    }

    fn initial(&self) -> Vec<f64> {
        self.feedback().map_or_else(|| self.initial_blocks(), FeedbackModel::initial)
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        self.feedback().map_or_else(|| self.settled_blocks(u), |feedback| feedback.settled(u))
    }

    /// The checksum of its file without the provenance: equal models have the same.
    fn fingerprint(&self) -> u32 {
        crc32fast::hash(self.numbers().as_bytes())
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let mut signal = [u];
        self.respond(x, &mut signal);
        signal[0]
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        if let Some(feedback) = &self.feedback {
            return feedback.respond(x, signal);
        }
        let [hysteresis, creep, linear, driver] = self.parts(x);
        for stretch in signal.chunks_mut(BLOCK_SAMPLES) {
            self.hidden(hysteresis, driver, stretch);
            self.creep.respond(creep, stretch);
            self.linear.respond(linear, stretch);
            stretch.iter_mut().for_each(|y| *y += self.offset);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::OPERATORS;

    #[test]
    fn a_model_of_every_operator_is_bit_identical_after_its_file() {
        for o in OPERATORS {
            let linear = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.2 / 3.0]).unwrap();
            let model = Model::new((o.example)(5e-4).unwrap(), linear, -0.1).unwrap();
            assert!(!model.to_json().contains("identified"));
            let u: Vec<f64> = (0..500).map(|t| 25.0 * (f64::from(t) * 0.1).sin()).collect();
            let model = model.with_identified(Domain::of_input(&u, 5e-4));
            let again = Model::from_json(&model.to_json()).unwrap();
            assert_eq!(again.to_json(), model.to_json());
            assert_eq!(again.identified(), model.identified());
            assert_eq!(again.simulate(&u), model.simulate(&u));
        }
    }

    #[test]
    fn a_run_of_any_model_is_bit_identical_to_its_steps() {
        let u: Vec<f64> = (0..2 * BLOCK_SAMPLES).map(|t| 25.0 * (t as f64 * 0.1).sin()).collect();
        for o in OPERATORS {
            for driver in [None, Some(DriverModel::new(1e-4, Some(2e4)).unwrap())] {
                let hysteresis =
                    (o.example)(5e-4 / if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 }).unwrap();
                let linear = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.2 / 3.0]).unwrap();
                let model = Model::from_blocks(driver, hysteresis, linear, -0.1).unwrap();
                let model = model.with_creep(Creep::logarithmic(5e-4, 0.02, 0.01, 1.0).unwrap()).unwrap();
                let mut x = model.initial();
                let stepped: Vec<f64> = u.iter().map(|&u| model.step(&mut x, u)).collect();
                assert_eq!(model.simulate(&u), stepped, "{}", o.name);
            }
        }
    }

    #[test]
    fn the_errors_about_bad_documents_say_why() {
        let message = |text: &str| Model::from_json(text).unwrap_err().to_string();
        assert!(message("{").contains("not a complete JSON document"));
        assert!(message("{}").contains("no \"piezoid\" schema number"));
        assert!(message(r#"{"piezoid": 7}"#).contains("schema number 7"));
        let model = |rest: &str| message(&format!(r#"{{"piezoid": 1, "ts": 5e-4, {rest}}}"#));
        assert!(
            model(r#""hysteresis": {"operator": "magic"}, "linear": {"a": [], "b": [1]}"#).contains("called `magic`")
        );
        assert!(model(r#""hysteresis": {}, "linear": {"a": [], "b": [1]}"#).contains("no \"operator\""));
        assert!(model(r#""hysteresis": {"operator": "proportional", "gain": 1}"#).contains("missing field `linear`"));
        let backwards = r#""identified": {"u": [3, -3], "hz": null, "slew": 1, "mean": [0, 0]}"#;
        let plain = r#""hysteresis": {"operator": "proportional", "gain": 1}, "linear": {"a": [], "b": [1]}"#;
        assert!(model(&format!("{plain}, {backwards}")).contains("ends from low to high"));
    }

    #[test]
    fn predicting_its_own_simulation_changes_nothing_and_errors_do_not_accumulate() {
        let plays = (hysteresis::Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
        let model = Model::new(plays, block, 2.0).unwrap();
        let model = model.with_creep(Creep::logarithmic(5e-4, 0.01, 0.1, 1.0).unwrap()).unwrap();
        let u: Vec<f64> = (0..400).map(|t| 20.0 * (0.05 * f64::from(t)).sin()).collect();
        let y = model.simulate(&u);
        piezoid_testing::assert_close(&model.predict(&u, &y).unwrap(), &y, 1e-12, 1e-9);
        let mut off = y.clone();
        off[200] += 1.0;
        let predicted = model.predict(&u, &off).unwrap();
        let moved: Vec<usize> = (0..400).filter(|t| (predicted[*t] - y[*t]).abs() > 1e-6).collect();
        assert_eq!(moved, [201, 202]);
        assert!(model.predict(&u, &y[1..]).is_err());
    }
}
