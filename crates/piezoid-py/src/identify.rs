//! From records to a model.

use crate::error::{raised, refused};
use crate::json::options;
use crate::model::Model;
use crate::record::Record;
use crate::watch::watched;
use piezoid::hammerstein::Identified;
use piezoid::optimize::swarm::GlobalBest;
use piezoid::{IdentifyOptions, Records, identify_with_progress};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// The model, which has on it how it was made: `provenance`, and what was found on the way.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    records: (Vec<Py<Record>>, Vec<Py<Record>>),
    given: &Bound<'_, PyDict>,
    provenance: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let options: IdentifyOptions = options(given)?;
    let own = |records: &[Py<Record>]| records.iter().map(|r| r.get().record.clone()).collect::<Vec<_>>();
    let (small, large) = (own(&records.0), own(&records.1));
    let records = Records { small_signal: &small, large_signal: &large };
    let found: Identified = watched(py, progress, |progress| identify_with_progress(records, &options, progress))?;
    let mut made: Value = serde_json::from_str(provenance).map_err(|e| refused(&e.to_string()))?;
    for (name, known) in
        [("trials", json!(found.trials)), ("parameters", json!(found.parameters)), ("notes", json!(found.notes))]
    {
        if known != json!([]) {
            made[name] = known;
        }
    }
    Ok(found.model.with_provenance(made).into())
}

/// The options of [`identify`], a row each.
#[pyfunction]
pub(crate) fn identify_options(py: Python<'_>) -> PyResult<Py<PyAny>> {
    crate::json::rows::<IdentifyOptions>(py)
}

/// The swarm's g_best by its name.
pub(crate) fn global_best(name: Option<String>) -> PyResult<GlobalBest> {
    name.map_or(Ok(GlobalBest::default()), |name| GlobalBest::find(&name).map_err(raised))
}
