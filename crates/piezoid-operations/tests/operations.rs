//! The way of a user through the page: drives, a measurement, a model, proof, compensation and code.

#![allow(clippy::unwrap_used, clippy::panic)] // a test may stop at what must not happen

use piezoid::Error;
use piezoid::progress::Stage;
use piezoid_numerics::words::Words;
use piezoid_operations::{Output, Request, catalogue, run};
use piezoid_verbs::File;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::ops::ControlFlow;

fn answer(request: Value, files: &[File]) -> Output {
    let shown = request.to_string();
    let request = Request::of(request).unwrap();
    run(&request, files, &mut Stage::ignore).unwrap_or_else(|error| panic!("{shown}: {error}"))
}

/// The only file of an answer under another name.
fn as_file(name: &str, answer: Output) -> File {
    File::new(name, answer.files.into_iter().next().unwrap().bytes)
}

/// A record of the twin for a sine of this frequency.
fn measured(name: &str, hz: f64) -> File {
    let drive = json!({"kind": "sine", "frequency": hz, "amplitude": 20, "ts": 1e-3, "duration": 1});
    let drive = as_file("u.csv", answer(json!({"call": "excite", "options": drive}), &[]));
    let request = json!({"call": "simulate", "options": {"plant": "pl140"}, "files": {"input": ["u.csv"]}});
    as_file(name, answer(request, &[drive]))
}

#[test]
fn a_record_comes_with_its_cycles_its_line_and_its_spectra() {
    let files = [measured("a.csv", 4.0)];
    for call in ["inspect", "prepare"] {
        let answer = answer(json!({"call": call, "files": {"data": ["a.csv"]}}), &files);
        let series = |name: &str| &answer.series.iter().find(|(known, _)| known == name).unwrap().1;
        let shape = &answer.result["shape"];
        let groups = shape["cycles"]["groups"].as_array().unwrap();
        assert_eq!((groups.len(), &groups[0]["count"], &shape["cycles"]["minor"]), (1, &json!(3), &json!([])));
        // From minimum to minimum, at 187.5 ms and so on: the first of two equal samples.
        assert_eq!(groups[0]["cycles"], json!([[187, 437], [437, 687], [687, 937]]));
        assert!((groups[0]["frequency"].as_f64().unwrap() - 4.0).abs() < 0.01);
        assert!((groups[0]["amplitude"].as_f64().unwrap() - 20.0).abs() < 0.01);
        // The line leaves less of y than any other: its remainder is about 0, and does not go with u.
        let [slope, offset] = ["slope", "offset"].map(|name| shape["line"][name].as_f64().unwrap());
        let left: Vec<f64> = series("u").iter().zip(series("y")).map(|(u, y)| y - offset - slope * u).collect();
        let moment: f64 = left.iter().zip(series("u")).map(|(left, u)| left * u).sum();
        assert!(left.iter().sum::<f64>().abs() < 1e-6 && moment.abs() < 1e-6, "{moment}");
        let (hz, u, y) = (series("hz"), series("u/amplitude"), series("y/amplitude"));
        let top = (0..hz.len()).max_by(|p, q| y[*p].total_cmp(&y[*q])).unwrap();
        assert_eq!((hz.len(), hz[top], hz[499]), (500, 4.0, 500.0));
        assert!((u[top] - 20.0).abs() < 0.1 && (y[top] / u[top] / slope - 1.0).abs() < 0.05, "{} {}", u[top], y[top]);
    }
}

