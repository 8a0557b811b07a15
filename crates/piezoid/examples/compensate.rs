//! Computes the voltage for a path, and tries it on the simulated bender.
//!
//! `cargo run --release -p piezoid --example compensate`
//!
//! The path is a triangle of 1000 um from end to end. The program prints the rms error of the bender in % of that
//! height: with the straight line from displacement to voltage that a data sheet suggests (5 %), and with the inverse
//! of the model (0.1 %).

use piezoid::excitation::{Prbs, RisingSine, Triangle};
use piezoid::plant::Plant;
use piezoid::{Compensate, Error, IdentifyOptions, Record, Records, identify};

/// Sampling period [s], and half the height of the path [um].
const TS: f64 = 5e-4;
const PEAK: f64 = 500.0;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y)
}

/// The rms error of the bender along `path` [% of its height], after the first period.
fn error(path: &[f64], voltage: Vec<f64>) -> Result<f64, Error> {
    let record = measure(voltage)?;
    let squares = path.iter().zip(record.y()).skip(path.len() / 4).map(|(r, y)| (r - y) * (r - y));
    Ok(100.0 * (squares.sum::<f64>() / (0.75 * path.len() as f64)).sqrt() / (2.0 * PEAK))
}

fn main() -> Result<(), Error> {
    let small = measure(Prbs { amplitude: 1.0, ..Prbs::default() }.samples(TS, 4094)?)?;
    let large = measure(RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() }.samples(TS, 4000)?)?;
    let options = IdentifyOptions { operator: "generalised-prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
    let model = identify(Records { small_signal: &[small], large_signal: &[large] }, &options)?.model;

    let path = Triangle { amplitude: PEAK, frequency: 5.0, ..Triangle::default() }.samples(TS, 1600)?;
    let line = path.iter().map(|r| r * 30.0 / 1000.0).collect();
    println!("straight line: {:.3} %", error(&path, line)?);

    let result = model.compensate(&path)?;
    println!("inverse of the model: {:.3} %", error(&path, result.u)?);
    result.notes.iter().for_each(|note| println!("note: {note}"));
    Ok(())
}
