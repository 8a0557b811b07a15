//! `piezoid instrument`: a simulated controller on this machine.

use super::plant::RecordsOfModel;
use super::prelude::*;
use anyhow::Context;
use piezoid_instruments::{Model, Simulation};
use std::net::TcpListener;

const EXAMPLES: &str = "\
Examples:
  A controller with a simulated PL140 bender:
    piezoid instrument
  It is measured from another terminal, by piezoid or by any client of GCS 2.0 such as PIPython:
    piezoid acquire sine20.csv -o record.csv

  One with a stand-in for your own actuator, made of the records of its model:
    piezoid instrument model.json --plant records

  An NV200/D Net of piezosystem jena, for its Python package nv200 or piezoid:
    piezoid instrument --model nv200 --port 2300
    piezoid acquire sine20.csv --protocol nv200 --port 2300 -o record.csv

  An arbitrary waveform generator and an oscilloscope with SCPI, about an amplifier with a gain of 10:
    piezoid instrument --model scpi --port 5025 --oscilloscope-port 5026 --gain 10 --plant p885
    piezoid acquire sine20.csv --protocol scpi --port 5025 --oscilloscope 127.0.0.1:5026 --gain 10 --low 0 --high 100 \
--monitor-channel 1 --sensitivity 10 -o record.csv

  Two axes of an E-754, with a clock that only answers advance:
    piezoid instrument --model e-754 --axes 2 --virtual-time 0.01

It listens on the loopback interface alone.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid instrument [OPTIONS]\n       piezoid instrument <FILE> --plant records [OPTIONS]")]
pub(crate) struct Instrument {
    /// The model of the actuator, for --plant records.
    #[arg(value_name = "FILE")]
    actuator: Option<PathBuf>,
    #[command(flatten)]
    of_model: RecordsOfModel,
    /// The TCP port on this machine; 0 is any that is free.
    #[arg(long, value_name = "N", default_value_t = 50000)]
    port: u16,
    /// The TCP port of the oscilloscope of the model scpi; 0 is any that is free.
    #[arg(long, value_name = "N", default_value_t = 5026)]
    oscilloscope_port: u16,
    /// Write each command that it is given to this file, after the state of axis 1 at that moment.
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    #[command(flatten)]
    simulation: Flags<Simulation>,
}

impl Run for Instrument {
    fn run(self, console: &Console) -> Result<()> {
        let simulation = self.simulation.0;
        let model = self.actuator.as_deref();
        RecordsOfModel::needed(&simulation.plant, model)?;
        let (name, plant) = self.of_model.plant_of(&simulation.plant, model, console)?;
        let mut controller = simulation.around(&name, &plant).map_err(failed)?;
        let (listener, port) = listener("port", self.port)?;
        if let Some(log) = &self.log {
            let to = std::fs::File::create(log).and_then(|to| controller.logged(to));
            controller = to.with_context(|| format!("cannot write {}: name another file", log.display()))?;
        }
        let head = format!("a controller with plant {name} listens at 127.0.0.1, port {port}\n");
        if simulation.model != Model::Scpi {
            console.print(&(head + "Ctrl-C ends\n"))?;
            return Ok(controller.serve(&listener)?);
        }
        let (second, port) = self::listener("oscilloscope-port", self.oscilloscope_port)?;
        console.print(&format!("{head}its oscilloscope listens at 127.0.0.1, port {port}\nCtrl-C ends\n"))?;
        std::thread::scope(|scope| {
            scope.spawn(|| controller.serve_oscilloscope(&second));
            Ok(controller.serve(&listener)?)
        })
    }
}

/// A listener at a port, which an option names, and the port that it has.
fn listener(option: &str, port: u16) -> Result<(TcpListener, u16)> {
    let advice = || format!("port {port} cannot be opened: name another by --{option}");
    let listener = TcpListener::bind(("127.0.0.1", port)).with_context(advice)?;
    let port = listener.local_addr()?.port();
    Ok((listener, port))
}
