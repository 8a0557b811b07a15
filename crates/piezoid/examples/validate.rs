//! Compares a model with a record that was not used to identify it.
//!
//! `cargo run --release -p piezoid --example validate`, or with your own files:
//! `cargo run --release -p piezoid --example validate -- model.json record.csv`
//!
//! The model runs freely: it sees only the input. The program prints the errors of the whole record and by amplitude,
//! and compares them with the noise floor, which is the scatter of the error between repetitions of the input. A model
//! that describes everything has an error of one noise floor; this one has 3.4.

use piezoid::excitation::{Prbs, RisingSine, Triangle};
use piezoid::formats::ColumnSelection;
use piezoid::plant::Plant;
use piezoid::{Error, IdentifyOptions, Model, Record, Records, Validate, identify};

/// Sampling period of the simulated records [s].
const TS: f64 = 5e-4;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y)
}

/// A model identified on a PRBS and a rising sine, and a triangle as validation data.
fn simulated() -> Result<(Model, Record), Error> {
    let small = measure(Prbs { amplitude: 1.0, ..Prbs::default() }.samples(TS, 4094)?)?;
    let large = measure(RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() }.samples(TS, 4000)?)?;
    let options = IdentifyOptions { operator: "generalised-prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
    let model = identify(Records { small_signal: &[small], large_signal: &[large] }, &options)?.model;
    let test = measure(Triangle { amplitude: 20.0, frequency: 10.0, ..Triangle::default() }.samples(TS, 4000)?)?;
    Ok((model, test))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (model, record) = match arguments.as_slice() {
        [model, record] => (
            Model::from_json(&std::fs::read_to_string(model)?)?,
            Record::from_csv(&std::fs::read(record)?, &ColumnSelection::default())?,
        ),
        _ => simulated()?,
    };
    let validation = model.validate(&record)?;
    let metrics = validation.metrics;
    println!("rms error {:.4} {}, {:.4} % of peak-to-peak", metrics.rmse, record.units().y, metrics.rms_pp_percent);
    for bin in &validation.by_amplitude {
        println!("amplitude {:.1}: {:.4} % of peak-to-peak, {} cycles", bin.at, bin.rms_pp_percent, bin.cycles);
    }
    if let Some(floor) = &validation.floor {
        println!("noise floor {:.4}: the error is {:.2} floors", floor.rms, floor.error_over_floor);
    }
    validation.summary.iter().for_each(|summary| println!("{summary}"));
    validation.remarks.iter().for_each(|remark| println!("note: {remark}"));
    Ok(())
}
