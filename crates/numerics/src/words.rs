//! How a front end writes the names of options and lists, which the library stores as data.
//!
//! The help of an option names other options as `{option}`, and the list that its names are from as `{list}`. An error
//! holds the setting that it is about, and the options that resolve it, as names and values.

use serde_json::Value;

/// How a front end writes options and lists.
pub trait Words {
    /// The option of this name.
    fn option(&self, name: &str) -> String;

    /// The text of an option that resolves an error, with its value, which is null if only the user knows it.
    fn remedy(&self, name: &str, value: &Value) -> String;

    /// The setting that an error is about, with its value. It may be no option of the front end.
    fn setting(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }

    /// The list of this name, such as `drivers`.
    fn list(&self, name: &str) -> String;
}

/// The parts of a text outside and inside braces, in turn.
pub(crate) fn parts(text: &str) -> impl Iterator<Item = (bool, &str)> {
    text.split(['{', '}']).enumerate().map(|(k, part)| (k % 2 == 1, part))
}
