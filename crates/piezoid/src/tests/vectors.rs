//! The files `operators` of every version (a model of every operator, inputs and outputs), the reference of every
//! language: library, exports and Python reproduce them bit-identically. `bench/src/vectors.rs` writes those of this
//! version.

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
fn every_operator_gives_the_numbers_that_it_gave_in_every_version() {
    let versions = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compatibility");
    let folders = std::fs::read_dir(versions).unwrap().map(|entry| entry.unwrap().path().join("operators"));
    let mut names = Vec::new();
    for file in folders.filter(|folder| folder.is_dir()).flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let path = file.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let vectors: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let model = Model::from_json(&vectors["model"].to_string()).unwrap();
        let of = |entry: &str, part: &str| numbers(&vectors[entry][part]);
        assert_eq!(model.simulate(&of("step", "inputs")), of("step", "outputs"), "{}", path.display());
        if !vectors["ff_step"].is_null() {
            let causal = Causal::new(&model, FeedForwardSettings::default(), 0).unwrap();
            assert_eq!(
                causal.simulate(&of("ff_step", "inputs")),
                of("ff_step", "outputs"),
                "{} inverse",
                path.display()
            );
        }
        names.push(name);
    }
    let missing = OPERATORS.iter().map(|o| o.name).chain(["driven"]).find(|name| !names.iter().any(|n| n == name));
    assert_eq!(missing, None, "no file: write it with `cargo xtask generate vectors`");
}
