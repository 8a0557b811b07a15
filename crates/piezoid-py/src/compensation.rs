//! From a displacement to a voltage.

use crate::error::{raised, refused};
use crate::json::{members, options};
use crate::model::Model;
use crate::samples::{array, samples, slice};
use crate::watch::in_pieces;
use numpy::PyArray1;
use piezoid::System;
use piezoid::compensation::{Causal, Compensated, FeedForwardSettings};
use piezoid_verbs::CompensateOptions;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;
use serde_json::json;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Settings of a feed-forward.
pub(crate) fn feed_forward_settings(settings: &Bound<'_, PyDict>) -> PyResult<FeedForwardSettings> {
    options::<CompensateOptions>(settings)?.settings().map_err(raised)
}

/// The voltage for a reference, the displacement that the model predicts, and the other results by name.
pub(crate) fn compensated<'py>(
    py: Python<'py>,
    model: &piezoid::Model,
    reference: &Bound<'_, PyAny>,
    settings: &Bound<'_, PyDict>,
) -> PyResult<Bound<'py, PyDict>> {
    let (read, options) = (samples("reference", reference)?, options::<CompensateOptions>(settings)?);
    let r = slice(&read)?;
    let result = py.detach(|| options.of(model, r.to_vec())).map_err(raised)?;
    let Compensated { u, reached, usage, clipped, notes } = result.compensated;
    let document = json!({"usage": usage, "clipped": clipped, "notes": notes});
    members(py, &document, [("u", array(py, u).into_any()), ("reached", array(py, reached).into_any())])
}

/// The inverse of a model, sample by sample; it keeps its state between calls.
#[pyclass(frozen, module = "piezoid")]
#[derive(Debug)]
pub(crate) struct FeedForward {
    causal: Causal,
    state: Mutex<Vec<f64>>,
}

impl FeedForward {
    pub(crate) fn new(model: &piezoid::Model, settings: FeedForwardSettings, delay_samples: usize) -> PyResult<Self> {
        let causal = Causal::new(model, settings, delay_samples).map_err(raised)?;
        let state = Mutex::new(causal.initial());
        Ok(FeedForward { causal, state })
    }

    /// The state. The interpreter's lock is released while waiting. The state left by a failed thread is used.
    fn state(&self, py: Python<'_>) -> MutexGuard<'_, Vec<f64>> {
        self.state.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl FeedForward {
    /// Samples by which the displacement follows the reference.
    #[getter]
    fn delay_samples(&self) -> usize {
        self.causal.delay_samples()
    }

    #[getter]
    fn ts(&self) -> f64 {
        self.causal.ts()
    }

    /// The voltage for this sample of the reference.
    fn step(&self, py: Python<'_>, r: f64) -> f64 {
        self.causal.step(&mut self.state(py), r)
    }

    /// The voltages for the next samples of the reference, from the present state.
    fn resume(&self, py: Python<'_>, reference: &Bound<'_, PyAny>) -> PyResult<Py<PyArray1<f64>>> {
        let read = samples("reference", reference)?;
        let r = slice(&read)?;
        let mut state = self.state(py);
        let x: &mut Vec<f64> = &mut state;
        let u = in_pieces(py, r, |r| self.causal.resume(x, r))?;
        Ok(array(py, u).unbind())
    }

    /// Resets the state: at rest, or settled at `reference`.
    #[pyo3(signature = (reference=None))]
    fn reset(&self, py: Python<'_>, reference: Option<f64>) -> PyResult<()> {
        if let Some(r) = reference.filter(|r| !r.is_finite()) {
            return Err(refused(&format!("reference = {r}: must be a finite number")));
        }
        *self.state(py) = reference.map_or_else(|| self.causal.initial(), |r| self.causal.settled(r));
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!("<FeedForward, delay {} samples, sampling period {} s>", self.causal.delay_samples(), self.causal.ts())
    }
}

/// The library's model, for other files of this crate.
pub(crate) fn inner(model: &Bound<'_, Model>) -> piezoid::Model {
    model.get().model.clone()
}
