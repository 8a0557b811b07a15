//! `piezoid instrument`: a simulated controller on this machine.

use super::lists;
use super::prelude::*;
use anyhow::Context;
use piezoid_instruments::Simulation;
use std::net::TcpListener;

const EXAMPLES: &str = "\
Examples:
  A controller with a simulated PL140 bender:
    piezoid instrument
  It is measured from another terminal, by piezoid or by any client of GCS 2.0 such as PIPython:
    piezoid acquire sine20.csv -o record.csv

  An NV200/D Net of piezosystem jena, for its Python package nv200 or piezoid:
    piezoid instrument --model nv200 --port 2300
    piezoid acquire sine20.csv --protocol nv200 --port 2300 -o record.csv

  Two axes of an E-754, with a clock that only answers advance:
    piezoid instrument --model e-754 --axes 2 --virtual-time 0.01

It listens on the loopback interface alone.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Instrument {
    /// The TCP port on this machine; 0 is any that is free.
    #[arg(long, value_name = "N", default_value_t = 50000)]
    port: u16,
    #[command(flatten)]
    simulation: Flags<Simulation>,
}

impl Run for Instrument {
    fn run(self, console: &Console) -> Result<()> {
        let simulation = self.simulation.0;
        let plant = lists::plant(&simulation.plant)?;
        let controller = simulation.around(&plant, &simulation.plant).map_err(failed)?;
        let advice = || format!("port {} cannot be opened: name another by --port", self.port);
        let listener = TcpListener::bind(("127.0.0.1", self.port)).with_context(advice)?;
        let port = listener.local_addr()?.port();
        let plant = &simulation.plant;
        console.print(&format!("a controller with plant {plant} listens at 127.0.0.1, port {port}\nCtrl-C ends\n"))?;
        Ok(controller.serve(&listener)?)
    }
}
