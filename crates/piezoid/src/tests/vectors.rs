//! The vector files (a model of every operator, inputs and outputs), the reference of every language: library, exports
//! and Python reproduce them bit-identically. `bench/src/vectors.rs` writes them.

use piezoid_control::compensation::{Causal, FeedForwardSettings};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::OPERATORS;
use piezoid_numerics::system::System;
use serde_json::Value;
use std::path::Path;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn every_operator_gives_the_numbers_of_its_vector_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors");
    for name in OPERATORS.iter().map(|o| o.name).chain(["driven"]) {
        let text = std::fs::read_to_string(folder.join(format!("{name}.json")))
            .unwrap_or_else(|e| panic!("{name}.json: {e}: write it with `cargo xtask generate vectors`"));
        let vectors: Value = serde_json::from_str(&text).unwrap();
        let model = Model::from_json(&vectors["model"].to_string()).unwrap();
        let of = |entry: &str, part: &str| numbers(&vectors[entry][part]);
        assert_eq!(model.simulate(&of("step", "inputs")), of("step", "outputs"), "{name}");
        if !vectors["ff_step"].is_null() {
            let causal = Causal::new(&model, FeedForwardSettings::default(), 0).unwrap();
            assert_eq!(causal.simulate(&of("ff_step", "inputs")), of("ff_step", "outputs"), "{name} inverse");
        }
    }
}
