//! Several models on the same records.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{object, options};
use crate::model::Model;
use crate::record::Record;
use piezoid_report::report::comparison;
use piezoid_verbs::CompareOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Free runs of named models on named records. Returns a document of figures, and a page.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    models: Vec<(String, Bound<'_, Model>)>,
    records: Vec<(String, Bound<'_, Record>)>,
    settings: &Bound<'_, PyDict>,
) -> PyResult<(Py<PyAny>, String)> {
    let options: CompareOptions = options(settings)?;
    let models = models.into_iter().map(|(name, model)| (name, inner(&model))).collect();
    let records: Vec<_> = records.into_iter().map(|(name, record)| (name, record.get().record.clone())).collect();
    let result =
        py.detach(|| options.on(models, &records).map(|result| (result.to_json(), comparison(&result).html())));
    let (figures, page) = result.map_err(raised)?;
    Ok((object(py, &figures)?, page))
}
