//! Measures what a page of docs/ states, and writes its tables and figures.
//!
//! `cargo run --release -p piezoid-bench -- paper|operators|accuracy|control|feedback|stand-in|evidence docs`
//! `cargo run -p piezoid-bench -- vectors crates/piezoid/tests/compatibility/0.1.0/operators`

use piezoid_bench::{accuracy, control, evidence, feedback, operators, paper, stand_in, vectors};
use std::error::Error;
use std::path::Path;

/// Writes into a folder.
type Write = fn(&Path) -> Result<(), Box<dyn Error>>;

/// What can be written.
const WRITERS: [(&str, Write); 8] = [
    ("paper", paper::write),
    ("operators", operators::write),
    ("accuracy", accuracy::write),
    ("control", control::write),
    ("feedback", feedback::write),
    ("stand-in", stand_in::write),
    ("evidence", evidence::write),
    ("vectors", vectors::write),
];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let names = WRITERS.map(|(name, _)| name).join("|");
    let [name, folder] = &args[..] else { return Err(format!("usage: piezoid-bench {names} FOLDER").into()) };
    let writer = WRITERS.iter().find(|(known, _)| known == name);
    let (_, write) = writer.ok_or_else(|| format!("there is no page {name}: give one of {names}"))?;
    write(Path::new(folder))
}