#[test]
fn a_record_becomes_a_model_a_proof_a_voltage_and_code() {
    let files = [measured("a.csv", 4.0), measured("b.csv", 7.0)];
    let request =
        json!({"call": "identify", "options": {"operator": "pi", "order": 2}, "files": {"large_signal": ["a.csv"]}});
    let (mut stages, mut models) = (0, Vec::new());
    let identified = run(&Request::of(request.clone()).unwrap(), &files, &mut |stage: Stage| {
        stages += usize::from(stage.done <= stage.total);
        models.extend(stage.model.filter(|_| stage.what == "prandtl-ishlinskii").map(str::to_string));
        ControlFlow::Continue(())
    });
    let identified = identified.unwrap();
    // The page draws them like models of files.
    let trial = [files[0].clone(), File::new("trial.json", models.pop().unwrap())];
    answer(json!({"call": "validate", "files": {"model": ["trial.json"], "data": ["a.csv"]}}), &trial);
    assert!(stages > 0 && identified.result["sentence"].as_str().unwrap().starts_with("good to "));
    let model = as_file("model.json", identified);
    let stopped = run(&Request::of(request).unwrap(), &files, &mut |_: Stage| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(Error::Cancelled { .. })));

    let [a, b] = files;
    let files = [a, b, model];
    let validated =
        answer(json!({"call": "validate", "files": {"model": ["model.json"], "data": ["b.csv", "a.csv"]}}), &files);
    let names: Vec<&str> = validated.series.iter().map(|(name, _)| &**name).collect();
    let each = ["u", "y", "simulated", "hz", "u/amplitude", "y/amplitude", "error/amplitude"];
    assert_eq!(names, [0, 1].map(|k| each.map(|name| format!("{name}/{k}"))).concat());
    assert_eq!(validated.result["files"][0]["ts"], 1e-3);
    let nrmse = validated.result["files"][1]["nrmse_percent"].as_f64().unwrap();
    assert!(nrmse < 2.0, "{nrmse} % on the record of the identification");

    let timed = answer(
        json!({"call": "timing", "options": {"plant": "pl140", "tolerance": "1um"}, "files": {"model": ["model.json"]}}),
        &files,
    );
    assert_eq!((timed.result["runs"].as_array().unwrap().len(), timed.series.len()), (4, 6));
    assert!(timed.result["step"]["shortest"]["settling_s"].is_number(), "{}", timed.result["fastest"]);

    let path = json!({"kind": "sine", "frequency": 2, "amplitude": 3, "unit": "um", "ts": 1e-3, "duration": 1});
    let reference = as_file("r.csv", answer(json!({"call": "excite", "options": path}), &[]));
    let files = [files.to_vec(), vec![reference]].concat();
    let of = json!({"model": ["model.json"], "reference": ["r.csv"]});
    let result = answer(json!({"call": "compensate", "files": of}), &files);
    let series = |name: &str| &result.series.iter().find(|(known, _)| known == name).unwrap().1;
    // The sine begins with its full speed, which no voltage gives.
    let error = series("requested").iter().zip(series("y")).skip(100).map(|(r, y)| (r - y).abs()).fold(0.0, f64::max);
    assert!(error < 0.01 && series("u").len() == 1000, "{error} um");
    assert!(result.result["sentence"].as_str().unwrap().starts_with("the model is good to "));

    let export = |target: &str| {
        let files_of = json!({"model": ["model.json"]});
        answer(json!({"call": "export", "options": {"target": target, "name": "bender"}, "files": files_of}), &files)
    };
    assert!(export("c").files.iter().any(|file| file.name == "bender.c"));
    let page = answer(json!({"call": "report", "files": {"model": ["model.json"], "data": ["b.csv"]}}), &files);
    assert!(page.files[0].text().unwrap().starts_with("<!DOCTYPE html>"));
    let options = json!({"sensor_linearity": "50nm", "date": "2026-11-30", "country": "CZ"});
    let files_of = json!({"model": ["model.json"], "data": ["b.csv"]});
    let certified = answer(json!({"call": "certificate", "options": options, "files": files_of}), &files);
    let names: Vec<&str> = certified.files.iter().map(|file| &*file.name).collect();
    assert_eq!(names, ["certificate.html", "certificate.xml"]);
    assert!(certified.result["expanded"].as_f64().unwrap() > 0.0);
    let files_of = json!({"model": ["model.json", "model.json"], "data": ["b.csv"]});
    let both = answer(json!({"call": "compare", "files": files_of}), &files);
    assert_eq!((both.result["models"].as_array().map(Vec::len), &*both.files[0].name), (Some(2), "compare.html"));
    let options = json!({"plant": "pl140", "controller": ["gain", "feed-forward"]});
    let run = answer(json!({"call": "control", "options": options, "files": of}), &files);
    assert_eq!((run.series.len(), run.files[0].name.as_str()), (6, "control.html"));
}

#[test]
fn a_plan_and_a_prepared_record_come_as_files() {
    let options = json!({"range": [0, 100], "bandwidth": 20, "driver": "e-610", "capacitance": 1.5e-6});
    let plan = answer(json!({"call": "plan", "options": options}), &[]);
    // Each drive has its spectrum.
    assert_eq!((plan.series.len(), plan.files.len()), (18, 8));
    let record = measured("a.csv", 4.0);
    let options = json!({"decimate": 2});
    let result = answer(json!({"call": "prepare", "options": options, "files": {"data": ["a.csv"]}}), &[record]);
    assert_eq!((result.series[0].1.len(), result.result["record"]["ts"].as_f64()), (500, Some(2e-3)));
}

