//! piezoid turns measured voltage/displacement records of piezo actuators into models that predict them.
//!
//! The library does no input or output: no files, clock, printing or threads it was not asked for. Seeds are
//! parameters, and the same input gives the same bytes.

pub mod error;
pub mod excitation;
pub mod formats;
pub mod hysteresis;
pub mod linear;
pub mod optimize;
pub mod page;
pub mod plant;
pub mod plot;
pub mod record;
pub mod system;
#[cfg(test)]
mod testing;

pub use error::Error;
pub use record::{Record, Units};
pub use system::System;
