//! piezosystem jena NV200/D Net over TCP: a client, and a controller that is simulated around a plant.
//!
//! Reference: the Python package nv200 1.6.0 of piezosystem jena, whose command list and wire format are followed. It
//! does not do: closed loop, ILC, triggers, serial ports and USB.

mod codes;
#[cfg(test)]
mod faults;
mod line;
mod look;
mod run;
mod session;
mod simulated;
mod stop;
#[cfg(test)]
mod tests;

pub(crate) use session::Nv200;
pub(crate) use simulated::simulated;
