//! The lists of the library by name, and drive signals.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{document, members, object, options, rows};
use crate::model::Model;
use crate::samples::array;
use numpy::PyArray1;
use piezoid::control::{CONTROLLERS, FEED_FORWARDS, REFERENCES};
use piezoid::excitation::{ACTUATORS, DRIVERS, EXCITATIONS, Excitation};
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::ESTIMATORS;
use piezoid::plant::PLANTS;
use piezoid::{ExciteOptions, PlanOptions};
use piezoid_export::{ExportTarget, TARGETS};
use piezoid_host::files::FileSet;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use std::path::PathBuf;

/// All lists: name, summary and reference of each row; for a drive signal also its parameters, for a driver or an
/// actuator its figures.
#[pyfunction]
pub(crate) fn lists(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let row =
        |name: &str, summary: &str, reference: &str| json!({"name": name, "summary": summary, "reference": reference});
    let figures = |mut all: Value, summary: String, reference: &str| {
        let name = all["name"].take();
        all.as_object_mut().map(|all| ["name", "summary", "reference"].map(|key| all.remove(key)));
        json!({"name": name, "summary": summary, "reference": reference, "figures": all})
    };
    let excitation = |e: &Excitation| {
        let mut row = row(e.name, e.summary, e.reference);
        row["parameters"] = rows((e.rows)());
        row
    };
    let operator = |o: &&piezoid::hysteresis::Operator| {
        let mut row = row(o.name, o.summary, o.reference);
        row["properties"] =
            json!({"minor_loops": o.minor_loops, "rate_independent": o.rate_independent, "wipes_out": o.wipes_out});
        row
    };
    let target = |t: &ExportTarget| {
        let mut row = row(t.name, t.summary, t.reference);
        row["operators"] = OPERATORS.iter().map(|o| (o.name.to_string(), json!(t.serves(o)))).collect();
        row
    };
    let feeds = FEED_FORWARDS.iter().map(|f| row(f.name, f.summary, f.reference));
    let controllers: Vec<Value> =
        feeds.chain(CONTROLLERS.iter().map(|c| row(c.name, c.summary, c.reference))).collect();
    let all = json!({
        "operators": OPERATORS.iter().map(operator).collect::<Vec<_>>(),
        "excitations": EXCITATIONS.iter().map(excitation).collect::<Vec<_>>(),
        "plants": PLANTS.iter().map(|p| row(p.name, p.summary, p.reference)).collect::<Vec<_>>(),
        "drivers": DRIVERS.iter().map(|d| figures(json!(d), d.description(), d.reference)).collect::<Vec<_>>(),
        "actuators": ACTUATORS.iter().map(|a| figures(json!(a), a.description(), a.reference)).collect::<Vec<_>>(),
        "controllers": controllers,
        "targets": TARGETS.iter().map(target).collect::<Vec<_>>(),
        "estimators": ESTIMATORS.iter().map(|e| row(e.name, e.summary, e.reference)).collect::<Vec<_>>(),
        "references": REFERENCES.iter().map(|r| row(r.name, r.summary, "")).collect::<Vec<_>>(),
    });
    object(py, &all)
}

/// The voltages of a drive signal.
#[pyfunction]
pub(crate) fn excite(
    py: Python<'_>,
    name: &str,
    common: &Bound<'_, PyDict>,
    own: &Bound<'_, PyDict>,
) -> PyResult<Py<PyArray1<f64>>> {
    let (excitation, own) = (Excitation::find(name).map_err(raised)?, document(own)?);
    let common: ExciteOptions = options(common)?;
    let made = py.detach(|| common.run(excitation, own)).map_err(raised)?;
    Ok(array(py, made.u).unbind())
}

/// The drives of an identification with their sampling period; the page, notes and advice. Files are written into a
/// folder if one is given.
#[pyfunction]
pub(crate) fn plan<'py>(
    py: Python<'py>,
    given: &Bound<'_, PyDict>,
    model: Option<&Bound<'_, Model>>,
    folder: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let (options, model) = (options::<PlanOptions>(given)?, model.map(inner));
    let made = py.detach(|| {
        let plan = options.run(model.as_ref())?;
        folder.iter().try_for_each(|folder| FileSet::in_folder(folder, &plan.files()?)?.write())?;
        Ok(plan)
    });
    let plan = made.map_err(raised)?;
    let document = json!({"ts": plan.ts, "page": plan.page(), "notes": plan.notes, "advice": plan.advice});
    let drives = PyDict::new(py);
    plan.drives.into_iter().try_for_each(|drive| drives.set_item(drive.name, array(py, drive.u)))?;
    members(py, &document, [("drives", drives.into_any())])
}
