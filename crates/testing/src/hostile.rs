//! Hostile models: legitimate ones in which values are changed.

use serde_json::{Value, json};

/// Number of ways in which a value can be changed.
pub const CHANGES: usize = 30;

/// A document in which one of its `n` values, that of the index `at(n)`, is changed.
pub fn changed(mut document: Value, at: impl Fn(usize) -> usize, how: usize) -> Value {
    let mut found = Vec::new();
    places(&document, "", &mut found);
    if let Some(hit) = document.pointer_mut(&found[at(found.len())]) {
        *hit = value(hit, how);
    }
    document
}

/// The places of all values, as JSON pointers.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.into());
    match value {
        Value::Object(fields) => fields.iter().for_each(|(key, value)| places(value, &format!("{at}/{key}"), found)),
        Value::Array(items) => items.iter().enumerate().for_each(|(k, item)| places(item, &format!("{at}/{k}"), found)),
        _ => {}
    }
}

/// What a value becomes: an extreme number, another type, or itself scaled, repeated or reversed.
fn value(value: &Value, how: usize) -> Value {
    const NUMBERS: [f64; 19] = [
        0.0,
        -0.0,
        5e-324,
        1e-308,
        1e-150,
        1e-12,
        0.5,
        1.0,
        2.0,
        -1.0,
        -1e-9,
        1e3,
        9_007_199_254_740_992.0,
        1e18,
        1e150,
        1e300,
        1.7e308,
        -1.7e308,
        1.8e19,
    ];
    if let Some(number) = NUMBERS.get(how) {
        return match value {
            Value::Array(items) => items.iter().map(|item| self::value(item, how)).collect(),
            _ => json!(number),
        };
    }
    match (how - NUMBERS.len(), value) {
        (0, Value::Array(items)) => items.iter().rev().cloned().collect(),
        (1, Value::Array(items)) => items.iter().chain(items).cloned().collect(),
        (2, Value::Array(items)) => items.iter().take(1).cloned().collect(),
        (3, Value::Array(items)) => items.iter().map(|_| items[0].clone()).collect(),
        (4, Value::Array(items)) if !items.is_empty() => (0..400).map(|k| items[k % items.len()].clone()).collect(),
        (5, Value::Array(items)) => items
            .iter()
            .enumerate()
            .map(|(k, v)| v.as_f64().map_or(v.clone(), |v| json!(v.abs() * [1e9, -1e9][k % 2])))
            .collect(),
        (6, _) => Value::Null,
        (7, _) => json!([]),
        (8, _) => json!("text"),
        (_, Value::Number(n)) => json!(n.as_f64().map(|n| n * if how.is_multiple_of(2) { 1e100 } else { -1e-100 })),
        (_, other) => other.clone(),
    }
}
