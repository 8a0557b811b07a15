//! Controllers of piezo actuators over TCP, with PI's General Command Set, GCS 2.0, or the commands of piezosystem
//! jena's NV200, and generators with oscilloscopes that speak SCPI: clients that play a drive and return the measured
//! record, and controllers that are simulated around a plant.
//!
//! ```
//! use piezoid::{formats::ColumnSelection, progress::Stage};
//! use piezoid_verbs::{DataFile, File};
//! use piezoid_instruments::{AcquireOptions, ConnectOptions, InstrumentOptions, Simulation};
//! use std::net::TcpListener;
//!
//! let listener = TcpListener::bind("127.0.0.1:0")?;
//! let port = listener.local_addr()?.port();
//! let controller = Simulation::default().controller()?;
//! std::thread::spawn(move || controller.serve(&listener));
//!
//! let drive: DataFile = File::new("drive.csv", "t_s,u_V\n0,0\n0.001,5\n0.002,10\n0.003,5\n0.004,0\n").into();
//! let connection = ConnectOptions { port, ..ConnectOptions::default() };
//! let instrument = InstrumentOptions { connection, ramp: 0.0, ..InstrumentOptions::default() };
//! let options = AcquireOptions { instrument, settle: 0.0, ..AcquireOptions::default() };
//! // The record is kept before the axis moves back to where it was.
//! let (mut notes, mut kept) = (Vec::new(), None);
//! let mut keep = |measured: &piezoid_instruments::Acquired| Ok(kept = Some(measured.record.clone()));
//! let acquired =
//!     options.run(&drive, &ColumnSelection::default(), &mut notes, &mut keep, &mut Stage::ignore)?;
//! assert_eq!(acquired.record.u(), [0.0, 5.0, 10.0, 5.0, 0.0]);
//! assert_eq!(acquired.record.units().y, "um");
//! assert_eq!((kept, acquired.unfinished, acquired.voltage), (Some(acquired.record), None, Some(0.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod acquire;
mod bench;
mod campaign;
mod checks;
mod connect;
#[cfg(test)]
mod faulty;
mod function;
mod gcs;
mod instrument;
#[cfg(test)]
mod measuring;
mod moves;
mod nv200;
mod rest;
mod scpi;
mod simulated;
mod stop;
mod timing;
mod watch;
mod wire;

pub use acquire::{AcquireOptions, Acquired, InstrumentOptions, Keep};
pub use campaign::{Agenda, Campaign, CampaignOptions, Journal, Track};
pub use connect::{ConnectOptions, Protocol};
pub use function::Function;
pub use gcs::{Axis, Controller};
pub use instrument::{Drive, Instrument, Left, Setup};
pub use rest::Rest;
pub use scpi::ScpiOptions;
pub use simulated::{Model, Simulated, Simulation};
pub use timing::{Agree, MeasuredTiming, MeasuredTimingOptions};
pub use watch::shared;
