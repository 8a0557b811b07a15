//! How to connect to a controller.

use crate::gcs::Controller;
use crate::nv200::Nv200;
use crate::scpi::Scpi;
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// What a controller speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// PI's General Command Set, GCS 2.0.
    #[default]
    Gcs,
    /// The commands of piezosystem jena's NV200/D Net.
    Nv200,
    /// SCPI: an arbitrary waveform generator with an oscilloscope.
    Scpi,
}

const PROTOCOLS: OptionKind = OptionKind::Choice(&[
    ("gcs", "PI's General Command Set, GCS 2.0"),
    ("nv200", "The commands of piezosystem jena's NV200/D Net"),
    ("scpi", "SCPI: an arbitrary waveform generator before an amplifier, and an oscilloscope"),
]);

options! {
    /// How to connect to a controller.
    pub struct ConnectOptions {
        /// What the controller speaks.
        protocol: Protocol = Protocol::Gcs, OptionRow::new(PROTOCOLS);
        /// Address or name of the controller in the network.
        host: String = "127.0.0.1".into(), OptionRow::new(OptionKind::Text("HOST"));
        /// TCP port of the controller; that of an NV200 is 23, that of an instrument with SCPI 5025 or 5555.
        port: u16 = 50000, OptionRow::new(OptionKind::Integer(1, 65535));
        /// Time for a whole answer.
        timeout: f64 = 5.0, OptionRow { unit: "s", ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: 3600.0 }) };
    }
}

impl ConnectOptions {
    /// Connects to the controller, and asks what it is. Nothing moves. `progress` can cancel it at any moment.
    ///
    /// # Errors
    /// Returns an error if nothing answers there in time, or something that does not speak the protocol.
    pub fn connect(&self, progress: &mut Progress) -> Result<Controller, Error> {
        match self.protocol {
            Protocol::Gcs => Controller::open(self, progress).map(|(_, controller)| controller),
            Protocol::Nv200 => Nv200::look(self, progress),
            Protocol::Scpi => Scpi::look(self, progress),
        }
    }

    pub(crate) fn patience(&self) -> Duration {
        Duration::from_secs_f64(self.timeout.clamp(1e-3, 3600.0))
    }
}
