//! The operations, by the WebAssembly modules in which the page loads them: a feature of this crate each.

#[cfg(feature = "exports")]
mod exports;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "instruments")]
mod instruments;
#[cfg(feature = "models")]
mod models;
#[cfg(feature = "reports")]
mod reports;

use crate::{Operation, Role};
use piezoid_numerics::options::OptionKind;

/// The operations that are built in: natively all. `instruments` is no module of the page in a browser alone.
pub(crate) const MODULES: &[&[Operation]] = &[
    #[cfg(feature = "files")]
    files::OPERATIONS,
    #[cfg(feature = "models")]
    models::OPERATIONS,
    #[cfg(feature = "reports")]
    reports::OPERATIONS,
    #[cfg(feature = "exports")]
    exports::OPERATIONS,
    #[cfg(feature = "instruments")]
    instruments::OPERATIONS,
];

const NAME: OptionKind = OptionKind::Text("NAME");
const DATA: Role = several("data", 1);
const MODEL: Role = one("model");

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
