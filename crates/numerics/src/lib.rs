//! What the other crates of piezoid compute with: numbers as text, errors, tables of options, progress, complex
//! numbers, Fourier transforms, series, splines, search and optimisation, and the trait of every system.
//!
//! Users see these through the crate `piezoid`.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod complex;
pub mod error;
pub mod fourier;
pub mod intervals;
pub mod noise;
pub mod number;
pub mod optimize;
pub mod options;
pub mod progress;
pub mod series;
pub mod spline;
pub mod stepper;
pub mod student;
pub mod system;
pub mod words;
