//! Reference numbers, which the scripts in `golden/` of this crate write with numpy and scipy. A missing number ends
//! the test.

use serde_json::Value;
use std::path::Path;

/// The file of this name.
#[track_caller]
pub fn file(name: &str) -> Value {
    document(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/{name}.json")))
}

/// What a file of JSON states.
#[track_caller]
pub(crate) fn document(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The rows of a file that is a list.
#[track_caller]
pub fn rows(name: &str) -> Vec<Value> {
    file(name).as_array().unwrap_or_else(|| panic!("{name}.json is a list of rows")).clone()
}

/// The text under `key`.
#[track_caller]
pub fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key].as_str().unwrap_or_else(|| panic!("{key} is a text in every row"))
}

/// The number under `key`.
#[track_caller]
pub fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} is a number in every row"))
}

/// The numbers under `key`; null is not allowed.
#[track_caller]
pub fn numbers(row: &Value, key: &str) -> Vec<f64> {
    let list = row[key].as_array().unwrap_or_else(|| panic!("{key} is a list in every row"));
    list.iter().map(|v| v.as_f64().unwrap_or_else(|| panic!("{key} holds numbers, not {v}"))).collect()
}
