//! The Hammerstein model: hysteresis, then linear dynamics, then an offset.
//!
//! ```text
//! u -> hysteresis -> z -> linear -> + offset -> y
//! ```

mod domain;
mod loops;
mod paper;
mod rich;

pub(crate) use paper::proportional;

pub use crate::waveform::dominant_frequency;
pub use domain::Domain;
pub use loops::HiddenLoop;
pub use paper::{Identified, Paper, hidden, identify_paper};
pub use rich::LinearPart;

use crate::error::Error;
use crate::hysteresis::{self, Hysteresis};
use crate::linear::Arx;
use crate::record::{Units, same_sampling};
use crate::system::System;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::Arc;

/// The schema number of model files.
const SCHEMA: u64 = 1;

/// u -> hysteresis -> linear -> y, with the units of the records it was identified on.
///
/// State: that of the hysteresis block, then that of the linear block.
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
    hysteresis: Arc<dyn Hysteresis>,
    linear: Arx,
    offset: f64,
    units: Units,
    identified: Option<Domain>,
    made: Value,
}

impl Model {
    /// The blocks in series; `offset` [output unit] is added to the output.
    ///
    /// # Errors
    /// Refuses blocks of different sampling periods and an offset that is not finite.
    pub fn new(hysteresis: Arc<dyn Hysteresis>, linear: Arx, offset: f64) -> Result<Self, Error> {
        same_sampling("the hysteresis block", hysteresis.ts(), "the linear block", linear.ts())?;
        crate::error::finite("offset", &[offset])?;
        Ok(Model { hysteresis, linear, offset, units: Units::default(), identified: None, made: Value::Null })
    }

    /// The same model, said to be in other units.
    pub fn with_units(self, units: Units) -> Self {
        Model { units, ..self }
    }

    /// The same model with a note on how it was made, kept as `fit` in its file.
    pub fn with_provenance(self, made: Value) -> Self {
        Model { made, ..self }
    }

    /// The same model with the data it was identified on, kept as `identified` in its file.
    pub fn with_identified(self, domain: Domain) -> Self {
        Model { identified: Some(domain), ..self }
    }

    /// u to z.
    pub fn hysteresis(&self) -> &dyn Hysteresis {
        &*self.hysteresis
    }

    /// z to y.
    pub fn linear(&self) -> &Arx {
        &self.linear
    }

    /// Constant in the output [output unit].
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Units of input and output.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The data it was identified on; `None` if it does not say.
    pub fn identified(&self) -> Option<&Domain> {
        self.identified.as_ref()
    }

    /// How the model was made; null if it does not say.
    pub fn provenance(&self) -> &Value {
        &self.made
    }

    /// The model as a JSON document: the same model gives the same bytes.
    pub fn to_json(&self) -> String {
        let document = Document {
            piezoid: SCHEMA,
            ts: self.linear.ts(),
            units: self.units.clone(),
            hysteresis: hysteresis::save(&*self.hysteresis),
            creep: Value::Null,
            linear: Coefficients { a: self.linear.a().to_vec(), b: self.linear.b().to_vec() },
            offset: self.offset,
            identified: self.identified,
            fit: self.made.clone(),
        };
        // A document of strings and finite numbers always serialises.
        serde_json::to_string_pretty(&document).unwrap_or_default() + "\n"
    }

    /// Reads what [`Model::to_json`] wrote.
    ///
    /// # Errors
    /// What is not JSON, not a model, or of another schema number is refused with the place and what to do.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let value: Value =
            serde_json::from_str(text).map_err(|e| Error::Content(format!("not a JSON document: {e}")))?;
        match &value["piezoid"] {
            Value::Number(n) if n.as_u64() == Some(SCHEMA) => {}
            Value::Null => {
                let hint = "not a model file: it has no \"piezoid\" schema number";
                return Err(Error::Content(hint.into()));
            }
            other => {
                return Err(Error::Content(format!(
                    "the model file has schema number {other}, but this version reads {SCHEMA}: read it with the version \
                     that wrote it"
                )));
            }
        }
        let d: Document = serde_json::from_value(value).map_err(|e| Error::Content(format!("model file: {e}")))?;
        if !d.creep.is_null() {
            return Err(Error::Content("the model file has a creep block, which this version does not know".into()));
        }
        let linear = Arx::new(d.ts, d.linear.a, d.linear.b)?;
        let model = Model::new(hysteresis::load(&d.hysteresis, d.ts)?, linear, d.offset)?;
        let identified = d.identified.map(Domain::checked).transpose()?;
        Ok(Model { identified, ..model.with_units(d.units).with_provenance(d.fit) })
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
    hysteresis: Value,
    #[serde(default)]
    creep: Value,
    linear: Coefficients,
    #[serde(default)]
    offset: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    identified: Option<Domain>,
    #[serde(default)]
    fit: Value,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Coefficients {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl System for Model {
    fn ts(&self) -> f64 {
        self.linear.ts()
    }

    fn order(&self) -> usize {
        self.hysteresis.order() + self.linear.order()
    }

    fn initial(&self) -> Vec<f64> {
        [self.hysteresis.initial(), self.linear.initial()].concat()
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        let mut x = self.hysteresis.settled(u);
        let z = self.hysteresis.step(&mut x.clone(), u);
        x.extend(self.linear.settled(z));
        x
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let (hysteresis, linear) = x.split_at_mut(self.hysteresis.order());
        let z = self.hysteresis.step(hysteresis, u);
        self.linear.step(linear, z) + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::OPERATORS;

    #[test]
    fn a_model_of_every_operator_survives_its_file_to_the_bit() {
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
    fn documents_that_are_no_models_say_why() {
        let message = |text: &str| Model::from_json(text).unwrap_err().to_string();
        assert!(message("{").contains("not a JSON document"));
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
}
