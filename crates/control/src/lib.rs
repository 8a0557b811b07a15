//! Compensation (the inverse of a model, shaping, learning) and feedback (controllers, margins, comparison).
//!
//! Users see these through the crate `piezoid`.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod compensation;
pub mod feedback;
