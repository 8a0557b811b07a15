//! Exports of models.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{members, options};
use crate::model::Model;
use crate::samples::{samples, slice};
use piezoid_export::{ExportOptions, ExportTarget};
use piezoid_host::compiler;
use piezoid_host::files::{self, FileSet};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::json;
use std::path::PathBuf;

/// Writes a file, which is complete or absent.
#[pyfunction]
pub(crate) fn write(path: PathBuf, content: &[u8]) -> PyResult<()> {
    files::write(&path, content).map_err(raised)
}

/// Why a file may be older than others of its run, if it may be.
#[pyfunction]
pub(crate) fn unfinished(path: PathBuf) -> Option<String> {
    files::unfinished(&path)
}

/// Exports a model to a target, and writes the files into a folder if one is given. Returns the files by their paths,
/// the functions with their operations, and notes.
#[pyfunction]
pub(crate) fn export<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    target: &str,
    settings: &Bound<'_, PyDict>,
    reference: Option<Bound<'_, PyAny>>,
    folder: Option<PathBuf>,
    force: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (model, options) = (inner(model), options::<ExportOptions>(settings)?);
    let read = reference.as_ref().map(|r| samples("reference", r)).transpose()?;
    let reference = read.as_ref().map(|r| slice(r)).transpose()?;
    let result = py.detach(|| {
        let result = options.of(target, &model, reference, compiler::here())?;
        let settings = (target, options.name.as_str());
        folder.iter().try_for_each(|folder| FileSet::export(folder, settings, &result, force)?.write())?;
        Ok(result)
    });
    let result = result.map_err(raised)?;
    let files = PyDict::new(py);
    result.files.iter().try_for_each(|file| files.set_item(&file.name, PyBytes::new(py, &file.bytes)))?;
    let document = json!({"functions": result.to_json()["functions"], "notes": result.notes});
    members(py, &document, [("files", files.into_any().unbind())])
}

/// The operators of a list that a target serves: `auto` without the others.
#[pyfunction]
pub(crate) fn served(target: &str, operators: &str) -> PyResult<String> {
    ExportTarget::find(target).and_then(|target| target.operators(operators)).map_err(raised)
}
