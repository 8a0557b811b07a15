//! Tests across modules: against reference numbers, measured data, and random cases.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests may panic

mod csv;
mod golden;
mod golden_dynamics;
mod golden_excitation;
mod golden_linear;
mod golden_operators;
mod golden_spline;
mod measured;
mod measured_data;
mod properties;
mod quality;
mod vectors;
