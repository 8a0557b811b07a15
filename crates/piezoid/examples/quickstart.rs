//! From records to a model, a voltage and C code.
//!
//! `cargo run --release -p piezoid --example quickstart`
//!
//! The records come from a simulated bender. The program prints the error of the model on a record that was not used to
//! identify it (0.12 % of peak-to-peak), the largest voltage along a path, and the files of the exported model.

use piezoid::excitation::{Prbs, RisingSine, Sine, Staircase};
use piezoid::plant::Plant;
use piezoid::{Compensate, Error, IdentifyOptions, Record, Records, Validate, identify};
use piezoid_export::Export;

/// Sampling period [s].
const TS: f64 = 5e-4;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y)
}

fn main() -> Result<(), Error> {
    let small = measure(Prbs { amplitude: 1.0, ..Prbs::default() }.samples(TS, 4094)?)?;
    let large = measure(RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() }.samples(TS, 4000)?)?;
    let options = IdentifyOptions { operator: "generalised-prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
    let model = identify(Records { small_signal: &[small], large_signal: &[large] }, &options)?.model;

    let levels = Staircase { amplitude: 25.0, frequency: 5.0, levels: 20, ..Staircase::default() };
    let test = measure(levels.samples(TS, 4000)?)?;
    println!("error on the staircase: {:.3} % of peak-to-peak", model.validate(&test)?.metrics.rms_pp_percent);

    // A sine of 500 um, and the voltage for it.
    let path = Sine { amplitude: 500.0, frequency: 5.0, ..Sine::default() }.samples(TS, 2000)?;
    let voltage = model.compensate(&path)?.u;
    println!("largest voltage along the sine: {:.2} V", voltage.iter().fold(0.0f64, |most, u| most.max(u.abs())));

    for file in model.export("c", "bender")?.files {
        println!("{}: {} bytes", file.name, file.bytes.len());
    }
    Ok(())
}
