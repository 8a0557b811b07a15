//! Whatever JSON loads as a model can be used: no use panics, and all end. The calls of the page are tried in
//! crates/piezoid-operations/tests/hostile.rs.

use piezoid_models::creep::Creep;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::OPERATORS;
use piezoid_models::linear::Arx;
use piezoid_testing::hostile::{CHANGES, changed};
use piezoid_testing::in_feedback;
use piezoid_testing::random::config;
use proptest::prelude::*;
use serde_json::{Value, json};
use uses::use_it;

#[path = "../../../../fuzz/uses.rs"]
mod uses;

const TS: f64 = 5e-4;

/// A model of every operator, behind a driver, with creep and a delay, then those with feedback, as JSON.
fn legitimate(operator: usize) -> Value {
    if let Some((_, document)) = operator.checked_sub(OPERATORS.len()).map(|k| in_feedback().swap_remove(k)) {
        return document;
    }
    let hysteresis = (OPERATORS[operator].example)(TS / DriverModel::SUBSTEPS as f64).expect("an example");
    let linear = Arx::new(TS, vec![1.6, -0.8], vec![0.0, 0.1, 0.05]).expect("a block");
    let driver = DriverModel::new(1e-4, Some(6e4)).expect("a driver");
    let model = Model::from_blocks(Some(driver), hysteresis, linear, 2.0).expect("a model");
    let model = model.with_creep(Creep::logarithmic(TS, 0.01, 0.01, 1.0).expect("creep")).expect("the same period");
    let mut document: Value = serde_json::from_str(&model.to_json()).expect("its own file");
    document["identified"] = json!({"u": [-30.0, 30.0], "hz": [5.0, 50.0], "slew": 4000.0, "mean": [0.0, 0.0]});
    document
}

proptest! {
    #![proptest_config(config(600))]

    #[test]
    fn what_loads_as_a_model_can_be_used(
        operator in 0..OPERATORS.len() + in_feedback().len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..CHANGES), 1..3),
    ) {
        let document = changes.iter().fold(legitimate(operator), |model, (at, how)| changed(model, |n| at.index(n), *how));
        if let Ok(model) = Model::from_json(&document.to_string()) {
            use_it(&model);
        }
    }
}

#[test]
fn every_hostile_model_that_once_failed_can_be_used_or_is_refused() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/models");
    let mut loaded = 0;
    for file in std::fs::read_dir(&folder).expect("the seeds of the fuzzer") {
        let text = std::fs::read_to_string(file.expect("an entry").path()).expect("text");
        if let Ok(model) = Model::from_json(&text) {
            use_it(&model);
            loaded += 1;
        }
    }
    assert!(loaded > 20, "only {loaded} load");
}

#[test]
fn a_text_that_is_too_large_for_a_model_is_refused_before_it_is_parsed() {
    let refused = Model::from_json(&" ".repeat((16 << 20) + 1)).unwrap_err().to_string();
    assert_eq!(refused, "not a model file: it has 17 MiB, and models at most 16 MiB");
}
