//! Compares controllers on the simulated bender before they run on hardware.
//!
//! `cargo run --release -p piezoid --example control`
//!
//! Each scheme is made from a model identified from records, and follows a sine and a triangle of 400 um. The table
//! gives the rms error in % of the height. `gain` is the best straight line, without compensation. A controller alone
//! is too slow for the triangle, because it must not excite the resonance. `learning` has the smallest errors, after
//! ten trials on the bender.

use piezoid::excitation::{Prbs, RisingSine};
use piezoid::formats::ColumnSelection;
use piezoid::plant::{Plant, Preset};
use piezoid::progress::Stage;
use piezoid::{Error, IdentifyOptions, Record, Records, identify};
use piezoid_verbs::{ControlOptions, File};

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

    let references = vec!["sine:5".into(), "triangle:20".into()];
    let options = ControlOptions { reference: references, amplitude: Some(400.0), ..ControlOptions::default() };
    let (spec, model) = (Preset::find("pl140")?.spec(), File::new("model.json", model.to_json()));
    let compared =
        options.run(("pl140", &spec.into()), &model, &[], &ColumnSelection::default(), &mut Stage::ignore)?;
    for result in &compared.results {
        print!("{:30}", result.name());
        for (attempt, reference) in result.attempts.iter().zip(&compared.references) {
            match attempt {
                Ok(attempt) => print!("{} {:.3} %   ", reference.name, attempt.tracking.percent_of_stroke),
                Err(refused) => print!("{} refused: {refused}   ", reference.name),
            }
        }
        println!();
    }
    Ok(())
}
