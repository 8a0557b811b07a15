//! How each text names options and lists.

use piezoid_numerics::words::Words;
use serde_json::Value;

/// The documentation: options by name, lists as commands.
pub(crate) struct Reference;

/// Docstrings of Python: options as keywords, lists as members of the package.
pub(crate) struct Keywords;

impl Words for Reference {
    fn option(&self, name: &str) -> String {
        format!("`{name}`")
    }

    fn remedy(&self, name: &str, _: &Value) -> String {
        self.option(name)
    }

    fn list(&self, name: &str) -> String {
        format!("`piezoid {name}`")
    }
}

impl Words for Keywords {
    fn option(&self, name: &str) -> String {
        name.into()
    }

    fn remedy(&self, name: &str, _: &Value) -> String {
        self.option(name)
    }

    fn list(&self, name: &str) -> String {
        format!("`pz.{name}`")
    }
}
