//! Models: from a voltage to a displacement, and the inverse.

use crate::compensation::FeedForward;
use crate::error::{Keywords, raised, refused};
use crate::json::{members, object, options};
use crate::record::Record;
use crate::samples::{Array, array, samples, slice};
use crate::watch::in_pieces;
use numpy::{Complex64, PyArray1};
use piezoid::compensation::Compensated;
use piezoid::hammerstein::InitialCondition;
use piezoid::validation::ValidateOptions;
use piezoid::{StatedVerdict, System, Validate};
use piezoid_report::dcc;
use piezoid_report::report::certificate;
use piezoid_verbs::{CertificateOptions, CompensateOptions, sha256};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// A Hammerstein model: hysteresis, creep, then linear dynamics.
#[pyclass(frozen, eq, module = "piezoid", weakref)]
#[derive(Debug, PartialEq)]
pub(crate) struct Model {
    pub(crate) model: piezoid::Model,
}

impl From<piezoid::Model> for Model {
    fn from(model: piezoid::Model) -> Self {
        Model { model }
    }
}

#[pymethods]
impl Model {
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        piezoid::Model::from_json(text).map(Self::from).map_err(raised)
    }

    fn to_json(&self) -> String {
        self.model.to_json()
    }

    #[getter]
    fn ts(&self) -> f64 {
        self.model.ts()
    }

    #[getter]
    fn units(&self) -> (&str, &str) {
        let units = self.model.units();
        (&units.u, &units.y)
    }

    #[getter]
    fn operator(&self) -> &'static str {
        self.model.hysteresis().operator().name
    }

    #[getter]
    fn offset(&self) -> f64 {
        self.model.offset()
    }

    #[getter]
    fn a(&self, py: Python<'_>) -> Array {
        array(py, self.model.linear().a().to_vec())
    }

    #[getter]
    fn b(&self, py: Python<'_>) -> Array {
        array(py, self.model.linear().b().to_vec())
    }

    #[getter]
    fn dc_gain(&self) -> f64 {
        self.model.linear().dc_gain()
    }

    /// Operator, gain, modes, creep and sampling period in one line.
    #[getter]
    fn line(&self) -> String {
        self.model.to_string()
    }

    /// How good the model is: as a document, and in words.
    #[getter]
    fn verdict(&self, py: Python<'_>) -> PyResult<Option<(Py<PyAny>, String)>> {
        let Some(verdict) = self.model.verdict() else { return Ok(None) };
        Ok(Some((object(py, &json!(verdict))?, verdict.to_string())))
    }

    /// Frequency [Hz] and damping ratio of the resonance.
    #[getter]
    fn resonance(&self) -> Option<(f64, f64)> {
        self.model.linear().resonance().map(|mode| (mode.hz, mode.damping))
    }

    /// Lowest and highest input of the identification data.
    #[getter]
    fn input_range(&self) -> Option<(f64, f64)> {
        self.model.known_inputs()
    }

    /// Frequency response of the linear block at these frequencies [Hz].
    fn response<'py>(&self, py: Python<'py>, hz: &Bound<'py, PyAny>) -> PyResult<Py<PyArray1<Complex64>>> {
        let hz = samples("hz", hz)?;
        let hz = finite("hz", slice(&hz)?)?;
        let at = |hz: &f64| {
            let found = self.model.linear().response(*hz);
            Complex64::from_polar(found.gain, found.phase)
        };
        Ok(PyArray1::from_vec(py, hz.iter().map(at).collect()).unbind())
    }

    #[pyo3(signature = (u, begin="rest"))]
    fn simulate(&self, py: Python<'_>, u: &Bound<'_, PyAny>, begin: &str) -> PyResult<Array> {
        let settings = samples("u", u)?;
        let u = finite("u", slice(&settings)?)?;
        let initial_condition = initial_condition(begin, u)?;
        let mut x = py.detach(|| self.model.before(u, initial_condition));
        let y = match self.model.interpolates() {
            true => py.detach(|| self.model.follow(&mut x, u)),
            false => in_pieces(py, u, |u| self.model.resume(&mut x, u))?,
        };
        Ok(array(py, y))
    }

    /// The standard deviation of the free run.
    fn deviation(&self, py: Python<'_>, u: &Bound<'_, PyAny>, begin: &str) -> PyResult<Array> {
        let settings = samples("u", u)?;
        let u = finite("u", slice(&settings)?)?;
        let initial_condition = initial_condition(begin, u)?;
        let found = py.detach(|| self.model.deviation(&self.model.before(u, initial_condition), u));
        let none = "needs a model whose operator states one, in series with its mechanics: identify it with \
                    operator=\"gaussian-process\"";
        found.map(|found| array(py, found)).ok_or_else(|| refused(&format!("deviation {none}")))
    }

    /// Prediction one step ahead, from measured outputs.
    fn predict(&self, py: Python<'_>, u: &Bound<'_, PyAny>, y: &Bound<'_, PyAny>) -> PyResult<Array> {
        let settings = (samples("u", u)?, samples("y", y)?);
        let (u, y) = (finite("u", slice(&settings.0)?)?, finite("y", slice(&settings.1)?)?);
        let predicted = py.detach(|| self.model.predict(u, y)).map_err(raised)?;
        Ok(array(py, predicted))
    }

    /// The output of hysteresis and creep for this input.
    fn hidden(&self, py: Python<'_>, u: &Bound<'_, PyAny>) -> PyResult<Array> {
        let settings = samples("u", u)?;
        let u = finite("u", slice(&settings)?)?;
        let z = py.detach(|| self.model.simulate_before_linear(u));
        Ok(array(py, z))
    }

    /// The figures of a free run as a document, and the free run.
    fn _validate(&self, py: Python<'_>, record: &Record, settings: &Bound<'_, PyDict>) -> PyResult<(Py<PyAny>, Array)> {
        let options: ValidateOptions = options(settings)?;
        let v = py.detach(|| self.model.validate_with(&record.record, &options)).map_err(raised)?;
        let figures = json!({
            "unit": record.record.units().y, "start": v.start, "initial_condition": v.initial_condition,
            "metrics": v.metrics, "summary": v.summary, "floor": v.floor, "offset": v.offset, "offset_removed": v.offset_removed,
            "drift_per_s": v.drift_per_s, "nrmse_without_drift_percent": v.nrmse_without_drift_percent,
            "by_frequency": v.by_frequency, "by_amplitude": v.by_amplitude, "loops": v.loops,
            "whiteness": v.whiteness, "advice": v.advice, "remarks": v.remarks, "unproven": v.not_covered,
        });
        Ok((object(py, &figures)?, array(py, v.simulated)))
    }

    /// The certificate of predictions as a document, and as a page; and its XML, or why there is none.
    fn _certificate(
        &self,
        py: Python<'_>,
        records: Vec<Py<Record>>,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<(Py<PyAny>, String, Option<String>, String)> {
        let options: CertificateOptions = options(settings)?;
        let named = |(k, record): (usize, &Py<Record>)| {
            let Record { record, origin, .. } = record.get();
            let origin = origin.clone().unwrap_or_default();
            let name = if origin.file.is_empty() { format!("record {}", k + 1) } else { origin.file.clone() };
            (name, record.clone(), origin)
        };
        let records = records.iter().enumerate().map(named).collect();
        let hash = sha256(self.model.to_json().as_bytes());
        let found = py.detach(|| options.on(&self.model, &hash, records)).map_err(raised)?;
        let (xml, why) = match dcc(&found) {
            Ok(xml) => (Some(xml), String::new()),
            Err(error) => (None, error.message(&Keywords)),
        };
        Ok((object(py, &found.to_json())?, certificate(&found).html(), xml, why))
    }

    fn _inverse(&self, delay_samples: usize, settings: &Bound<'_, PyDict>) -> PyResult<FeedForward> {
        let settings = options::<CompensateOptions>(settings)?.settings().map_err(raised)?;
        FeedForward::new(&self.model, settings, delay_samples)
    }

    /// The voltage for a reference, the displacement that the model predicts, and the other results by name; if it
    /// `offers` one, also the smoothing that keeps the voltage within the rates of the training data.
    fn _compensation<'py>(
        &self,
        py: Python<'py>,
        reference: &Bound<'_, PyAny>,
        settings: &Bound<'_, PyDict>,
        offers: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (read, options) = (samples("reference", reference)?, options::<CompensateOptions>(settings)?);
        let r = slice(&read)?;
        let compensated = || options.of(&self.model, r.to_vec()).map_err(|e| options.advised(&self.model, r, e));
        let result = py.detach(compensated).map_err(raised)?;
        let smoothing = offers.then(|| py.detach(|| options.smoothing(&self.model, &result))).flatten();
        let Compensated { u, reached, usage, clipped, mut notes } = result.compensated;
        notes.extend(smoothing.as_ref().map(|smoothing| smoothing.note(&Keywords)));
        let document = json!({"usage": usage, "clipped": clipped, "notes": notes, "smoothing": smoothing});
        members(py, &document, [("u", array(py, u).into_any()), ("reached", array(py, reached).into_any())])
    }

    /// The content of its file.
    fn to_dict(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let document: Value = serde_json::from_str(&self.model.to_json())
            .map_err(|e| refused(&format!("the model cannot be converted to a dict: {e}")))?;
        object(py, &document)
    }
}

/// The initial condition of this name, for the input `u`.
fn initial_condition(begin: &str, u: &[f64]) -> PyResult<InitialCondition> {
    match begin {
        "likely" => Ok(InitialCondition::of(u)[0]),
        name => serde_json::from_value(json!(name)).map_err(|_| {
            let rule = "must be rest, settled, from-above, from-below, demagnetised, motion or likely";
            refused(&format!("begin = {begin}: {rule}"))
        }),
    }
}

/// Returns an error if a sample is not finite, because a model would never forget it.
pub(crate) fn finite<'a>(what: &str, samples: &'a [f64]) -> PyResult<&'a [f64]> {
    // The sum is not 0 if a sample is not finite. Only then is the sample searched for.
    if samples.iter().map(|v| v * 0.0).sum::<f64>() == 0.0 {
        return Ok(samples);
    }
    let error = |(index, value): (usize, &f64)| piezoid::Error::NotFinite { what: what.into(), index, value: *value };
    let found = samples.iter().enumerate().find(|(_, v)| !v.is_finite()).map(error);
    found.map_or(Ok(samples), |error| Err(raised(error)))
}
