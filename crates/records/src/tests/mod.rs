//! Tests across modules: files of others, reference numbers, measured data, and random cases.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // tests may panic

mod csv;
mod formats;
mod golden_excitation;
mod kept;
mod properties;
mod quality;
mod selection;
