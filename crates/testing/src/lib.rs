//! What the tests of all crates share: comparison of numbers, reference numbers, the files of every version, results
//! that are kept, measured data, noise, random cases, models with feedback, hostile models, and the report of skipped
//! tests.
//!
//! It uses no other crate of this workspace, so that the lowest can use it.

// Helpers of tests may panic like the tests.
#![allow(clippy::panic)]

mod close;
mod feedback;
pub mod golden;
pub mod hostile;
mod kept;
mod measured;
mod noise;
pub mod random;
mod skipped;
mod vectors;

pub use close::{assert_alike, assert_close, assert_named_close};
pub use feedback::in_feedback;
pub use kept::assert_kept;
pub use measured::measured;
pub use noise::noise;
pub use skipped::skipped;
pub use vectors::vectors;