#[test]
fn forms_can_be_made_of_the_catalogue() {
    let catalogue = catalogue();
    let document = json!(catalogue);
    for (row, operation) in document["operations"].as_array().unwrap().iter().zip(&catalogue.operations) {
        assert_eq!((row["name"].as_str(), row["module"].as_str()), (Some(operation.name), Some(operation.module)));
        assert_eq!(row["options"].as_array().map(Vec::len), Some((operation.options)().len()));
    }
    let option = |operation: &str, option: &str| {
        let row = document["operations"].as_array().unwrap().iter().find(|row| row["name"] == operation).unwrap();
        row["options"].as_array().unwrap().iter().find(|row| row["name"] == option).unwrap().clone()
    };
    assert_eq!(option("plan", "range")["kind"], "pair");
    assert_eq!(option("validate", "offset")["kind"], "choice");
    assert_eq!(option("identify", "driver")["list"], "drivers");
}

/// The words of no front end, which note what they are asked for.
#[derive(Default)]
struct Asked(RefCell<Vec<String>>);

impl Words for Asked {
    fn option(&self, name: &str) -> String {
        self.0.borrow_mut().push(name.into());
        String::new()
    }

    fn remedy(&self, name: &str, _: &Value) -> String {
        self.option(name)
    }

    fn list(&self, name: &str) -> String {
        self.option(name)
    }
}

#[test]
fn helps_name_options_and_lists_that_there_are_and_no_front_end() {
    let catalogue = catalogue();
    let document = json!(catalogue);
    let operations = catalogue.operations.iter().map(|operation| (operation.options)());
    let excitations = catalogue.excitations.iter().map(|excitation| (excitation.rows)());
    for rows in operations.chain(excitations).chain([catalogue.columns.clone()]) {
        for row in &rows {
            let requested = Asked::default();
            let help = row.help_in(&requested);
            for name in requested.0.into_inner() {
                assert!(name == row.list || rows.iter().any(|row| row.name == name), "{}: {name}", row.name);
            }
            assert!(row.list.is_empty() || document[row.list].is_array(), "{}: {}", row.name, row.list);
            assert!(!help.contains("--") && !help.contains("piezoid "), "{}: {help}", row.name);
        }
    }
}

#[test]
fn an_unknown_file_or_option_is_named() {
    let refused = |request: Value| {
        let request = Request::of(request).unwrap();
        run(&request, &[File::new("log.csv", "")], &mut Stage::ignore).unwrap_err().to_string()
    };
    let unknown = refused(json!({"call": "inspect", "files": {"data": ["lag.csv"]}}));
    assert!(unknown.contains("lag.csv") && unknown.contains("log.csv"), "{unknown}");
    let unknown = refused(json!({"call": "study", "options": {"sead": 1}}));
    assert!(unknown.contains("sead") && unknown.contains("seed"), "{unknown}");
    let rule = refused(json!({"call": "excite", "options": {"kind": "sine", "ts": -1, "duration": 1}}));
    assert!(rule.starts_with("ts = -1: must be a positive number"), "{rule}");
}

#[test]
fn records_are_packed_for_others_and_the_archive_is_checked() {
    let files = [measured("a.csv", 4.0), measured("b.csv", 9.0)];
    let options = json!({"licence": "CC0-1.0", "actuator": "a", "driver": "d", "sensor": "s", "who": "w"});
    let request = json!({"call": "contribute", "options": options, "files": {"data": ["a.csv", "b.csv"]}});
    let packed = answer(request.clone(), &files);
    assert_eq!(packed.result["files"][1]["samples"], 1000);
    let archive = as_file("received.zip", packed.clone());
    let checked = answer(json!({"call": "contribute", "files": {"check": ["received.zip"]}}), &[archive]);
    assert_eq!((checked.result, checked.files), (packed.result, Vec::new()));
    // A record that was prepared here is not the measured one.
    let prepared = json!({"a.csv": {"preparation": [{"prepare": {"decimate": 2}}]}});
    let mut request = request;
    request["records"] = prepared;
    let refused = run(&Request::of(request).unwrap(), &files, &mut Stage::ignore).unwrap_err().to_string();
    assert!(refused.starts_with("a.csv: was prepared here"), "{refused}");
}
