//! The models of controllers that are simulated, and how to simulate one.

use super::Simulated;
use crate::{gcs, nv200, scpi};
use piezoid::Error;
use piezoid::control::SimulatedActuator;
use piezoid::plant::Preset;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::{Deserialize, Serialize};

/// The model of a simulated controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Model {
    /// PI, several axes, over Ethernet.
    #[default]
    #[serde(rename = "e-727")]
    E727,
    /// PI, over Ethernet.
    #[serde(rename = "e-754")]
    E754,
    /// PI, over a serial line, so it serves one client at a time.
    #[serde(rename = "e-709")]
    E709,
    /// An amplifier with GCS 2.0, without a servo.
    #[serde(rename = "open-loop")]
    OpenLoop,
    /// piezosystem jena NV200/D Net: one axis, one client at a time.
    #[serde(rename = "nv200")]
    Nv200,
    /// An arbitrary waveform generator, an amplifier and an oscilloscope, with SCPI.
    #[serde(rename = "scpi")]
    Scpi,
}

const MODELS: OptionKind = OptionKind::Choice(&[
    ("e-727", "Over Ethernet: several clients at once"),
    ("e-754", "Over Ethernet: several clients at once"),
    ("e-709", "Over a serial line: one client at a time, others are refused"),
    ("open-loop", "An amplifier with a sensor, but without a servo"),
    ("nv200", "piezosystem jena NV200/D Net: its own commands, one client at a time"),
    ("scpi", "An arbitrary waveform generator and an oscilloscope, at two ports"),
]);

impl Model {
    /// Its name, as it states it.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Model::E727 => "E-727",
            Model::E754 => "E-754",
            Model::E709 => "E-709",
            Model::OpenLoop => "open-loop",
            Model::Nv200 => "NV200/D_NET",
            Model::Scpi => "scpi",
        }
    }

    /// Clients that it serves at once.
    pub(crate) fn clients(self) -> usize {
        if matches!(self, Model::E709 | Model::Nv200) { 1 } else { 64 }
    }
}

options! {
    /// How to simulate a controller.
    pub struct Simulation {
        /// The plant of each axis: a twin by its name (see {list}), a JSON file, or records: a stand-in for the
        /// actuator of a model.
        plant: String = "pl140".into(), OptionRow::new(OptionKind::Text("NAME")).list("plants");
        /// Seed of the noise of the sensor of axis 1; that of axis 2 has the next one.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Voltage that an open-loop value of 1 gives; on the model scpi, the gain of the amplifier.
        gain: f64 = 1.0, OptionRow::positive("V");
        /// The model of the controller: its name and the commands that it knows.
        model: Model = Model::default(), OptionRow::new(MODELS);
        /// Number of axes.
        axes: usize = 1, OptionRow::new(OptionKind::Integer(1, 3));
        /// Time that passes with each answer, in place of the clock: the same commands then give the same numbers.
        virtual_time: Option<f64> = None, OptionRow {
            unit: "s", absent: "the clock of this machine",
            ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: 10.0 })
        };
    }
}

impl Simulation {
    /// The controller with the plant of this name.
    ///
    /// # Errors
    /// Returns an error if there is no such plant, and the errors of [`around`](Self::around).
    pub fn controller(&self) -> Result<Simulated, Error> {
        self.around(&self.plant, &Preset::find(&self.plant)?.spec().into())
    }

    /// The controller with this plant, and its name.
    ///
    /// # Errors
    /// Returns an error for more axes than the model has, a gain that it does not have, a plant that does not move or
    /// whose output is no length, and the errors of [`SimulatedActuator::voltages`] and [`SimulatedActuator::played`].
    pub fn around(&self, name: &str, plant: &SimulatedActuator) -> Result<Simulated, Error> {
        match self.model {
            Model::Nv200 => nv200::simulated(self, name, plant),
            Model::Scpi => scpi::simulated(self, name, plant),
            _ => gcs::simulated(self, name, plant),
        }
    }
}
