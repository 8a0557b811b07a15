//! Errors of operators on a twin: `cargo run --release -p piezoid-bench --example learned -- TWIN OPERATOR...`
//!
//! The model is that of docs/accuracy.md (`joint, driver unknown`). The errors are those of its free run on validation
//! records up to 200 Hz, as rms in % of peak-to-peak.

#![allow(clippy::print_stdout)] // what it is for

use piezoid::hysteresis::Operator;
use piezoid_bench::accuracy::{VALIDATION, range};
use piezoid_bench::operators;
use piezoid_bench::twin::{KINDS, Twin, error};

/// Highest frequency of the validation records [Hz].
const HIGHEST: f64 = 200.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (name, names) = arguments.split_first().ok_or("give a twin and operators")?;
    if name == "recovery" {
        // Each operator identified as itself.
        for operator in names {
            let row = Operator::find(operator)?;
            println!("{operator}: {:.2e} %", operators::error(row, row)?);
        }
        return Ok(());
    }
    let twin = Twin::new(name)?;
    for operator in names {
        let found = twin.joint(operator, false)?;
        let mut errors = Vec::new();
        for kind in &KINDS {
            for hz in VALIDATION.into_iter().filter(|hz| *hz <= HIGHEST) {
                errors.push(error(&found.model, &twin.validation(kind, hz)?));
            }
        }
        let [least, median, most] = range(&errors);
        let trial = found.trials.first().ok_or("no trial")?;
        println!(
            "{name} {operator}: least {least:.4}, median {median:.4}, largest {most:.3} %; {} parameters, held out {:.4} %",
            trial.parameters, trial.held_out_percent
        );
    }
    Ok(())
}
