//! The lists of the library by name, and drive signals.

use crate::compensation::inner;
use crate::error::raised;
use crate::json::{document, members, object, options, rows};
use crate::model::Model;
use crate::plant::Plant;
use crate::samples::{Array, array};
use piezoid::excitation::{EXCITATIONS, Excitation};
use piezoid_host::files::FileSet;
use piezoid_operations::catalogue;
use piezoid_verbs::{ExciteOptions, PlanOptions};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use std::path::PathBuf;

/// The catalogue. Rows of families have name, summary and reference; beside them stand the figures of drivers and
/// actuators, the properties of operators and controllers, and the parameters of drive signals.
#[pyfunction]
pub(crate) fn lists(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let mut all = json!(catalogue());
    let families =
        [("operators", "properties"), ("controllers", "properties"), ("drivers", "figures"), ("actuators", "figures")];
    for (family, beside) in families {
        for row in all[family].as_array_mut().into_iter().flatten() {
            let [name, summary, reference] = ["name", "summary", "reference"].map(|key| row[key].take());
            let mut others = row.take();
            if let Some(others) = others.as_object_mut() {
                others.retain(|key, _| !["name", "summary", "reference", "aliases"].contains(&&**key));
            }
            *row = json!({"name": name, "summary": summary, "reference": reference, beside: others});
        }
    }
    for (row, excitation) in all["excitations"].as_array_mut().into_iter().flatten().zip(EXCITATIONS) {
        row["parameters"] = rows((excitation.rows)());
    }
    for row in all["references"].as_array_mut().into_iter().flatten() {
        row["reference"] = "".into();
    }
    for row in all["targets"].as_array_mut().into_iter().flatten() {
        row.as_object_mut().map(|row| row.remove("takes"));
    }
    object(py, &all)
}

/// The voltages of a drive signal.
#[pyfunction]
pub(crate) fn excite(
    py: Python<'_>,
    name: &str,
    common: &Bound<'_, PyDict>,
    own: &Bound<'_, PyDict>,
) -> PyResult<Array> {
    let (excitation, own) = (Excitation::find(name).map_err(raised)?, document(own)?);
    let common: ExciteOptions = options(common)?;
    let result = py.detach(|| common.run(excitation, own)).map_err(raised)?;
    Ok(array(py, result.u))
}

/// The drives of an identification with their sampling period; the page, notes and advice. Files are written into a
/// folder if one is given.
#[pyfunction]
pub(crate) fn plan<'py>(
    py: Python<'py>,
    settings: &Bound<'_, PyDict>,
    model: Option<&Bound<'_, Model>>,
    plant: Option<(String, Py<Plant>)>,
    folder: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let (options, model) = (options::<PlanOptions>(settings)?, model.map(inner));
    let plant = plant.map(|(name, plant)| (name, plant.get().actuator.clone()));
    let result = py.detach(|| {
        let plan = match &plant {
            Some((name, plant)) => options.rehearsed(model.as_ref(), (name, plant))?,
            None => options.run(model.as_ref())?,
        };
        folder.iter().try_for_each(|folder| FileSet::in_folder(folder, &plan.files()?)?.write())?;
        Ok(plan)
    });
    let plan = result.map_err(raised)?;
    let document = json!({
        "ts": plan.ts, "page": plan.page(), "notes": plan.notes, "advice": plan.advice, "uncertainty": plan.uncertainty,
        "rehearsal": plan.rehearsal,
    });
    let drives = PyDict::new(py);
    plan.drives.into_iter().try_for_each(|drive| drives.set_item(drive.name, array(py, drive.u)))?;
    members(py, &document, [("drives", drives.into_any().unbind())])
}
