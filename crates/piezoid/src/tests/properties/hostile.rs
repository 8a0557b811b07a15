//! Whatever JSON loads as a model can be used: no use panics, and all end. The calls of the page are tried in
//! crates/piezoid-operations/tests/hostile.rs.

use super::strategies::*;
use piezoid_control::compensation::{Causal, FeedForward, FeedForwardSettings};
use piezoid_models::creep::Creep;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::OPERATORS;
use piezoid_models::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_testing::hostile::{CHANGES, changed};
use piezoid_testing::in_feedback;
use piezoid_validation::Validate;
use proptest::prelude::*;
use serde_json::{Value, json};

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

/// Uses a model in every way of this crate. Values may become infinite or NaN; nothing may panic or run on.
fn use_it(model: &Model) {
    let ends = model.known_inputs().unwrap_or((-30.0, 30.0));
    let u: Vec<f64> = (0..48).map(|t| ends.0 + (ends.1 - ends.0) * (0.5 + 0.5 * (0.3 * f64::from(t)).sin())).collect();
    let y = model.simulate(&u);
    assert_eq!(y.len(), u.len());
    let _ = (model.settled(u[0]), model.predict(&u, &y), model.effort());
    assert_eq!(Model::from_json(&model.to_json()).map(|again| again.to_json()), Ok(model.to_json()));
    let plain: Vec<f64> = (0..48).map(|t| 25.0 * (0.3 * f64::from(t)).sin()).collect();
    if let Ok(record) = Record::new(model.ts(), plain.clone(), plain.clone()) {
        let _ = model.validate(&record);
    }
    for clip in [false, true] {
        let settings = FeedForwardSettings { clip, iterations: 1, ..Default::default() };
        for r in [&y, &plain] {
            let _ = FeedForward::new(model, settings).map(|inverse| inverse.whole(r));
        }
        for delay_samples in [*Causal::delays(model).start(), 20] {
            let far = [f64::NAN, f64::MAX, 1e300, f64::NEG_INFINITY, f64::MIN, -1e-300];
            let _ = Causal::new(model, settings, delay_samples).map(|causal| {
                let mut x = causal.settled_with_preview(plain[0], &plain[..9]);
                (causal.simulate(&plain), causal.resume(&mut x, &[&far[..], &plain].concat()), causal.settled(f64::NAN))
            });
        }
    }
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
