//! Identification of a model from records.

use crate::json::options;
use crate::model::Model;
use crate::plant::Plant;
use crate::record::Record;
use crate::watch::{watched, watched_until};
use piezoid::control::SimulatedActuator;
use piezoid::progress::Progress;
use piezoid::{IdentifyOptions, Records};
use piezoid_verbs::stand_in as stand_in_of;
use piezoid_verbs::{DataFile, File, identify_again};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The name of the front end in the files of models.
const FRONT_END: &str = "piezoid.identify";

/// Identifies a model. Its `provenance` contains how it was identified, and the results on the way. The best model
/// until an exception stops the work is the attribute `model` of the exception.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    records: (Vec<Py<Record>>, Vec<Py<Record>>),
    settings: &Bound<'_, PyDict>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let options: IdentifyOptions = options(settings)?;
    let origin = |r: &Py<Record>| r.get().origin.clone().unwrap_or_default();
    let origins: Vec<_> = records.0.iter().chain(&records.1).map(origin).collect();
    let (small, large) = (own(&records.0), own(&records.1));
    let records = Records { small_signal: &small, large_signal: &large };
    let work = |progress: &mut Progress| options.identify_and_validate(records, &[], (FRONT_END, &origins), progress);
    let identified = watched_until(py, progress, work, |best| Some(best.found.model.into()))?;
    Ok(identified.found.model.into())
}

fn own(records: &[Py<Record>]) -> Vec<piezoid::Record> {
    records.iter().map(|r| r.get().record.clone()).collect()
}

/// A stand-in for the actuator of a model, from its records.
#[pyfunction]
pub(crate) fn stand_in(
    py: Python<'_>,
    model: Py<Model>,
    records: (Vec<Py<Record>>, Vec<Py<Record>>),
    progress: Option<Py<PyAny>>,
) -> PyResult<Plant> {
    let (small, large) = (own(&records.0), own(&records.1));
    let records = Records { small_signal: &small, large_signal: &large };
    let found = watched(py, progress, |progress| stand_in_of(&model.get().model, records, progress))?;
    Ok(SimulatedActuator::from(found).into())
}

/// Identifies a model again, from its files: the new model, and remarks.
#[pyfunction]
pub(crate) fn again(
    py: Python<'_>,
    model: Py<Model>,
    files: Vec<(String, Vec<u8>)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let files: Vec<DataFile> = files.into_iter().map(|(name, bytes)| File::new(name, bytes).into()).collect();
    let again = watched(py, progress, |progress| identify_again(&model.get().model, &files, progress))?;
    Ok(again.found.model.into())
}
