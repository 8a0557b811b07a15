//! Generated hostile models in every call that takes one: none panics, and each ends within 10 s in a release.
//! `PROPTEST_CASES` tries more.

#![allow(clippy::unwrap_used, clippy::panic)] // a test may stop at what must not happen

use piezoid::progress::Stage;
use piezoid::{Error, Model};
use piezoid_export::TARGETS;
use piezoid_operations::{Request, run};
use piezoid_testing::hostile::{CHANGES, changed};
use piezoid_testing::random::config;
use piezoid_testing::vectors;
use piezoid_verbs::File;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Models unless the environment says otherwise.
const CASES: u32 = 12;

/// Builds for tests are three times slower than releases.
const PATIENCE: Duration = Duration::from_secs(30);

/// The models of the vector files: one of every operator, and one behind a driver. And one that was identified, which
/// states its errors.
fn legitimate(record: &File) -> Vec<Value> {
    let options = json!({"operator": "stop", "order": 2});
    let request = json!({"call": "identify", "options": options, "files": {"large_signal": [record.name]}});
    let answer = run(&Request::of(request).unwrap(), std::slice::from_ref(record), &mut Stage::ignore).unwrap();
    let mut identified: Value = serde_json::from_slice(&answer.files[0].bytes).unwrap();
    // A certificate refuses the records that a model names as its own.
    identified["fit"].as_object_mut().unwrap().remove("files");
    std::iter::once(identified).chain(vectors().into_iter().map(|(_, mut file)| file["model"].take())).collect()
}

/// The calls that take a model, with their options.
fn calls() -> Vec<Value> {
    let path = json!({"model": ["m.json"], "reference": ["r.csv"]});
    let data = json!({"model": ["m.json"], "data": ["d.csv"]});
    let mut calls = vec![
        json!({"call": "simulate", "files": {"model": ["m.json"], "input": ["d.csv"]}}),
        json!({"call": "validate", "files": data}),
        json!({"call": "report", "files": data}),
        json!({"call": "certificate", "files": data, "options": {"voltage_gain": 0.1, "date": "2026-11-30", "country": "CZ"}}),
        json!({"call": "compare", "files": {"model": ["m.json", "m.json"], "data": ["d.csv"]}}),
        json!({"call": "compensate", "options": {"clip": true, "driver": "pl140", "iterations": 1}, "files": path}),
        json!({"call": "control", "options": {"plant": "pl140", "controller": ["feed-forward"]}, "files": path}),
        json!({"call": "plan", "options": {"actuator": "pl140", "bandwidth": 50}, "files": {"model": ["m.json"]}}),
    ];
    calls.push(json!({"call": "online", "files": data}));
    let estimator = json!({"target": "c", "online": true});
    calls.push(json!({"call": "export", "options": estimator, "files": {"model": ["m.json"]}}));
    let export = |target: &str| {
        let files = if target == "waveform" { path.clone() } else { json!({"model": ["m.json"]}) };
        json!({"call": "export", "options": {"target": target}, "files": files})
    };
    calls.extend(TARGETS.iter().map(|target| export(target.name)));
    calls
}

/// A record of a twin, and a path.
fn files() -> [File; 2] {
    let result = |name: &str, request: Value, files: &[File]| {
        let answer = run(&Request::of(request).unwrap(), files, &mut Stage::ignore).unwrap();
        File::new(name, answer.files[0].bytes.clone())
    };
    let sine = |unit: &str, amplitude: f64| {
        let options =
            json!({"kind": "sine", "frequency": 10, "amplitude": amplitude, "unit": unit, "ts": 5e-4, "duration": 0.3});
        json!({"call": "excite", "options": options})
    };
    let drive = result("u.csv", sine("V", 20.0), &[]);
    let simulate = json!({"call": "simulate", "options": {"plant": "pl140"}, "files": {"input": ["u.csv"]}});
    [result("d.csv", simulate, &[drive]), result("r.csv", sine("um", 100.0), &[])]
}

/// Calls with a model; the error is an answer too, and the time that it took.
fn answered(one: &Value, model: &Value, files: &[File]) -> (Result<(), Error>, Duration) {
    let begun = Instant::now();
    let files = [files, &[File::new("m.json", model.to_string())]].concat();
    let is_named = |file: &&File| one["files"].to_string().contains(&file.name);
    let files: Vec<File> = files.iter().filter(is_named).cloned().collect();
    let answer = run(&Request::of(one.clone()).unwrap(), &files, &mut Stage::ignore);
    (answer.map(drop), begun.elapsed())
}

#[test]
fn hostile_models_end_in_every_call() {
    let (calls, files) = (calls(), files());
    let models = legitimate(&files[0]);
    for one in &calls {
        let (answer, _) = answered(one, &models[0], &files);
        assert!(answer.is_ok(), "{one}: {answer:?}");
    }
    let cases = std::env::var("PROPTEST_CASES").map_or(CASES, |cases| cases.parse().unwrap());
    proptest!(config(cases), |(
        which in 0..models.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..CHANGES), 1..3),
    )| {
        let change = |model, (at, how): &(prop::sample::Index, usize)| changed(model, |n| at.index(n), *how);
        let model = changes.iter().fold(models[which].clone(), change);
        if Model::from_json(&model.to_string()).is_ok() {
            for one in &calls {
                let (_, took) = answered(one, &model, &files);
                prop_assert!(took < PATIENCE, "{} took {:?} with {}", one, took, model);
            }
        }
    });
}
