//! A controller that is simulated around a plant, for programs that are tried without hardware.
//!
//! It has one axis, `1`, and serves one client after the other. A wave is played with the clock. All else has a time of
//! its own: a command to move takes [`MOVE`](axis::MOVE), and between commands nothing happens. So the same commands
//! give the same numbers, unless they come while a wave is played.

mod axis;
mod commands;
mod waves;

use axis::SimulatedAxis;
use piezoid::Error;
use piezoid::plant::{Plant, Preset, Spec};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::net::{TcpListener, TcpStream};
use waves::Waves;

options! {
    /// How to simulate a controller.
    pub struct Simulation {
        /// The plant (see {list}).
        plant: String = "pl140".into(), OptionRow::new(OptionKind::Text("NAME")).list("plants");
        /// Seed of the noise of its sensor.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Voltage that an open-loop value of 1 gives.
        gain: f64 = 1.0, OptionRow::positive("V");
    }
}

impl Simulation {
    /// The controller with the plant of this name.
    ///
    /// # Errors
    /// Returns an error if there is no such plant.
    pub fn controller(&self) -> Result<Simulated, Error> {
        self.around(&Preset::find(&self.plant)?.spec(), &self.plant)
    }

    /// The controller with a plant of this name.
    ///
    /// # Errors
    /// The errors of [`Plant::new`].
    pub fn around(&self, spec: &Spec, name: &str) -> Result<Simulated, Error> {
        let plant = Plant::new(spec, CYCLE)?.with_seed(self.seed);
        let range = voltages(spec)?;
        let identity = format!("piezoid, {name}, simulated controller, {}", env!("CARGO_PKG_VERSION"));
        let axis = SimulatedAxis::new(plant, range, self.gain);
        Ok(Simulated {
            identity,
            error: 0,
            axis,
            waves: Waves::default(),
            #[cfg(test)]
            log: std::sync::Arc::default(),
        })
    }
}

/// Servo cycle [s].
const CYCLE: f64 = 5e-5;

/// A line has at most so many bytes.
const LONGEST: u64 = 1 << 16;

/// Lowest and highest voltage of a plant [V].
fn voltages(spec: &Spec) -> Result<(f64, f64), Error> {
    let read: serde_json::Value = serde_json::from_str(&spec.to_json()?).unwrap_or_default();
    let [low, high] = ["min_v", "max_v"].map(|name| read["driver"][name].as_f64());
    low.zip(high).ok_or_else(|| Error::Content("the plant has a driver without limits".into()))
}

/// A simulated controller.
#[derive(Debug)]
pub struct Simulated {
    identity: String,
    /// What `ERR?` answers next.
    error: i32,
    axis: SimulatedAxis,
    waves: Waves,
    /// What it was given, for tests.
    #[cfg(test)]
    pub(crate) log: std::sync::Arc<std::sync::Mutex<Vec<Entry>>>,
}

/// A command, and the state before it.
#[cfg(test)]
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) command: String,
    pub(crate) voltage: f64,
    pub(crate) servo: bool,
    pub(crate) runs: bool,
}

impl Simulated {
    /// Answers one client after the other.
    ///
    /// # Errors
    /// Returns the error of the listener.
    pub fn serve(&mut self, listener: &TcpListener) -> std::io::Result<()> {
        loop {
            match listener.accept() {
                // A client that goes in the middle of a line has ended.
                Ok((client, _)) => drop(self.converse(client)),
                Err(e) if matches!(e.kind(), ErrorKind::ConnectionAborted | ErrorKind::Interrupted) => (),
                Err(e) => return Err(e),
            }
        }
    }

    /// Keeps a command for tests.
    #[cfg(test)]
    fn log(&self, command: &str) {
        let (voltage, servo, runs) = (self.axis.voltage, self.axis.servo, self.waves.running());
        self.log.lock().unwrap().push(Entry { command: command.into(), voltage, servo, runs });
    }

    fn converse(&mut self, client: TcpStream) -> std::io::Result<()> {
        client.set_nodelay(true)?;
        let (mut input, mut output) = (BufReader::new(client.try_clone()?), client);
        let mut line = Vec::new();
        loop {
            let ready = input.fill_buf()?;
            let Some(&byte) = ready.first() else { return Ok(()) };
            input.consume(1);
            match byte {
                b'\n' => {
                    let text: String = line.drain(..).map(char::from).collect();
                    let answer = self.answer(text.trim());
                    // A line of the answer that is not the last ends with a space.
                    output.write_all(answer.join(" \n").as_bytes())?;
                    if !answer.is_empty() {
                        output.write_all(b"\n")?;
                    }
                }
                5 | 7..=9 | 24 => output.write_all(self.answer_byte(byte))?,
                _ if line.len() as u64 == LONGEST => self.error = commands::TOO_LONG,
                _ => line.push(byte),
            }
        }
    }
}
