//! Exports a model with its feed-forward and a controller as C.
//!
//! `cargo run --release -p piezoid --example export -- FOLDER` writes the files; without a folder it only lists them.
//!
//! The files are a header, a source file, a self-test with vectors, and a page that describes them. In the folder,
//! `cc bender.c bender_test.c -lm -o bender_test && ./bender_test` checks that the C code is bit-identical to the
//! model. Other targets are `fixed`, `fmu2`, `fmu3`, `simulink`, `st` and `rust`.

use piezoid::excitation::{Prbs, RisingSine};
use piezoid::plant::Plant;
use piezoid::{Error, IdentifyOptions, Record, Records, identify};
use piezoid_export::ExportOptions;
use std::path::Path;

/// Sampling period [s].
const TS: f64 = 5e-4;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let small = measure(Prbs { amplitude: 1.0, ..Prbs::default() }.samples(TS, 4094)?)?;
    let large = measure(RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() }.samples(TS, 4000)?)?;
    let options = IdentifyOptions { operator: "prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
    let model = identify(Records { small_signal: &[small], large_signal: &[large] }, &options)?.model;

    let controller = Some("integral-notch".into());
    let options = ExportOptions { name: "bender".into(), controller, ..ExportOptions::default() };
    let result = options.of("c", &model, None, None)?;
    result.notes.iter().for_each(|note| println!("note: {note}"));
    let folder = std::env::args().nth(1);
    for file in &result.files {
        println!("{}: {} bytes", file.name, file.bytes.len());
        if let Some(folder) = &folder {
            std::fs::create_dir_all(folder)?;
            std::fs::write(Path::new(folder).join(&file.name), &file.bytes)?;
        }
    }
    Ok(())
}
