//! The linear block alone: difference equations and their fits.

use crate::error::raised;
use crate::json::{object, options};
use crate::model::finite;
use crate::record::Record;
use crate::samples::{Array, array, samples, slice};
use crate::watch::watched;
use piezoid::linear::{self, Estimator, Orders};
use piezoid::{IdentifyOptions, System};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use serde_json::json;

/// y = a1 y1 + a2 y2 + ... + b0 u + b1 u1 + ...
#[pyclass(frozen, eq, module = "piezoid.linear")]
#[derive(Debug, PartialEq)]
pub(crate) struct Arx {
    arx: linear::Arx,
}

#[pymethods]
impl Arx {
    #[new]
    fn new(a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>, ts: f64) -> PyResult<Self> {
        let (a, b) = (samples("a", a)?, samples("b", b)?);
        linear::Arx::new(ts, slice(&a)?.to_vec(), slice(&b)?.to_vec()).map(|arx| Arx { arx }).map_err(raised)
    }

    #[getter]
    fn ts(&self) -> f64 {
        self.arx.ts()
    }

    #[getter]
    fn a(&self, py: Python<'_>) -> Array {
        array(py, self.arx.a().to_vec())
    }

    #[getter]
    fn b(&self, py: Python<'_>) -> Array {
        array(py, self.arx.b().to_vec())
    }

    #[getter]
    fn dc_gain(&self) -> f64 {
        self.arx.dc_gain()
    }

    #[getter]
    fn is_stable(&self) -> bool {
        self.arx.is_stable()
    }

    /// Poles: frequency [Hz] and damping of each.
    #[getter]
    fn poles(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        object(py, &json!(self.arx.poles()))
    }

    #[getter]
    fn zeros(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        object(py, &json!(self.arx.zeros()))
    }

    fn simulate(&self, py: Python<'_>, u: &Bound<'_, PyAny>) -> PyResult<Array> {
        let settings = samples("u", u)?;
        let u = finite("u", slice(&settings)?)?;
        let y = py.detach(|| self.arx.simulate(u));
        Ok(array(py, y))
    }

    fn predict(&self, py: Python<'_>, u: &Bound<'_, PyAny>, y: &Bound<'_, PyAny>) -> PyResult<Array> {
        let settings = (samples("u", u)?, samples("y", y)?);
        let (u, y) = (finite("u", slice(&settings.0)?)?, finite("y", slice(&settings.1)?)?);
        if u.len() != y.len() {
            let (left, right) = ("u".into(), "y".into());
            return Err(raised(piezoid::Error::Lengths { left, left_len: u.len(), right, right_len: y.len() }));
        }
        let predicted = py.detach(|| self.arx.predict(u, y));
        Ok(array(py, predicted))
    }

    /// Creates the block again from a pickle.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (Vec<f64>, Vec<f64>, f64)) {
        let arx = &slf.get().arx;
        (slf.get_type(), (arx.a().to_vec(), arx.b().to_vec(), arx.ts()))
    }

    fn __repr__(&self) -> String {
        format!("Arx(a={:?}, b={:?}, ts={:?})", self.arx.a(), self.arx.b(), self.arx.ts())
    }
}

/// Fits a block of `orders` (na, nb, delay) to records. Returns it with its residuals and other results.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    records: Vec<Py<Record>>,
    orders: (usize, usize, usize),
    by: &str,
    swarm: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Arx, Py<PyAny>)> {
    let mut own = Vec::with_capacity(records.len());
    for record in &records {
        let (record, first) = (&record.get().record, &records[0].get().record);
        if record.units().u != first.units().u {
            let (found, expected) = (record.units().u.clone(), first.units().u.clone());
            return Err(raised(piezoid::Error::Units { what: "the input of a record".into(), found, expected }));
        }
        own.push(record.output_in(&first.units().y).map_err(raised)?);
    }
    let records = own;
    let (na, nb, delay) = orders;
    let settings = options::<IdentifyOptions>(swarm)?.swarm();
    let estimator = Estimator::find(by).map_err(raised)?;
    let found =
        watched(py, progress, |progress| estimator.fit(&records, Orders { na, nb, delay }, &settings, progress))?;
    let beside = json!({
        "estimator": found.estimator, "offsets": found.offsets, "residuals": found.residuals, "history": found.history,
    });
    Ok((Arx { arx: found.arx }, object(py, &beside)?))
}
