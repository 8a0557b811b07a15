//! Models: hysteresis operators, linear blocks, creep, the driver, the Hammerstein model of these in series, and the
//! language of exported steps.
//!
//! Users see these through the crate `piezoid`.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

#[cfg(test)]
mod tests;

pub mod creep;
pub mod driver;
pub mod elementary;
pub mod feedback;
pub mod hammerstein;
pub mod hysteresis;
pub mod linear;
pub mod program;
