//! Writes the files of the operators in this version: a model of every operator, inputs, and outputs.

use piezoid::creep::Creep;
use piezoid::driver::DriverModel;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::Arx;
use piezoid::{Error, Model, System};
use piezoid_export::{ExportRequest, ExportedProgram};
use serde_json::{Value, json};
use std::path::Path;

/// Sampling period [s].
const TS: f64 = 5e-4;

/// Writes a file for each operator into a folder.
pub fn write(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let driver = DriverModel::new(1e-4, Some(2e4))?;
    let with_driver = ("driven", model("prandtl-ishlinskii", Some(driver)));
    for (name, model) in OPERATORS.iter().map(|o| (o.name, model(o.name, None))).chain([with_driver]) {
        let model = model?;
        let whole = ExportedProgram::new(&ExportRequest::new(&model, "m"))?;
        let document: Value = serde_json::from_str(&model.to_json())?;
        let mut vectors = json!({"model": document});
        for entry in &whole.entries {
            let mut inputs: Vec<f64> = entry.vectors.inputs.iter().map(|row| row[0]).collect();
            let mut outputs = entry.vectors.outputs.clone();
            // Exported code holds the last input in place of a number that is too large; the library takes any.
            if entry.step == "step" {
                let usual = |u: &f64| u.abs() < 1e300;
                let mut last = inputs.iter().copied().find(usual).unwrap_or_default();
                for u in &mut inputs {
                    last = Some(*u).filter(usual).unwrap_or(last);
                    *u = last;
                }
                outputs = model.simulate(&inputs);
            }
            vectors[entry.step] = json!({"inputs": inputs, "outputs": outputs});
        }
        std::fs::write(folder.join(format!("{name}.json")), format!("{vectors}\n"))?;
    }
    Ok(())
}

/// The operator's example with creep and a resonance, with or without a driver.
fn model(name: &str, driver: Option<DriverModel>) -> Result<Model, Error> {
    let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
    let model = Model::from_blocks(driver, (Operator::find(name)?.example)(TS / faster)?, block, 2.0)?;
    model.with_creep(Creep::logarithmic(TS, 0.01, 0.1, 1.0)?)
}
