//! Tests across modules: against reference numbers, and random cases.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests may panic

mod golden_dynamics;
mod golden_linear;
mod golden_operators;
mod kept;
mod properties;
mod vectors;
