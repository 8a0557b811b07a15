//! A campaign on a Python function that plays voltages and returns displacements, or on a simulated actuator.

use crate::error::raised;
use crate::json::{object, options};
use crate::model::Model;
use crate::plant::Plant;
use crate::samples::array;
use crate::watch::watched;
use piezoid::Error;
use piezoid::formats::{ColumnSelection, Table};
use piezoid_host::files::FileSet;
use piezoid_instruments::{Agenda, CampaignOptions, Function, Journal, Track, shared};
use piezoid_verbs::{DataFile, File};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A folder, or nothing.
struct Folder(Option<PathBuf>);

impl Journal for Folder {
    fn agree(&mut self, _: &Agenda) -> Result<(), Error> {
        Ok(())
    }

    fn earlier(&self, name: &str) -> Option<File> {
        Some(File::new(name, std::fs::read(self.0.as_ref()?.join(name)).ok()?))
    }

    fn keep(&mut self, files: Vec<File>) -> Result<(), Error> {
        let Some(folder) = &self.0 else { return Ok(()) };
        FileSet::in_folder(folder, &files).and_then(FileSet::write).map_err(|error| Error::Content(error.to_string()))
    }
}

/// Voltage, requested and measured displacement of a path, by name.
fn track<'py>(py: Python<'py>, track: &Track) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (name, samples) in [("u", track.record.u()), ("r", &track.r), ("y", track.record.y())] {
        columns.set_item(name, array(py, samples.to_vec()))?;
    }
    Ok(columns)
}

/// What a [`Function`] calls: `call(u)` of Python. What that raises is kept, to be raised again.
pub(crate) fn measuring<'a>(
    call: &'a Py<PyAny>,
    raised: &'a mut Option<PyErr>,
) -> impl FnMut(&[f64]) -> Result<Vec<f64>, Error> + 'a {
    |u| {
        let answer = Python::attach(|py| call.call1(py, (array(py, u.to_vec()),))?.extract::<Vec<f64>>(py));
        answer.map_err(|error| {
            let text = error.to_string();
            *raised = Some(error);
            Error::Content(text)
        })
    }
}

/// The model, the path with a straight line and the compensated one, the results as a document, and the page.
type Found<'py> = (Model, Bound<'py, PyDict>, Bound<'py, PyDict>, Py<PyAny>, String);

/// What plays the drives: a function, or a plant with its name.
type Player = (Option<Py<PyAny>>, Option<(String, Py<Plant>)>);

/// Runs a campaign on `call(u)`, which is sampled every `ts` [s] and returns displacements in `unit`; or on a plant by
/// its name, of which only the reference needs both.
#[pyfunction]
pub(crate) fn campaign<'py>(
    py: Python<'py>,
    played: Player,
    rig: (f64, String),
    settings: &Bound<'py, PyDict>,
    paths: (Option<PathBuf>, Option<Vec<f64>>),
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let ((ts, unit), (folder, reference)) = (rig, paths);
    let options = options::<CampaignOptions>(settings)?;
    let of_path = |r: Vec<f64>| Table::write("reference.csv", ts, &[(&format!("r_{unit}"), &r)]);
    let reference = reference.map(of_path).transpose().map_err(raised)?;
    let reference =
        reference.map(|bytes| (DataFile::from(File::new("reference.csv", bytes)), ColumnSelection::default()));
    let (mut exception, mut notes) = (None, Vec::new());
    let (call, plant) = played;
    let plant = plant.map(|(name, plant)| (name, plant.get().actuator.clone()));
    let found = watched(py, progress, |progress| {
        let reference = reference.as_ref().map(|(file, columns)| (file, columns));
        let (mut folder, notes) = (Folder(folder), &mut notes);
        let Some(call) = call else {
            let (name, plant) = plant.as_ref().ok_or_else(|| Error::Content("there is nothing to measure".into()))?;
            return options.rehearse((name, plant), reference, &mut folder, notes, progress);
        };
        let rule = "is needed: give the lowest and highest voltage";
        let range = options.range.ok_or_else(|| Error::parameter("range", "(not given)", rule))?;
        let limits = options.instrument.limits.limits()?.unwrap_or_default();
        shared(progress, |of_function, own| {
            let measure = measuring(&call, &mut exception);
            let function = Function::new(range, ts, Box::new(measure), of_function)?;
            let mut function = function.in_unit(unit).within(limits);
            options.on(&mut function, reference, &mut folder, notes, own)
        })
    });
    // What the function itself raised is raised again.
    let found = found.map_err(|error| exception.unwrap_or(error))?;
    let (straight, compensated) = (track(py, &found.straight)?, track(py, &found.compensated)?);
    let (document, page) = (object(py, &found.to_json())?, found.page().html());
    Ok((found.identification.found.model.into(), straight, compensated, document, page))
}
