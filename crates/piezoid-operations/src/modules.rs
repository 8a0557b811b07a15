//! The operations, by the WebAssembly modules in which the page loads them: a feature of this crate each.

#[cfg(feature = "compensation")]
mod compensation;
#[cfg(feature = "exports")]
mod exports;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "instruments")]
mod instruments;
#[cfg(feature = "models")]
mod models;
#[cfg(feature = "plans")]
mod plans;
#[cfg(any(feature = "reports", feature = "studies"))]
mod project;
#[cfg(feature = "reports")]
mod reports;
#[cfg(any(feature = "files", feature = "models"))]
mod shape;
#[cfg(feature = "studies")]
mod studies;

use crate::{Inputs, Operation, Role};
use piezoid::Error;
use piezoid::control::SimulatedActuator;
use piezoid::plant::Preset;
use piezoid_numerics::options::OptionKind;

/// The operations that are built in: natively all. `instruments` is no module of the page in a browser alone.
pub(crate) const MODULES: &[&[Operation]] = &[
    #[cfg(feature = "files")]
    files::OPERATIONS,
    #[cfg(feature = "plans")]
    plans::OPERATIONS,
    #[cfg(feature = "models")]
    models::OPERATIONS,
    #[cfg(feature = "compensation")]
    compensation::OPERATIONS,
    #[cfg(feature = "reports")]
    reports::OPERATIONS,
    #[cfg(feature = "studies")]
    studies::OPERATIONS,
    #[cfg(feature = "exports")]
    exports::OPERATIONS,
    #[cfg(feature = "instruments")]
    instruments::OPERATIONS,
];

const NAME: OptionKind = OptionKind::Text("NAME");
const DATA: Role = several("data", 1);
const MODEL: Role = one("model");
/// The simulated actuator that `stand-in` wrote, in place of a plant by name.
const STAND_IN: Role = optional("stand_in");

/// One file.
const fn one(name: &'static str) -> Role {
    Role { name, least: 1, many: false }
}

/// One file, or none.
const fn optional(name: &'static str) -> Role {
    Role { name, least: 0, many: false }
}

/// So many files or more.
const fn several(name: &'static str, least: usize) -> Role {
    Role { name, least, many: true }
}

/// Series by their names.
fn named<const N: usize>(series: [(&str, &[f64]); N]) -> Vec<(String, Vec<f64>)> {
    series.map(|(name, samples)| (name.to_string(), samples.to_vec())).into()
}

/// The stand-in among the files, or else the twin called `name`.
fn simulated(inputs: &Inputs, name: &str) -> Result<(String, SimulatedActuator), Error> {
    match inputs.some("stand_in")? {
        Some(file) => {
            let found = file.text().and_then(SimulatedActuator::from_json);
            Ok(("stand-in".into(), found.map_err(|e| e.of(&file.name))?))
        }
        None => Ok((name.into(), Preset::find(name)?.spec().into())),
    }
}

/// The same, if there is a stand-in or a name.
fn some_simulated(inputs: &Inputs, name: Option<&str>) -> Result<Option<(String, SimulatedActuator)>, Error> {
    match (name, inputs.some("stand_in")?) {
        (None, None) => Ok(None),
        (name, _) => simulated(inputs, name.unwrap_or_default()).map(Some),
    }
}
