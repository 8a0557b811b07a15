//! From a displacement to a voltage.

use crate::error::{raised, refused};
use crate::json::{document, object};
use crate::model::Model;
use crate::samples::{Array, array, samples, slice};
use crate::watch::in_pieces;
use piezoid::System;
use piezoid::compensation::{Causal, FeedForwardSettings};
use piezoid_numerics::stepper::{SavedState, Stepper};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;
use serde_json::json;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The inverse of a model, sample by sample; it keeps its state between calls.
#[pyclass(frozen, module = "piezoid")]
#[derive(Debug)]
pub(crate) struct FeedForward(Mutex<Stepper<Causal>>);

impl FeedForward {
    pub(crate) fn new(model: &piezoid::Model, settings: FeedForwardSettings, delay_samples: usize) -> PyResult<Self> {
        // As few as the model allows.
        let delay_samples = if delay_samples == 0 { *Causal::delays(model).start() } else { delay_samples };
        let causal = Causal::new(model, settings, delay_samples).map_err(raised)?;
        Ok(FeedForward(Mutex::new(Stepper::new(causal))))
    }

    /// The inverse with its state. The interpreter's lock is released while waiting. The state left by a failed thread
    /// is used.
    fn stepper(&self, py: Python<'_>) -> MutexGuard<'_, Stepper<Causal>> {
        self.0.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl FeedForward {
    /// Samples by which the displacement follows the reference.
    #[getter]
    fn delay_samples(&self, py: Python<'_>) -> usize {
        self.stepper(py).system().delay_samples()
    }

    #[getter]
    fn ts(&self, py: Python<'_>) -> f64 {
        self.stepper(py).system().ts()
    }

    /// The voltage for this sample of the reference.
    fn step(&self, py: Python<'_>, r: f64) -> f64 {
        self.stepper(py).step(r)
    }

    /// The voltage for this sample of the reference, without advancing.
    fn plan(&self, py: Python<'_>, r: f64) -> f64 {
        self.stepper(py).plan(r)
    }

    /// Advances by the planned sample.
    fn commit(&self, py: Python<'_>) -> PyResult<()> {
        self.stepper(py).commit().map_err(raised)
    }

    /// The voltages for the next samples of the reference, from the present state.
    fn resume(&self, py: Python<'_>, reference: &Bound<'_, PyAny>) -> PyResult<Array> {
        let read = samples("reference", reference)?;
        let r = slice(&read)?;
        let mut guard = self.stepper(py);
        let stepper: &mut Stepper<Causal> = &mut guard;
        let u = in_pieces(py, r, |r| stepper.resume(r))?;
        Ok(array(py, u))
    }

    /// Resets the state: at rest, or settled at `reference`.
    #[pyo3(signature = (reference=None))]
    fn reset(&self, py: Python<'_>, reference: Option<f64>) -> PyResult<()> {
        if let Some(r) = reference.filter(|r| !r.is_finite()) {
            return Err(refused(&format!("reference = {r}: must be a finite number")));
        }
        let mut stepper = self.stepper(py);
        let causal = stepper.system();
        let state = reference.map_or_else(|| causal.initial(), |r| causal.settled(r));
        stepper.set_state(state).map_err(raised)
    }

    /// The state after the last committed sample, as a document.
    fn save_state(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        object(py, &json!(self.stepper(py).save()))
    }

    /// Continues from a saved state.
    fn restore(&self, py: Python<'_>, state: &Bound<'_, PyDict>) -> PyResult<()> {
        let saved: SavedState = serde_json::from_value(document(state)?)
            .map_err(|e| refused(&format!("state: {e}: give a dict that save_state returned")))?;
        self.stepper(py).restore(&saved).map_err(raised)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let stepper = self.stepper(py);
        let causal = stepper.system();
        format!("<FeedForward, delay {} samples, sampling period {} s>", causal.delay_samples(), causal.ts())
    }
}

/// The library's model, for other files of this crate.
pub(crate) fn inner(model: &Bound<'_, Model>) -> piezoid::Model {
    model.get().model.clone()
}
