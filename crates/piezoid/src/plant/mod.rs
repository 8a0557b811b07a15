//! Twins of piezo benders, from catalogue data and physics: the truth that models are tried on.

mod beam;
mod bouc_wen;
pub mod catalogue;
mod creep;
mod driver;
mod everett;
mod material;
mod preisach;
mod sensor;
mod spec;

pub use spec::{BeamSpec, Cantilever, DriverSpec, HysteresisSpec, Logged, Mode, SensorSpec, Spec};
