//! Recursive identification, sample by sample.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{object, options};
use crate::model::Model;
use crate::record::Record;
use crate::watch::watched;
use piezoid_verbs::{OnlineOptions, OnlineRow, OnlineRun};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;
use serde_json::{json, to_value};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A model whose parameters move with the samples.
#[pyclass(frozen, module = "piezoid")]
#[derive(Debug)]
pub(crate) struct Online(Mutex<OnlineRun>);

impl Online {
    /// The run. The interpreter's lock is released while waiting. The state left by a failed thread is used.
    fn run(&self, py: Python<'_>) -> MutexGuard<'_, OnlineRun> {
        self.0.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }
}

/// The parameters by name.
fn by_name(py: Python<'_>, row: &OnlineRow) -> PyResult<Py<PyAny>> {
    object(py, &to_value(row).unwrap_or_default())
}

#[pymethods]
impl Online {
    #[new]
    fn new(model: &Bound<'_, Model>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        let run = options::<OnlineOptions>(settings)?.start_at(inner(model)).map_err(raised)?;
        Ok(Online(Mutex::new(run)))
    }

    /// One sample; the parameters whenever they are due.
    fn step(&self, py: Python<'_>, u: f64, y: f64) -> PyResult<Option<Py<PyAny>>> {
        let row = self.run(py).step(u, y);
        row.map(|row| by_name(py, &row)).transpose()
    }

    /// Follows a record; the parameters each time they were due.
    fn follow(&self, py: Python<'_>, record: &Record, progress: Option<Py<PyAny>>) -> PyResult<Vec<Py<PyAny>>> {
        let mut guard = self.run(py);
        let run: &mut OnlineRun = &mut guard;
        let rows = watched(py, progress, |progress| run.follow(&record.record, &mut |_| Ok(()), progress))?;
        rows.iter().map(|row| by_name(py, row)).collect()
    }

    /// The parameters now.
    fn row(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        by_name(py, &self.run(py).row())
    }

    /// The model with the parameters as they are.
    fn model(&self, py: Python<'_>) -> PyResult<Model> {
        let model = self.run(py).finished(json!("Python")).map_err(raised)?;
        Ok(model.into())
    }

    fn remarks(&self, py: Python<'_>) -> Vec<String> {
        self.run(py).remarks()
    }

    fn samples(&self, py: Python<'_>) -> usize {
        self.run(py).samples()
    }
}
