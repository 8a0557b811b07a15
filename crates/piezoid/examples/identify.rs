//! Identifies a model from records, and prints what was found.
//!
//! `cargo run --release -p piezoid --example identify`, or with your own large-signal records as CSV files:
//! `cargo run --release -p piezoid --example identify -- rise5.csv rise20.csv`
//!
//! Three operators are tried. The table gives the parameters and the held-out error of each: the data are divided into
//! parts, and each part is predicted by a fit to the others. The simplest operator that predicts as well as the best is
//! taken. Below stand creep and modes with their standard errors.

use piezoid::excitation::{Prbs, RisingSine};
use piezoid::formats::ColumnSelection;
use piezoid::plant::Plant;
use piezoid::{Error, IdentifyOptions, Record, Records, identify};

/// Sampling period of the simulated records [s].
const TS: f64 = 5e-4;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y)
}

/// A sine of rising amplitude.
fn rising(frequency: f64) -> Result<Record, Error> {
    measure(RisingSine { amplitude: 28.0, frequency, ..RisingSine::default() }.samples(TS, 4000)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut small, mut large) = (Vec::new(), Vec::new());
    for path in std::env::args().skip(1) {
        large.push(Record::from_csv(&std::fs::read(path)?, &ColumnSelection::default())?);
    }
    if large.is_empty() {
        small.push(measure(Prbs::default().samples(TS, 4094)?)?);
        large = [5.0, 20.0, 80.0].into_iter().map(rising).collect::<Result<_, _>>()?;
    }

    let operators = "prandtl-ishlinskii,generalised-prandtl-ishlinskii,bouc-wen";
    let options = IdentifyOptions { operator: operators.into(), ..IdentifyOptions::default() };
    let found = identify(Records { small_signal: &small, large_signal: &large }, &options)?;
    for trial in &found.trials {
        let (name, n) = (trial.operator, trial.parameters);
        println!("{name:32}{n:3} parameters, held out {:.3} %  {}", trial.held_out_percent, trial.verdict);
    }
    for parameter in &found.parameters {
        println!("{:32}{:.5} +- {:.1e}", parameter.name, parameter.value, parameter.error);
    }
    Ok(())
}
