//! From records to a model.

use crate::compensation::{given, limits};
use crate::error::{raised, refused};
use crate::model::Model;
use crate::record::Record;
use crate::watch::watched;
use piezoid::driver::Driver;
use piezoid::hammerstein::{Identified, Joint, Paper, identify_joint, identify_paper};
use piezoid::hysteresis::{Reading, Split};
use piezoid::optimize::swarm::{self, GlobalBest};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// A method with its settings.
enum Way {
    Joint(Joint),
    Paper(Paper),
}

/// The model, which has on it how it was made: `provenance`, and what was found on the way.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    records: (Vec<Py<Record>>, Vec<Py<Record>>),
    method: &str,
    settings: &Bound<'_, PyDict>,
    provenance: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let way = way(method, settings)?;
    let own = |records: &[Py<Record>]| records.iter().map(|r| r.get().record.clone()).collect::<Vec<_>>();
    let (small, rich) = (own(&records.0), own(&records.1));
    let found: Identified = watched(py, progress, |progress| match &way {
        Way::Joint(how) => identify_joint(&small, &rich, how, progress),
        Way::Paper(how) => identify_paper(&small, &rich, how, progress),
    })?;
    let mut made: Value = serde_json::from_str(provenance).map_err(|e| refused(&e.to_string()))?;
    for (name, known) in
        [("trials", json!(found.trials)), ("parameters", json!(found.parameters)), ("notes", json!(found.notes))]
    {
        if known != json!([]) {
            made[name] = known;
        }
    }
    Ok(found.model.with_provenance(made).into())
}

/// The driver as a block, where anything is known of it.
fn driver(settings: &Bound<'_, PyDict>) -> PyResult<Option<Driver>> {
    let lag: Option<f64> = given(settings, "driver_lag")?;
    let fastest = Some(limits(settings)?.fastest()).filter(|slew| slew.is_finite());
    if fastest.is_none() && lag.is_none() {
        return Ok(None);
    }
    Driver::new(lag.unwrap_or(0.0), fastest).map(Some).map_err(raised)
}

fn way(method: &str, settings: &Bound<'_, PyDict>) -> PyResult<Way> {
    match method {
        "joint" => {
            let usual = Joint::default();
            Ok(Way::Joint(Joint {
                operator: given(settings, "operator")?.unwrap_or(usual.operator),
                order: given(settings, "order")?,
                elements: given(settings, "elements")?,
                creep: given(settings, "creep")?.unwrap_or(usual.creep),
                driver: driver(settings)?,
                seed: given(settings, "seed")?.unwrap_or(usual.seed),
            }))
        }
        "paper" => {
            let usual = Paper::default();
            let splits = [("line", Split::Line), ("direction", Split::Direction)];
            let readings = [("held", Reading::Held), ("printed", Reading::Printed)];
            Ok(Way::Paper(Paper {
                order: given(settings, "order")?.unwrap_or(usual.order),
                estimator: given(settings, "estimator")?.unwrap_or(usual.estimator),
                operator: given(settings, "operator")?.unwrap_or(usual.operator),
                split: named(settings, "split", &splits)?.unwrap_or(usual.split),
                bins: given(settings, "bins")?.unwrap_or(usual.bins),
                reading: named(settings, "reading", &readings)?.unwrap_or(usual.reading),
                swarm: swarm::Settings {
                    particles: given(settings, "particles")?.unwrap_or(usual.swarm.particles),
                    iterations: given(settings, "iterations")?.unwrap_or(usual.swarm.iterations),
                    seed: given(settings, "seed")?.unwrap_or(usual.swarm.seed),
                    global_best: global_best(given(settings, "global_best")?)?,
                    ..usual.swarm
                },
            }))
        }
        other => Err(refused(&format!("method = {other}: must be joint or paper"))),
    }
}

/// The swarm's g_best by its name.
pub(crate) fn global_best(name: Option<String>) -> PyResult<GlobalBest> {
    name.map_or(Ok(GlobalBest::default()), |name| GlobalBest::find(&name).map_err(raised))
}

/// One of a few by its name, if it is given.
fn named<T: Clone>(settings: &Bound<'_, PyDict>, what: &str, known: &[(&str, T)]) -> PyResult<Option<T>> {
    let Some(name) = given::<String>(settings, what)? else { return Ok(None) };
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    let found = known.iter().find(|(known, _)| *known == name).map(|(_, value)| value.clone());
    found.map(Some).ok_or_else(|| refused(&format!("{what} = {name}: must be {}", names.join(" or "))))
}
