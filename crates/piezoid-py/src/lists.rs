//! What there is, by name; and excitations, which are nothing but settings.

use crate::error::{raised, refused};
use crate::json::object;
use crate::samples::array;
use numpy::PyArray1;
use piezoid::control::{CONTROLLERS, FEED_FORWARDS, REFERENCES};
use piezoid::excitation::{DRIVERS, EXCITATIONS, Excitation};
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::ESTIMATORS;
use piezoid::plant::PLANTS;
use piezoid_export::TARGETS;
use pyo3::prelude::*;
use serde_json::{Value, json};

/// All lists: of each row its name, summary and reference, of an excitation its parameters too.
#[pyfunction]
pub(crate) fn lists(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let row =
        |name: &str, summary: &str, reference: &str| json!({"name": name, "summary": summary, "reference": reference});
    let excitation = |e: &piezoid::excitation::Excitation| {
        let parameter = |p: &piezoid::excitation::Parameter| json!({"name": p.name.replace('-', "_"), "unit": p.unit, "default": p.default, "help": p.help});
        let parameters: Vec<Value> = e.parameters.iter().map(parameter).collect();
        json!({"name": e.name, "summary": e.summary, "reference": e.reference, "parameters": parameters})
    };
    let operator = |o: &&piezoid::hysteresis::Operator| {
        let mut row = row(o.name, o.summary, o.reference);
        row["properties"] =
            json!({"minor_loops": o.minor_loops, "rate_independent": o.rate_independent, "wipes_out": o.wipes_out});
        row
    };
    let feeds = FEED_FORWARDS.iter().map(|f| row(f.name, f.summary, f.reference));
    let controllers: Vec<Value> =
        feeds.chain(CONTROLLERS.iter().map(|c| row(c.name, c.summary, c.reference))).collect();
    let all = json!({
        "operators": OPERATORS.iter().map(operator).collect::<Vec<_>>(),
        "excitations": EXCITATIONS.iter().map(excitation).collect::<Vec<_>>(),
        "plants": PLANTS.iter().map(|p| row(p.name, p.summary, p.reference)).collect::<Vec<_>>(),
        "drivers": DRIVERS.iter().map(|d| row(d.name, d.summary, d.reference)).collect::<Vec<_>>(),
        "controllers": controllers,
        "targets": TARGETS.iter().map(|t| row(t.name, t.summary, t.reference)).collect::<Vec<_>>(),
        "estimators": ESTIMATORS.iter().map(|e| row(e.name, e.summary, e.reference)).collect::<Vec<_>>(),
        "references": REFERENCES.iter().map(|r| row(r.name, r.summary, "")).collect::<Vec<_>>(),
    });
    object(py, &all)
}

/// The voltages of an excitation.
#[pyfunction]
pub(crate) fn excite(
    py: Python<'_>,
    name: &str,
    ts: f64,
    duration: f64,
    values: Vec<(String, f64)>,
) -> PyResult<Py<PyArray1<f64>>> {
    let values: Vec<(String, f64)> = values.into_iter().map(|(name, v)| (name.replace('_', "-"), v)).collect();
    let values: Vec<(&str, f64)> = values.iter().map(|(name, v)| (name.as_str(), *v)).collect();
    let excitation = Excitation::find(name).map_err(raised)?;
    // Parameters are keywords here, and written as such.
    let named = |error: piezoid::Error| {
        let keywords = excitation.parameters.iter().filter(|p| p.name.contains('-'));
        refused(&keywords.fold(error.to_string(), |told, p| told.replace(p.name, &p.name.replace('-', "_"))))
    };
    let u = py.detach(|| excitation.samples(ts, duration, &values)).map_err(named)?;
    Ok(array(py, u).unbind())
}
