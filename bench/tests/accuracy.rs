//! Joint identification predicts validation data. To save time, the operator is given and four frequencies of ten are
//! tested; `examples/accuracy.rs` selects the operator with `auto` and runs all, with the results in docs/accuracy.md.

#![allow(clippy::expect_used)] // a failing test panics

#[allow(dead_code)] // the paper's method and the figure are not used
#[path = "../examples/accuracy.rs"]
mod accuracy;

use accuracy::{KINDS, OUTSIDE, TWINS, Twin, error, range};
use piezoid::plant::{Preset, Spec};

/// Frequencies below, at and above the resonance [Hz]. At the last one the driver's current limit distorts every
/// signal.
const FREQUENCIES: [f64; 4] = [5.0, 40.0, 160.0, 400.0];

/// Identifies one twin with one operator, and checks the errors [% rms of peak-to-peak].
#[track_caller]
fn is_predicted(twin: &str, operator: &str) {
    let on_bench = Twin::new(twin).expect("a twin");
    let model = on_bench.joint(operator, true).expect("a model").model;
    let records = KINDS.iter().flat_map(|kind| FREQUENCIES.map(|hz| on_bench.validation(kind, hz).expect("a record")));
    let errors: Vec<f64> = records.map(|record| error(&model, &record)).collect();
    let [_, median, worst] = range(&errors);
    assert!(median <= 0.35 && worst <= 1.2, "{twin} as {operator}: median {median} %, worst {worst} %: {errors:.3?}");
}

#[test]
fn one_model_of_a_preisach_twin_predicts_every_record_within_1_2_percent() {
    is_predicted(TWINS[0], "preisach");
}

#[test]
fn one_model_of_a_bouc_wen_twin_predicts_every_record_within_1_2_percent() {
    is_predicted(TWINS[1], "bouc-wen");
}

#[test]
fn the_error_at_the_slew_limit_of_the_driver_is_not_hysteresis() {
    let spec = (Preset::find(TWINS[1]).expect("a twin").spec)().to_json().expect("a specification");
    let mut spec: serde_json::Value = serde_json::from_str(&spec).expect("JSON");
    spec["hysteresis"]["bouc_wen"]["width"] = 0.0.into();
    let spec = Spec::from_json(&spec.to_string()).expect("a specification");
    let on_bench = Twin::of(&spec).expect("a twin without hysteresis");
    let model = on_bench.joint("proportional", true).expect("a model").model;
    let percent = |hz| error(&model, &on_bench.validation(&KINDS[1], hz).expect("a record"));
    assert!(percent(160.0) < 0.05, "{} % at 160 Hz", percent(160.0));
    assert!((0.7..1.2).contains(&percent(400.0)), "{} % at 400 Hz", percent(400.0));
}

#[test]
fn the_page_of_accuracy_has_every_twin_and_kind() {
    let page = include_str!("../../docs/accuracy.md");
    for twin in TWINS.into_iter().chain([OUTSIDE]) {
        for kind in &KINDS {
            let rows = page.lines().filter(|line| line.starts_with(&format!("| `{twin}` | {} |", kind.name)));
            assert_eq!(rows.count(), 4, "{twin}, {}", kind.name);
        }
    }
}
