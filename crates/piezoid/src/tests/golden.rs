//! Reading of golden files; a missing number ends the test.

use serde_json::Value;

/// The rows of a file written by a script of `golden/`.
#[track_caller]
pub(crate) fn rows(json: &str) -> Vec<Value> {
    serde_json::from_str(json).expect("a golden file is a list of rows")
}

#[track_caller]
pub(crate) fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key].as_str().unwrap_or_else(|| panic!("{key} is a text in every row"))
}

#[track_caller]
pub(crate) fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} is a number in every row"))
}

/// The numbers under `key`; null is not allowed.
#[track_caller]
pub(crate) fn numbers(row: &Value, key: &str) -> Vec<f64> {
    let list = row[key].as_array().unwrap_or_else(|| panic!("{key} is a list in every row"));
    list.iter().map(|v| v.as_f64().unwrap_or_else(|| panic!("{key} holds numbers, not {v}"))).collect()
}
