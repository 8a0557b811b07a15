//! Exports of models.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{object, options, rows};
use crate::model::Model;
use crate::samples::{samples, slice};
use piezoid::Options;
use piezoid_export::ExportOptions;
use piezoid_host::{compiler, files};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// Files by their paths, and notes.
type ExportTuple = (Vec<(String, Py<PyBytes>)>, Vec<String>);

/// Writes a file, which is complete or absent.
#[pyfunction]
pub(crate) fn write(path: PathBuf, content: &[u8]) -> PyResult<()> {
    files::write(&path, content).map_err(raised)
}

/// Exports a model to a target, and writes the files into a folder if one is given.
#[pyfunction]
pub(crate) fn export(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    target: &str,
    given: &Bound<'_, PyDict>,
    reference: Option<Bound<'_, PyAny>>,
    folder: Option<PathBuf>,
) -> PyResult<ExportTuple> {
    let (model, options) = (inner(model), options::<ExportOptions>(given)?);
    let read = reference.as_ref().map(|r| samples("reference", r)).transpose()?;
    let reference = read.as_ref().map(|r| slice(r)).transpose()?;
    let made = py.detach(|| {
        let made = options.of(target, &model, reference, compiler::here())?;
        folder.iter().try_for_each(|folder| files::write_all(folder, &made.files))?;
        Ok(made)
    });
    let made = made.map_err(raised)?;
    let files = made.files.into_iter().map(|file| (file.name, PyBytes::new(py, &file.bytes).unbind()));
    Ok((files.collect(), made.notes))
}

/// The options of [`export`], one per row.
#[pyfunction]
pub(crate) fn export_options(py: Python<'_>) -> PyResult<Py<PyAny>> {
    object(py, &rows(ExportOptions::rows()))
}
