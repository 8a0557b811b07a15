//! The paper, end to end; and pages of a model and its proof.

use crate::error::raised;
use crate::json::object;
use crate::watch::watched;
use piezoid::plant;
use piezoid_report::study::{figures, page, run, to_json, verdict};
use pyo3::prelude::*;

/// A study as a document, its figures by name as SVG, its page, and its verdict.
type Told = (Py<PyAny>, Vec<(String, String)>, String, String);

/// The study of a plant.
#[pyfunction]
pub(crate) fn study(py: Python<'_>, name: &str, seed: u64, progress: Option<Py<PyAny>>) -> PyResult<Told> {
    let preset = plant::find(name).map_err(raised)?;
    let done = [watched(py, progress, |progress| run(preset, seed, progress))?];
    let drawn = figures(&done[0]).into_iter().map(|(name, figure)| (name, figure.svg())).collect();
    Ok((object(py, &to_json(&done))?, drawn, page(&done).html(), verdict(&done[0])))
}
