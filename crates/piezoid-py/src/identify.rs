//! Identification of a model from records.

use crate::error::refused;
use crate::json::{object, options, rows};
use crate::model::Model;
use crate::record::Record;
use crate::watch::watched;
use piezoid::{IdentifyOptions, Options, Records};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// Identifies a model. Its `provenance` contains how it was identified, and the results on the way.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    records: (Vec<Py<Record>>, Vec<Py<Record>>),
    given: &Bound<'_, PyDict>,
    made: (String, String),
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let options: IdentifyOptions = options(given)?;
    let own = |records: &[Py<Record>]| records.iter().map(|r| r.get().record.clone()).collect::<Vec<_>>();
    let (small, large) = (own(&records.0), own(&records.1));
    let records = Records { small_signal: &small, large_signal: &large };
    let files: Value = serde_json::from_str(&made.1).map_err(|e| refused(&e.to_string()))?;
    let identified = watched(py, progress, |progress| options.prove(records, &[], &made.0, files, progress))?;
    let mut made = identified.model.provenance().clone();
    made["notes"] = json!(identified.found.told());
    Ok(identified.model.with_provenance(made).into())
}

/// The options of [`identify`], one per row.
#[pyfunction]
pub(crate) fn identify_options(py: Python<'_>) -> PyResult<Py<PyAny>> {
    object(py, &rows(IdentifyOptions::rows()))
}
