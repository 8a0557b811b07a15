//! Control schemes side by side on a twin.

use crate::compensation::inner;
use crate::error::{raised, refused};
use crate::json::{object, options};
use crate::model::Model;
use crate::plant::Plant;
use crate::samples::{Array, array, samples, slice};
use crate::watch::watched;
use piezoid::System;
use piezoid::control::{NamedReference, Reference};
use piezoid_report::report;
use piezoid_verbs::ControlOptions;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// `n` samples of the reference called `name`.
#[pyfunction]
pub(crate) fn follow(py: Python<'_>, name: &str, ts: f64, n: usize, peak: f64, hz: f64) -> PyResult<Array> {
    let kind = Reference::find(name).map_err(raised)?;
    kind.samples(ts, n, peak, hz).map(|r| array(py, r)).map_err(raised)
}

/// Runs each scheme along each reference on a plant. Returns a document of figures, the runs, and a page.
#[pyfunction]
pub(crate) fn control(
    py: Python<'_>,
    plant: (String, Py<Plant>),
    model: &Bound<'_, Model>,
    references: Vec<(String, Bound<'_, PyAny>)>,
    settings: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, Py<PyAny>, String)> {
    let (model, options) = (inner(model), options::<ControlOptions>(settings)?);
    let mut reference = Vec::with_capacity(references.len());
    for (name, r) in &references {
        let r = samples(name, r)?;
        let r = slice(&r)?;
        if r.is_empty() {
            return Err(refused(&format!("{name} is empty: give at least 2 samples")));
        }
        reference.push(NamedReference::new(name.clone(), model.ts(), r.to_vec()));
    }
    let (name, spec) = (plant.0, plant.1.get().actuator.clone());
    let compared = watched(py, progress, |progress| options.along((&name, &spec), &model, reference, progress))?;
    let runs = PyList::empty(py);
    for result in &compared.results {
        for (reference, attempt) in compared.references.iter().zip(&result.attempts) {
            let run = PyDict::new(py);
            run.set_item("controller", result.name())?;
            run.set_item("reference", &reference.name)?;
            match attempt {
                Err(error) => run.set_item("error", error.to_string())?,
                Ok(attempt) => {
                    run.set_item("u", array(py, attempt.run.u.clone()))?;
                    run.set_item("y", array(py, attempt.run.y.clone()))?;
                    run.set_item("r", array(py, attempt.run.r.clone()))?;
                    run.set_item("percent_of_stroke", attempt.tracking.percent_of_stroke)?;
                    run.set_item("notes", attempt.feed_forward.notes.clone())?;
                }
            }
            runs.append(run)?;
        }
    }
    Ok((object(py, &compared.to_json())?, runs.into_any().unbind(), report::tracking(&compared).html()))
}
