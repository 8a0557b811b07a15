//! How each text names options and lists.

use piezoid_numerics::words::Words;
use serde_json::Value;

/// The words of a text: each form stands around a name.
pub(crate) struct Forms {
    option: [&'static str; 2],
    list: [&'static str; 2],
}

/// The documentation: options by name, lists as commands.
pub(crate) const REFERENCE: Forms = Forms { option: ["`", "`"], list: ["`piezoid ", "`"] };

/// Docstrings of Python: options as keywords, lists as members of the package.
pub(crate) const KEYWORDS: Forms = Forms { option: ["", ""], list: ["`pz.", "`"] };

impl Words for Forms {
    fn option(&self, name: &str) -> String {
        self.option.join(name)
    }

    fn remedy(&self, name: &str, _: &Value) -> String {
        self.option(name)
    }

    fn list(&self, name: &str) -> String {
        self.list.join(name)
    }
}
