//! Several models on the same records.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{object, options};
use crate::model::Model;
use crate::record::Record;
use piezoid::CompareOptions;
use piezoid_report::report::comparison;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Free runs of named models on named records. Returns a document of figures, and a page.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    models: Vec<(String, Bound<'_, Model>)>,
    records: Vec<(String, Bound<'_, Record>)>,
    given: &Bound<'_, PyDict>,
) -> PyResult<(Py<PyAny>, String)> {
    let options: CompareOptions = options(given)?;
    let models = models.into_iter().map(|(name, model)| (name, inner(&model))).collect();
    let records: Vec<_> = records.into_iter().map(|(name, record)| (name, record.get().record.clone())).collect();
    let made = py.detach(|| options.on(models, &records).map(|made| (made.to_json(), comparison(&made).html())));
    let (figures, page) = made.map_err(raised)?;
    Ok((object(py, &figures)?, page))
}
