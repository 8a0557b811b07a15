//! PI's General Command Set, GCS 2.0, over TCP: a client, and a controller that is simulated around a plant.
//!
//! Reference: Physik Instrumente, GCS 2.0 commands manual PZ281E, GCS array data format SM146E, E-727 user manual
//! E727T0005. It does not do: several axes at once, serial ports and USB.

mod closed;
mod codes;
mod controller;
#[cfg(test)]
mod faults;
mod line;
mod queries;
mod recording;
mod rest;
mod run;
mod session;
mod simulated;
mod start;
mod stop;
#[cfg(test)]
mod tests;

pub use controller::{Axis, Controller};
pub(crate) use session::Gcs;
pub(crate) use simulated::simulated;
