//! piezoid turns measured voltage/displacement records of piezo actuators into models that predict them.
//!
//! The library does no input or output: no files, clock, printing or threads it was not asked for. Seeds are
//! parameters, and the same input gives the same bytes.

pub mod compensation;
pub mod control;
pub mod creep;
pub mod driver;
mod elementary;
pub mod error;
pub mod excitation;
pub mod formats;
mod fourier;
pub mod hammerstein;
pub mod hysteresis;
mod identification;
mod intervals;
pub mod linear;
pub mod number;
pub mod optimize;
mod options;
pub mod plant;
pub mod program;
pub mod progress;
pub mod quality;
pub mod record;
pub mod series;
pub mod spline;
pub mod system;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
pub mod validation;
pub mod waveform;

pub use error::Error;
pub use hammerstein::{Identified, Model};
pub use identification::{IdentifyOptions, Method, Records, identify, identify_watched};
pub use options::{OptionRow, Options, Values};
pub use record::{Record, Units};
pub use system::System;
