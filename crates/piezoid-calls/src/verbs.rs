//! The verbs, by the WebAssembly modules in which the page loads them: a feature of this crate each.

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

use crate::{Call, Role};
use piezoid::OptionKind;

/// A WebAssembly module: its name, and its verbs.
#[derive(Debug, Clone, Copy)]
pub struct Module {
    /// Its name, which is that of its feature.
    pub name: &'static str,
    /// Its verbs.
    pub calls: &'static [Call],
}

/// The modules that are built in: natively all. `instruments` is no module of the page in a browser alone.
pub const MODULES: &[Module] = &[
    #[cfg(feature = "files")]
    Module { name: "files", calls: files::CALLS },
    #[cfg(feature = "models")]
    Module { name: "models", calls: models::CALLS },
    #[cfg(feature = "reports")]
    Module { name: "reports", calls: reports::CALLS },
    #[cfg(feature = "exports")]
    Module { name: "exports", calls: exports::CALLS },
    #[cfg(feature = "instruments")]
    Module { name: "instruments", calls: instruments::CALLS },
];

const NAME: OptionKind = OptionKind::Text("NAME");
const MANY: usize = usize::MAX;
const DATA: Role = role("data", 1, MANY);
const MODEL: Role = role("model", 1, 1);

const fn role(name: &'static str, least: usize, most: usize) -> Role {
    Role { name, least, most }
}

/// Series by their names.
fn named<const N: usize>(series: [(&str, &[f64]); N]) -> Vec<(String, Vec<f64>)> {
    series.map(|(name, samples)| (name.to_string(), samples.to_vec())).into()
}
