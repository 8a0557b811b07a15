//! Twins: simulated actuators for measurements.

use crate::error::raised;
use crate::json::options;
use crate::model::finite;
use crate::samples::{Array, array, samples, slice};
use crate::watch::in_pieces;
use piezoid::System;
use piezoid::control::SimulatedActuator;
use piezoid::plant;
use piezoid::record::{Record, Units};
use piezoid_verbs::SimulateOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A simulated actuator: a twin with its driver and sensor, or a stand-in for a measured one.
#[pyclass(frozen, eq, module = "piezoid")]
#[derive(Debug, PartialEq)]
pub(crate) struct Plant {
    pub(crate) actuator: SimulatedActuator,
}

impl From<SimulatedActuator> for Plant {
    fn from(actuator: SimulatedActuator) -> Self {
        Plant { actuator }
    }
}

#[pymethods]
impl Plant {
    /// The twin called `name`.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Self> {
        let preset = plant::Preset::find(name).map_err(raised)?;
        Ok(SimulatedActuator::from(preset.spec()).into())
    }

    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        SimulatedActuator::from_json(text).map(Self::from).map_err(raised)
    }

    fn to_json(&self) -> PyResult<String> {
        match &self.actuator {
            SimulatedActuator::Twin(spec) => spec.to_json().map_err(raised),
            SimulatedActuator::StandIn(stand_in) => Ok(stand_in.to_json()),
        }
    }

    /// A random actuator: its parameters differ from these by up to the fraction `tolerance`, as within a catalogue's
    /// tolerance; a stand-in also has the spread of its records.
    fn drawn(&self, tolerance: f64, seed: u64, index: u64) -> PyResult<Self> {
        self.actuator.drawn(tolerance, seed, index).map(Self::from).map_err(raised)
    }

    /// The sampling period of a stand-in [s].
    #[getter]
    fn ts(&self) -> Option<f64> {
        match &self.actuator {
            SimulatedActuator::Twin(_) => None,
            SimulatedActuator::StandIn(stand_in) => Some(stand_in.ts()),
        }
    }

    /// The units of a record of it.
    #[getter]
    fn units(&self) -> (String, String) {
        let units = match &self.actuator {
            SimulatedActuator::Twin(_) => Units::default(),
            SimulatedActuator::StandIn(stand_in) => stand_in.units().clone(),
        };
        (units.u, units.y)
    }

    /// What a stand-in consists of, in one sentence.
    #[getter]
    fn sentence(&self) -> Option<String> {
        match &self.actuator {
            SimulatedActuator::Twin(_) => None,
            SimulatedActuator::StandIn(stand_in) => Some(stand_in.to_string()),
        }
    }

    /// The readings, and a text that names the limits that were reached.
    fn _measured(
        &self,
        py: Python<'_>,
        u: &Bound<'_, PyAny>,
        ts: f64,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<(Array, Option<String>)> {
        let (read, options) = (samples("u", u)?, options::<SimulateOptions>(settings)?);
        let u = finite("u", slice(&read)?)?;
        match &self.actuator {
            SimulatedActuator::Twin(spec) => {
                let plant = plant::Plant::new(spec, ts).map_err(raised)?.with_seed(options.seed);
                let mut x = options.before(&plant, u);
                let y = in_pieces(py, u, |u| plant.resume(&mut x, u))?;
                let saturation = plant.saturation(&x);
                Ok((array(py, y), saturation.any().then(|| saturation.to_string())))
            }
            SimulatedActuator::StandIn(stand_in) => {
                Record::same_sampling("the stand-in", stand_in.ts(), "the input", ts).map_err(raised)?;
                let plant = stand_in.plant(options.seed);
                let mut x = plant.before(u, options.begin);
                Ok((array(py, in_pieces(py, u, |u| plant.resume(&mut x, u))?), None))
            }
        }
    }
}
