//! Exported code, compiled and run on its target: bit-identical to the library.

#![allow(clippy::unwrap_used, clippy::panic)]

mod c;
mod cortex;
mod fixed;
mod rust;
mod simulink;
mod st;
mod stress;
mod structured_text;

use piezoid::creep::Creep;
use piezoid::driver::DriverModel;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::Arx;
use piezoid::{Error, Model};
use piezoid_export::{ExportRequest, ExportTarget, Exported};
use piezoid_testing::{in_feedback, skipped};
use piezoid_verbs::File;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Sampling period [s].
const TS: f64 = 5e-4;

/// A model of every operator, with creep and a resonance; a model with a driver; and those with hysteresis in feedback.
fn models() -> Vec<(String, Model)> {
    let named = |name: &str| name.replace('-', "_");
    let mut models: Vec<(String, Model)> =
        OPERATORS.iter().map(|o| (named(o.name), model(o.name, None).unwrap())).collect();
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    models.push(("driven_plays".into(), model("prandtl-ishlinskii", Some(driver)).unwrap()));
    let read = |(name, document): (&str, Value)| (name.into(), Model::from_json(&document.to_string()).unwrap());
    models.extend(in_feedback().into_iter().map(read));
    models
}

/// Each model in double and in single precision, under different names.
fn in_both_precisions(models: impl IntoIterator<Item = (String, Model)>) -> Vec<(String, Model, bool)> {
    let both = |(name, model): (String, Model)| [(name.clone(), model.clone(), false), (name + "_single", model, true)];
    models.into_iter().flat_map(both).collect()
}

fn model(name: &str, driver: Option<DriverModel>) -> Result<Model, Error> {
    let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
    let model = Model::from_blocks(driver, (Operator::find(name)?.example)(TS / faster)?, block, 2.0)?;
    model.with_creep(Creep::logarithmic(TS, 0.01, 0.1, 1.0)?)
}

/// Models whose parameters move on the target: few and many plays, weights that stand still, a driver, and the largest
/// estimator that there is.
fn online_models() -> Vec<(String, Model)> {
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    let largest = |model: Model| {
        let block = Arx::new(TS, vec![1.6, -0.9, 0.2], vec![0.0, 1.0, 1.5, 0.5, 0.2]).unwrap();
        let lags = Creep::logarithmic(TS, 0.01, 0.1, 1.0).unwrap();
        model.with_linear(block).unwrap().with_creep(lags).unwrap()
    };
    [
        ("plays", model("prandtl-ishlinskii", None).unwrap()),
        ("stops", model("stop", None).unwrap()),
        ("preisach", model("preisach", None).unwrap()),
        ("driven", model("prandtl-ishlinskii", Some(driver)).unwrap()),
        ("fifteen", cortex::fifteen_plays()),
        ("largest", largest(cortex::fifteen_plays())),
    ]
    .map(|(name, model)| (name.to_string(), model))
    .into()
}

/// Exports a model to `target_name` and writes the files into a folder.
fn exported(target_name: &str, expected: &ExportRequest, folder: &Path) -> Exported {
    let result = (ExportTarget::find(target_name).unwrap().make)(expected).unwrap();
    for File { name, bytes } in &result.files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    result
}

/// True if a tool is installed. If it is not, the test is reported as skipped, and fails in CI.
#[track_caller]
fn there(tool: &str) -> bool {
    let there = Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        skipped(&format!("no {tool}"));
    }
    there
}

const WATCHED: &str = "-fsanitize=address,undefined -fno-sanitize-recover=all";

/// Writes one program of all models into a folder, and returns its files. The program prints the name of each model and
/// calls its `int NAME_part(void)`, whose text is given by `part`.
fn together(folder: &Path, names: &[String], part: impl Fn(&str) -> String) -> String {
    let (mut declared, mut called, mut files) = (String::new(), String::new(), String::from("all.c"));
    for name in names {
        std::fs::write(folder.join(format!("{name}_part.c")), part(name)).unwrap();
        declared += &format!("int {name}_part(void);\n");
        called += &format!("    puts(\"{name}:\");\n    fflush(stdout);\n    failed += {name}_part();\n");
        files += &format!(" {name}.c {name}_part.c");
    }
    let main = format!("int main(void)\n{{\n    int failed = 0;\n{called}    return failed == 0 ? 0 : 1;\n}}\n");
    std::fs::write(folder.join("all.c"), format!("#include <stdio.h>\n{declared}{main}")).unwrap();
    files
}

/// Builds one program of all self-tests with each installed compiler: with these strict options, without and with
/// optimisation, with and without sanitizers. The program must find no difference.
fn self_tested(folder: &Path, names: &[String], strict: &str) {
    let files = together(folder, names, |name| format!("#define main {name}_part\n#include \"{name}_test.c\"\n"));
    let builds = [("gcc", "-O0", WATCHED), ("gcc", "-O3", ""), ("clang", "-O0", ""), ("clang", "-O3", WATCHED)];
    for (compiler, level, watched) in builds.into_iter().filter(|(compiler, ..)| there(compiler)) {
        run(folder, &format!("{compiler} {strict} {level} {watched} {files} -o self_test"));
        let text = run(folder, "./self_test");
        for name in names {
            assert!(text.contains(&format!("\n{name}_step: 0 of 400 differ")), "{name}\n{text}");
        }
    }
}

/// Runs a command line in a folder, which must succeed without messages. Returns what it prints.
fn run(folder: &Path, line: &str) -> String {
    let mut words = line.split_whitespace();
    let output = Command::new(words.next().unwrap()).args(words).current_dir(folder).output().unwrap();
    let Output { status, stdout, stderr } = output;
    let (out, err) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{line}\n{out}{err}");
    assert!(err.is_empty(), "{line}\n{err}");
    out.into_owned()
}
