//! The paper, end to end; and pages of a model and its proof.

use crate::error::raised;
use crate::json::object;
use crate::watch::watched;
use piezoid::plant;
use piezoid_report::study::Study;
use pyo3::prelude::*;

/// A study as a document, its figures by name as SVG, its page, and its verdict.
type StudyTuple = (Py<PyAny>, Vec<(String, String)>, String, String);

/// The study of a plant.
#[pyfunction]
pub(crate) fn study(py: Python<'_>, name: &str, seed: u64, progress: Option<Py<PyAny>>) -> PyResult<StudyTuple> {
    let preset = plant::Preset::find(name).map_err(raised)?;
    let done = [watched(py, progress, |progress| Study::run(preset, seed, progress))?];
    let drawn = done[0].figures().into_iter().map(|(name, figure)| (name, figure.svg())).collect();
    Ok((object(py, &Study::to_json(&done))?, drawn, Study::page(&done).html(), done[0].verdict()))
}
