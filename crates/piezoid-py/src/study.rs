//! The paper's experiment from end to end.

use crate::json::{object, options};
use crate::watch::watched;
use piezoid_report::study::{Study, StudyOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A study as a document, its figures by name as SVG, its page, and its verdict.
type StudyTuple = (Py<PyAny>, Vec<(String, String)>, String, String);

/// The study of a plant.
#[pyfunction]
pub(crate) fn study(py: Python<'_>, settings: &Bound<'_, PyDict>, progress: Option<Py<PyAny>>) -> PyResult<StudyTuple> {
    let options: StudyOptions = options(settings)?;
    let done = watched(py, progress, |progress| options.run(progress))?;
    let drawn = done[0].figures().into_iter().map(|(name, figure)| (name, figure.svg())).collect();
    Ok((object(py, &Study::to_json(&done))?, drawn, Study::page(&done).html(), done[0].verdict()))
}
