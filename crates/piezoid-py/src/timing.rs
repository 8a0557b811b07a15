//! Moves in time.

use crate::compensation::inner;
use crate::json::{object, options};
use crate::model::Model;
use crate::plant::Plant;
use crate::samples::{Array, array, samples, slice};
use crate::watch::watched;
use piezoid_verbs::{Players, TimingOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The displacement of each run, by the name of the run.
type Runs = Vec<(String, Array)>;

/// Times a path. Returns a document of figures, the voltage, the path, and the displacement of each run.
#[pyfunction]
pub(crate) fn timing(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    path: Option<Bound<'_, PyAny>>,
    plant: Option<(String, Py<Plant>)>,
    measured: Option<Bound<'_, PyAny>>,
    settings: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, Array, Array, Runs)> {
    let (model, options) = (inner(model), options::<TimingOptions>(settings)?);
    let read = |name: &str, values: Option<Bound<'_, PyAny>>| {
        let read = values.map(|values| samples(name, &values)).transpose()?;
        read.as_ref().map(|read| slice(read).map(<[f64]>::to_vec)).transpose()
    };
    let (path, measured) = (read("path", path)?, read("measured", measured)?);
    let named = plant.map(|(name, plant)| (name, plant.get().spec.clone()));
    let players = Players { plant: named.as_ref().map(|(name, spec)| (&**name, spec)), measured };
    let found = watched(py, progress, |progress| options.of(&model, path, &players, progress))?;
    let runs = found.runs.iter().zip(&found.displacements);
    let runs = runs.map(|(run, y)| (run.name.clone(), array(py, y.clone()))).collect();
    let figures = object(py, &found.to_json())?;
    Ok((figures, array(py, found.u), array(py, found.path), runs))
}
