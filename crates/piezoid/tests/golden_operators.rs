//! Hysteresis operators against their definitions, run with numpy and scipy; `golden/operators.py` writes the numbers.

#![allow(clippy::expect_used, clippy::panic)] // a test may stop at what must not happen

#[path = "common/close.rs"]
mod close;
#[path = "common/golden.rs"]
mod golden;

use close::assert_close;
use golden::{numbers, rows};
use piezoid::hysteresis::operator;
use serde_json::Value;

/// The operator that a model file holds, and its name.
fn operator_of(row: &Value) -> (String, std::sync::Arc<dyn piezoid::hysteresis::Hysteresis>) {
    let mut params = row["operator"].as_object().expect("an operator in every row").clone();
    let name = params.remove("operator").and_then(|name| name.as_str().map(String::from)).expect("its name");
    let load = operator(&name).expect("an operator there is").load;
    (name, load(Value::Object(params), 5e-4).expect("parameters that make sense"))
}

#[test]
fn operators_are_their_definitions() {
    let rows = rows(include_str!("golden/operators.json"));
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let (name, block) = operator_of(row);
        let (u, z) = (numbers(row, "u"), numbers(row, "z"));
        let largest = z.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        // Sums are exact but for rounding, equations but for the solver of scipy; Tellinen's integrals are a table.
        let tolerance = match name.as_str() {
            "prandtl-ishlinskii" | "stop" | "krasnoselskii-pokrovskii" => 1e-13,
            "tellinen" => 1e-5,
            _ => 1e-9,
        };
        assert_close(&name, &block.simulate(&u), &z, 0.0, tolerance * largest);
    }
}
