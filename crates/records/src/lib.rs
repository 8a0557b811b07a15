//! Measured records: the formats of files, preparation, drive signals and their limits, properties of inputs, and
//! defects.
//!
//! Users see these through the crate `piezoid`.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

#[cfg(test)]
mod tests;

pub mod excitation;
pub mod formats;
pub mod preparation;
pub mod quality;
pub mod record;
pub mod waveform;
