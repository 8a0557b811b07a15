//! Several models on the same records, and methods that are identified from one split of them.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{object, options};
use crate::model::Model;
use crate::record::Record;
use crate::samples::{samples, slice};
use crate::watch::watched_until;
use piezoid_report::report::{comparison, leaderboard};
use piezoid_verbs::{CompareOptions, Contest, ModelComparison, Other, Times};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Instant;

/// Named records.
type Named<'py> = Vec<(String, Bound<'py, Record>)>;

/// Free runs of named models on named records. Returns a document of figures, and a page.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    models: Vec<(String, Bound<'_, Model>)>,
    records: Named<'_>,
    settings: &Bound<'_, PyDict>,
) -> PyResult<(Py<PyAny>, String)> {
    let options: CompareOptions = options(settings)?;
    let models = models.into_iter().map(|(name, model)| (name, inner(&model))).collect();
    let records = owned(records);
    let result =
        py.detach(|| options.on(models, &records).map(|result| (result.to_json(), comparison(&result).html())));
    let (figures, page) = result.map_err(raised)?;
    Ok((object(py, &figures)?, page))
}

/// The parts to fit; the whole records of the comparison, each with the first sample that counts.
type Parts = (Vec<Record>, Vec<(Record, usize)>);

/// The split of records, for methods of these names beside those of the options.
#[pyfunction]
pub(crate) fn split(
    records: (Named<'_>, Named<'_>, Named<'_>),
    methods: Vec<String>,
    settings: &Bound<'_, PyDict>,
) -> PyResult<Parts> {
    let options: CompareOptions = options(settings)?;
    let others = methods
        .into_iter()
        .map(|name| Other { name, runs: Ok(Vec::new()), parameters: None, times: Times::default() })
        .collect();
    let (training, small_signal, data) = (owned(records.0), owned(records.1), owned(records.2));
    let contest = Contest { training, small_signal, data, others, ..Contest::default() };
    let split = options.split(&contest).map_err(raised)?;
    let parts = split.training.into_iter().map(|(_, record)| record.into()).collect();
    Ok((parts, split.tests.into_iter().map(|test| (test.record.into(), test.from)).collect()))
}

/// A method of Python: its name, its free runs or the reason why there are none, the number of its parameters, and the
/// times of its fit [s] and of a step [ns].
type Simulator<'py> = (String, (Vec<Bound<'py, PyAny>>, Option<String>), Option<usize>, Option<f64>, Option<f64>);

/// A comparison: a document of figures, a page, a drawing as SVG, and the times of each method.
type Compared = (Py<PyAny>, String, Option<String>, Vec<(String, Option<f64>, Option<f64>)>);

/// Identified methods, models and free runs on one split: training records, small-signal records, records to compare
/// on. What was compared until an exception stops the work is the attribute `compared` of the exception.
#[pyfunction]
pub(crate) fn contest(
    py: Python<'_>,
    models: Vec<(String, Bound<'_, Model>)>,
    records: (Named<'_>, Named<'_>, Named<'_>),
    settings: &Bound<'_, PyDict>,
    others: Vec<Simulator<'_>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Compared> {
    let options: CompareOptions = options(settings)?;
    let (training, small_signal, data) = records;
    let runs = |runs: Vec<Bound<'_, PyAny>>| -> PyResult<Vec<Vec<f64>>> {
        runs.iter().map(|y| samples("y", y).and_then(|y| Ok(slice(&y)?.to_vec()))).collect()
    };
    let other = |(name, (found, reason), parameters, fit_s, step_ns): Simulator<'_>| {
        let runs = reason.map_or_else(|| runs(found).map_err(|error| error.value(py).to_string()), Err);
        Other { name, runs, parameters, times: Times { fit_s, step_ns } }
    };
    let contest = Contest {
        training: owned(training),
        small_signal: owned(small_signal),
        data: owned(data),
        models: models.into_iter().map(|(name, model)| (name, inner(&model))).collect(),
        others: others.into_iter().map(other).collect(),
    };
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let mut until_then = None;
    let work = |progress: &mut piezoid::progress::Progress| options.contest(contest, Some(&clock), progress);
    let result = watched_until(py, progress, work, |stopped| {
        until_then = Some(stopped);
        None
    });
    match (result, until_then) {
        (Err(error), Some(stopped)) => {
            // Not every exception takes an attribute.
            let _ = error.value(py).setattr("compared", shown(py, &stopped)?);
            Err(error)
        }
        (result, _) => shown(py, &result?),
    }
}

fn shown(py: Python<'_>, found: &ModelComparison) -> PyResult<Compared> {
    let (figures, page, drawing) =
        py.detach(|| (found.to_json(), comparison(found).html(), leaderboard(found).map(|figure| figure.svg())));
    let times = found.models.iter().map(|one| (one.name.clone(), one.times.fit_s, one.times.step_ns)).collect();
    Ok((object(py, &figures)?, page, drawing, times))
}

fn owned(records: Named<'_>) -> Vec<(String, piezoid::Record)> {
    records.into_iter().map(|(name, record)| (name, record.get().record.clone())).collect()
}
