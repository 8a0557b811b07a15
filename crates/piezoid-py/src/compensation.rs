//! From a displacement to a voltage.

use crate::error::{raised, refused};
use crate::model::Model;
use crate::samples::{Array, array, samples, slice};
use crate::watch::in_pieces;
use piezoid::System;
use piezoid::compensation::{Causal, FeedForwardSettings};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The inverse of a model, sample by sample; it keeps its state between calls.
#[pyclass(frozen, module = "piezoid")]
#[derive(Debug)]
pub(crate) struct FeedForward {
    causal: Causal,
    state: Mutex<Vec<f64>>,
}

impl FeedForward {
    pub(crate) fn new(model: &piezoid::Model, settings: FeedForwardSettings, delay_samples: usize) -> PyResult<Self> {
        // As few as the model allows.
        let delay_samples = if delay_samples == 0 { *Causal::delays(model).start() } else { delay_samples };
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
    fn resume(&self, py: Python<'_>, reference: &Bound<'_, PyAny>) -> PyResult<Array> {
        let read = samples("reference", reference)?;
        let r = slice(&read)?;
        let mut state = self.state(py);
        let x: &mut Vec<f64> = &mut state;
        let u = in_pieces(py, r, |r| self.causal.resume(x, r))?;
        Ok(array(py, u))
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
