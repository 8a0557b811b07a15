//! Joint identification predicts validation data as docs/accuracy.md says. To save time, the operator is given that
//! `auto` selects, and four frequencies of ten are tested; `src/accuracy.rs` runs all and writes the page.

#![allow(clippy::expect_used, clippy::panic)] // a failing test panics

use piezoid::plant::{Preset, Spec};
use piezoid_bench::accuracy::range;
use piezoid_bench::page::{printed, same};
use piezoid_bench::twin::{KINDS, OUTSIDE, TWINS, Twin, error};
use std::collections::BTreeMap;

const PAGE: &str = include_str!("../../docs/accuracy.md");

/// The method whose figures docs/limits.md has.
const METHOD: &str = "joint, driver given";

/// Frequencies below, at and above the resonance [Hz]. At the last one the driver's current limit distorts every
/// signal.
const FREQUENCIES: [f64; 4] = [5.0, 40.0, 160.0, 400.0];

/// The row of the page that begins with these names.
#[track_caller]
fn row(names: &[&str]) -> BTreeMap<String, String> {
    printed(PAGE, names).expect("one row")
}

/// The row of the page that sums up all errors of a twin.
fn summary(twin: &str) -> BTreeMap<String, String> {
    row(&[&format!("`{twin}`"), METHOD])
}

/// Identifies one twin with the operator of the page, and compares the errors [% rms of peak-to-peak].
#[track_caller]
fn is_predicted(twin: &str) {
    let on_bench = Twin::new(twin).expect("a twin");
    let model = on_bench.joint(summary(twin)["operator"].trim_matches('`'), true).expect("a model").model;
    for kind in &KINDS {
        let row = row(&[&format!("`{twin}`"), kind.name, METHOD]);
        for hz in FREQUENCIES {
            let percent = error(&model, &on_bench.validation(kind, hz).expect("a record"));
            let what = format!("{twin}, {} of {hz} Hz", kind.name);
            same(percent, &row[&hz.to_string()]).unwrap_or_else(|e| panic!("{what}: {e}"));
        }
    }
}

#[test]
fn one_model_of_a_preisach_twin_predicts_every_record_as_the_page_says() {
    is_predicted(TWINS[0]);
}

#[test]
fn one_model_of_a_bouc_wen_twin_predicts_every_record_as_the_page_says() {
    is_predicted(TWINS[1]);
}

#[test]
fn the_readme_has_the_larger_figures_of_the_twins() {
    let largest = |title: &str| {
        let of = |twin: &&str| summary(twin)[title].parse::<f64>().expect("a number");
        TWINS.iter().map(of).fold(0.0, f64::max)
    };
    for twin in TWINS {
        let rows = KINDS.iter().map(|kind| row(&[&format!("`{twin}`"), kind.name, METHOD]));
        let errors: Vec<f64> = rows.flat_map(|row| row.into_values().filter_map(|cell| cell.parse().ok())).collect();
        let [_, median, worst] = range(&errors);
        // Cells have two digits, the summary three.
        for (of_cells, title) in [(median, "median [%]"), (worst, "largest [%]")] {
            let kept: f64 = summary(twin)[title].parse().expect("a number");
            assert!((of_cells - kept).abs() <= 0.05 * kept, "{twin}, {title}: {kept}, but by its rows {of_cells}");
        }
    }
    let (median, worst) = (largest("median [%]"), largest("largest [%]"));
    let figures = format!("a median error of {median} % of peak-to-peak and a largest error of {worst:.1} %.");
    let limits = include_str!("../../docs/limits.md").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(limits.contains(&figures), "docs/limits.md does not say: {figures}");
}

#[test]
fn the_error_at_the_slew_limit_of_the_driver_is_not_hysteresis() {
    let spec = Preset::find(TWINS[1]).expect("a twin").spec().to_json().expect("a specification");
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
    for twin in TWINS.into_iter().chain([OUTSIDE]) {
        for kind in &KINDS {
            let rows = PAGE.lines().filter(|line| line.starts_with(&format!("| `{twin}` | {} |", kind.name)));
            assert_eq!(rows.count(), 4, "{twin}, {}", kind.name);
        }
    }
}
