//! Moves in time.

use crate::campaign::measuring;
use crate::compensation::inner;
use crate::json::{object, options};
use crate::model::Model;
use crate::plant::Plant;
use crate::samples::{Array, array, samples, slice};
use crate::watch::watched;
use piezoid::compensation::FeedForwardSettings;
use piezoid::progress::Progress;
use piezoid::{Error, System};
use piezoid_instruments::{Function, MeasuredTiming, MeasuredTimingOptions, shared};
use piezoid_verbs::{Players, TimingOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The displacement of each run, by the name of the run.
type Runs = Vec<(String, Array)>;

/// What plays the path beside the model: a plant by name, a displacement that was measured, a function to measure with.
type Played<'py> = (Option<(String, Py<Plant>)>, Option<Bound<'py, PyAny>>, Option<Py<PyAny>>);

/// Times a path. Returns a document of figures, the voltage, the path, and the displacement of each run.
#[pyfunction]
pub(crate) fn timing(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    path: Option<Bound<'_, PyAny>>,
    played: Played<'_>,
    settings: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Py<PyAny>, Array, Array, Runs)> {
    let (model, (plant, measured, call)) = (inner(model), played);
    let read = |name: &str, values: Option<Bound<'_, PyAny>>| {
        let read = values.map(|values| samples(name, &values)).transpose()?;
        read.as_ref().map(|read| slice(read).map(<[f64]>::to_vec)).transpose()
    };
    let (path, measured) = (read("path", path)?, read("measured", measured)?);
    let named = plant.map(|(name, plant)| (name, plant.get().actuator.clone()));
    let players = Players { plant: named.as_ref().map(|(name, spec)| (&**name, spec)), measured };
    let (figures, found) = match call {
        None => {
            let options = options::<TimingOptions>(settings)?;
            let found = watched(py, progress, |progress| options.of(&model, path, &players, progress))?;
            (found.to_json(), found)
        }
        Some(call) => {
            let (options, mut exception) = (options::<MeasuredTimingOptions>(settings)?, None);
            let found = watched(py, progress, |progress| {
                on_function(&options, (&model, path), &players, measuring(&call, &mut exception), progress)
            });
            // What the function itself raised is raised again.
            let found = found.map_err(|error| exception.unwrap_or(error))?;
            (found.to_json(), found.timing)
        }
    };
    let runs = found.runs.iter().zip(&found.displacements);
    let runs = runs.map(|(run, y)| (run.name.clone(), array(py, y.clone()))).collect();
    Ok((object(py, &figures)?, array(py, found.u), array(py, found.path), runs))
}

/// The timing with a function that plays voltages and returns displacements.
fn on_function(
    options: &MeasuredTimingOptions,
    (model, path): (&piezoid::Model, Option<Vec<f64>>),
    players: &Players,
    measure: impl FnMut(&[f64]) -> Result<Vec<f64>, Error>,
    progress: &mut Progress,
) -> Result<MeasuredTiming, Error> {
    let limits = &options.instrument.limits;
    let range = FeedForwardSettings::within(limits, false)?.ends(model)?;
    shared(progress, |of_function, own| {
        let function = Function::new(range, model.ts(), Box::new(measure), of_function)?;
        let mut function = function.in_unit(&*model.units().y).within(limits.limits()?.unwrap_or_default());
        options.on(&mut function, (model, path), players, &mut |_| Ok(()), &mut Vec::new(), own)
    })
}
