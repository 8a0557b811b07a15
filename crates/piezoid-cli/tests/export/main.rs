//! Exported code, compiled and run where it is made for: the same numbers as here, to the bit.

#![allow(clippy::unwrap_used, clippy::panic)]

mod c;
mod cortex;
mod fixed;
mod rust;
mod simulink;
mod st;
mod structured_text;

#[path = "../../../piezoid/tests/common/skipped.rs"]
mod skipped;

use piezoid::File;
use piezoid::creep::Creep;
use piezoid::driver::DriverModel;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::Arx;
use piezoid::{Error, Model};
use piezoid_export::{Made, Wanted, target};
use skipped::skipped;
use std::path::Path;
use std::process::{Command, Output};

/// Sampling period [s].
const TS: f64 = 5e-4;

/// A model of every operator, with creep and a resonance; and one behind a driver.
fn models() -> Vec<(String, Model)> {
    let named = |name: &str| name.replace('-', "_");
    let mut models: Vec<(String, Model)> =
        OPERATORS.iter().map(|o| (named(o.name), model(o.name, None).unwrap())).collect();
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    models.push(("driven_plays".into(), model("prandtl-ishlinskii", Some(driver)).unwrap()));
    models
}

fn model(name: &str, driver: Option<DriverModel>) -> Result<Model, Error> {
    let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
    let model = Model::driven(driver, (Operator::find(name)?.example)(TS / faster)?, block, 2.0)?;
    model.with_creep(Creep::logarithmic(TS, 0.01, 0.1, 1.0)?)
}

/// What `target` makes of a model, written into a folder.
fn exported(target_name: &str, wanted: &Wanted, folder: &Path) -> Made {
    let made = (target(target_name).unwrap().make)(wanted).unwrap();
    for File { name, bytes } in &made.files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    made
}

/// Whether a tool is there; where it is not, says so, and in CI fails.
#[track_caller]
fn there(tool: &str) -> bool {
    let there = Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        skipped(&format!("no {tool}"));
    }
    there
}

const WATCHED: &str = "-fsanitize=address,undefined -fno-sanitize-recover=all";

/// Builds the self-test in a folder with the compilers there are, so strictly, unoptimised and optimised, watched and not: it finds no
/// difference.
fn self_tested(folder: &Path, name: &str, strict: &str) {
    let builds = [("gcc", "-O0", WATCHED), ("gcc", "-O3", ""), ("clang", "-O0", ""), ("clang", "-O3", WATCHED)];
    for (compiler, level, watched) in builds.into_iter().filter(|(compiler, ..)| there(compiler)) {
        run(folder, &format!("{compiler} {strict} {level} {watched} {name}.c {name}_test.c -o self_test"));
        let said = run(folder, "./self_test");
        assert!(said.contains(": 0 of 400 differ"), "{said}");
    }
}

/// Runs a command line in a folder; what it prints, if it ends well.
fn run(folder: &Path, line: &str) -> String {
    let mut words = line.split_whitespace();
    let output = Command::new(words.next().unwrap()).args(words).current_dir(folder).output().unwrap();
    let Output { status, stdout, stderr } = output;
    let (out, err) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{line}\n{out}{err}");
    assert!(err.is_empty(), "{line}\n{err}");
    out.into_owned()
}
