//! What the tests of all clients do: a measurement on a simulated controller, and what its user gets.

use crate::{AcquireOptions, Acquired, InstrumentOptions, Simulation};
use piezoid::Error;
use piezoid::formats::{ColumnSelection, Table};
use piezoid::progress::{Progress, Stage};
use piezoid_verbs::{DataFile, File};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};

/// The port of a simulated controller.
pub(crate) fn served(simulation: &Simulation) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let controller = simulation.controller().unwrap();
    std::thread::spawn(move || controller.serve(&listener));
    port
}

/// The answers at a port to lines, as a terminal shows them.
pub(crate) fn text(port: u16, lines: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.write_all(lines.as_bytes()).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// The same options but for some.
pub(crate) fn but(mut options: AcquireOptions, change: impl FnOnce(&mut InstrumentOptions)) -> AcquireOptions {
    change(&mut options.instrument);
    options
}

pub(crate) fn drive(ts: f64, u: &[f64]) -> DataFile {
    File::new("drive.csv", Table::write("drive.csv", ts, &[("u_V", u)]).unwrap()).into()
}

pub(crate) fn sine(n: usize) -> Vec<f64> {
    (0..n).map(|t| 20.0 * libm::sin(0.05 * t as f64)).collect()
}

/// The outcome, what the client states, and what it kept.
pub(crate) type Measured = (Result<Acquired, Error>, String, Option<Acquired>);

pub(crate) fn run(options: &AcquireOptions, drive: &DataFile, progress: &mut Progress) -> Measured {
    let (mut notes, mut kept) = (Vec::new(), None);
    let mut keep = |acquired: &Acquired| {
        kept = Some(acquired.clone());
        Ok(())
    };
    let outcome = options.run(drive, &ColumnSelection::default(), &mut notes, &mut keep, progress);
    let text = match &outcome {
        Ok(acquired) => acquired.unfinished.clone().unwrap_or_default(),
        Err(error) => error.to_string(),
    };
    (outcome, format!("{text}; {}", notes.join("; ")), kept)
}

pub(crate) fn refused(options: &AcquireOptions, drive: &DataFile) -> String {
    run(options, drive, &mut Stage::ignore).0.unwrap_err().to_string()
}
