//! What the tests of all crates share: comparison of numbers, noise, hostile models, and the report of skipped tests.
//!
//! It uses no other crate of this workspace, so that the lowest can use it.

// Helpers of tests may panic like the tests.
#![allow(clippy::panic)]

mod close;
pub mod hostile;
mod noise;
mod skipped;

pub use close::{assert_close, assert_named_close};
pub use noise::noise;
pub use skipped::skipped;
