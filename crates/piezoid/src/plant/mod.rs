//! Twins of piezo benders, from catalogue data and physics: the truth that models are tried on.

pub mod catalogue;
mod spec;

pub use spec::{BeamSpec, Cantilever, DriverSpec, HysteresisSpec, Logged, Mode, SensorSpec, Spec};
