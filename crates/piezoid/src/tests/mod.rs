//! Tests across crates: hostile models, and measured data.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests may panic

mod hostile;
mod measured;
