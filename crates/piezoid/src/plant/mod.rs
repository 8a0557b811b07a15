//! Twins of piezo benders, from catalogue data and physics: the truth that models are tried on.

mod bouc_wen;
pub mod catalogue;
mod everett;
mod material;
mod preisach;
mod spec;

pub use spec::{BeamSpec, Cantilever, DriverSpec, HysteresisSpec, Logged, Mode, SensorSpec, Spec};
