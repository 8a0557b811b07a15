//! Twins: simulated actuators for measurements.

use crate::error::raised;
use crate::json::options;
use crate::model::finite;
use crate::samples::{Array, array, samples, slice};
use crate::watch::in_pieces;
use piezoid::System;
use piezoid::plant::{self, Spec};
use piezoid_verbs::SimulateOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A simulated bender with its driver and sensor.
#[pyclass(frozen, eq, module = "piezoid")]
#[derive(Debug, PartialEq)]
pub(crate) struct Plant {
    pub(crate) spec: Spec,
}

#[pymethods]
impl Plant {
    /// The plant called `name`.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Self> {
        plant::Preset::find(name).map(|preset| Plant { spec: preset.spec() }).map_err(raised)
    }

    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Spec::from_json(text).map(|spec| Plant { spec }).map_err(raised)
    }

    fn to_json(&self) -> PyResult<String> {
        self.spec.to_json().map_err(raised)
    }

    /// A random plant whose parameters differ from these by up to the fraction `tolerance`, as within a catalogue's
    /// tolerance.
    fn drawn(&self, tolerance: f64, seed: u64, index: u64) -> PyResult<Self> {
        self.spec.drawn(tolerance, seed, index).map(|spec| Plant { spec }).map_err(raised)
    }

    /// The readings [um], and a text that names the limits that were reached.
    fn _measured(
        &self,
        py: Python<'_>,
        u: &Bound<'_, PyAny>,
        ts: f64,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<(Array, Option<String>)> {
        let (read, options) = (samples("u", u)?, options::<SimulateOptions>(settings)?);
        let u = finite("u", slice(&read)?)?;
        let plant = plant::Plant::new(&self.spec, ts).map_err(raised)?.with_seed(options.seed);
        let mut x = options.before(&plant, u);
        let y = in_pieces(py, u, |u| plant.resume(&mut x, u))?;
        let saturation = plant.saturation(&x);
        Ok((array(py, y), saturation.any().then(|| saturation.to_string())))
    }
}
