//! An NV200/D Net that is simulated around a plant: one axis, one arbitrary waveform generator, one recorder.
//!
//! A command is a line: a name, and arguments after commas. A name without its last argument is a query. XOFF and XON
//! enclose each answer, also one without text:
//!
//! ```text
//! set,40          ->  XOFF XON
//! set             ->  XOFF set,40.000 CR LF XON
//! set,999         ->  XOFF error,4 CR LF XON
//! (empty line)    ->  XOFF NV200/D_NET> CR LF XON
//! ```
//! The setpoint is a voltage in open loop and a position in closed loop. `modsrc` chooses what gives it: `set` (0) or
//! the generator (3). A generator at rest gives the value at its index. As the loop is switched, the voltage stays.
//!
//! Reference: the command list and the wire format of the Python package nv200 1.6.0 of piezosystem jena. It does not
//! do: ILC, triggers, SPI, analogue input; filters and gains of the controller are kept and change nothing.

mod commands;
mod generator;
mod list;
mod queries;
mod recorder;
#[cfg(test)]
mod tests;

use crate::simulated::axis::Axis;
use crate::simulated::{Behaviour, CYCLE, Simulated, Simulation, Time};
use generator::Generator;
use piezoid::Error;
use piezoid::control::SimulatedActuator;
use recorder::Recorder;
use std::collections::BTreeMap;

/// The controller of a simulation with this plant, and its name.
pub(crate) fn simulated(simulation: &Simulation, name: &str, plant: &SimulatedActuator) -> Result<Simulated, Error> {
    let model = simulation.model.title();
    if simulation.axes != 1 {
        return Err(Error::parameter("axes", simulation.axes, format!("is 1 on the model {model}")));
    }
    if simulation.gain != 1.0 {
        let rule = format!("is 1 on the model {model}, which counts open-loop values in volts");
        return Err(Error::parameter("gain", simulation.gain, rule));
    }
    let mut axis = Axis::new("1", plant, 1.0, simulation.seed)?;
    // Without a limit of slew, a setpoint is reached within a cycle.
    (axis.slew, axis.velocity) = speeds(&axis, UNLIMITED);
    let device = Device {
        plant: name.to_uppercase(),
        set: axis.goal,
        axis,
        source: SET,
        generator: Generator::default(),
        recorder: Recorder::default(),
        kept: BTreeMap::new(),
        time: Time::new(simulation.virtual_time),
    };
    Ok(Simulated::new(device))
}

/// Values of `modsrc`.
const SET: u16 = 0;
const GENERATOR: u16 = 3;

/// The value of `sr` that means no limit [%/ms].
const UNLIMITED: f64 = 2000.0;

/// Slew rate [V/s] and velocity [um/s] of a value of `sr` [%/ms].
fn speeds(axis: &Axis, rate: f64) -> (f64, f64) {
    // The rate of a whole range in one cycle is no limit.
    let share = if rate >= UNLIMITED { 1.0 / CYCLE } else { 10.0 * rate };
    (share * (axis.range.1 - axis.range.0), share * (axis.travel.1 - axis.travel.0))
}

/// The controller itself, without its line.
#[derive(Debug)]
struct Device {
    /// What `desc` answers.
    plant: String,
    axis: Axis,
    /// What was set last: a voltage [V] in open loop, a position [um] in closed loop.
    set: f64,
    /// What gives the setpoint.
    source: u16,
    generator: Generator,
    recorder: Recorder,
    /// Parameters that are kept and change nothing, by name.
    kept: BTreeMap<&'static str, f64>,
    time: Time,
}

impl Behaviour for Device {
    fn state(&self) -> (f64, bool, bool) {
        (self.axis.voltage, self.axis.servo, self.generator.is_running())
    }

    fn time(&mut self) -> &mut Time {
        &mut self.time
    }

    fn step(&mut self) -> bool {
        let share = self.generator.next();
        if self.source == GENERATOR {
            let value = self.value(share);
            if value != self.axis.goal {
                self.axis.go(value);
            }
        }
        self.axis.cycle(None);
        self.recorder.cycle(&self.axis);
        self.axis.is_moving() || self.generator.is_running() || self.recorder.is_recording()
    }

    fn hold(&mut self) {
        self.axis.hold();
    }

    fn clients(&self) -> usize {
        crate::Model::Nv200.clients()
    }

    fn ends_at_return(&self) -> bool {
        true
    }

    fn answer(&mut self, line: &str) -> Vec<u8> {
        self.time.clock.wait();
        self.update();
        self.time.calm = 0;
        // Telnet's own bytes are no part of a line.
        let line: String = line.chars().filter(|c| *c < '\u{f0}').collect();
        self.log(&line);
        framed(&self.obey(line.trim()).unwrap_or_else(|code| format!("error,{code}")))
    }

    fn too_long(&mut self) -> Vec<u8> {
        framed(&format!("error,{}", commands::UNKNOWN))
    }
}

impl Device {
    /// Lowest and highest setpoint in this mode.
    fn limits(&self) -> (f64, f64) {
        self.axis.limits()
    }

    /// The setpoint of a value of the generator [%].
    fn value(&self, share: f64) -> f64 {
        let (low, high) = self.limits();
        low + 0.01 * share * (high - low)
    }
}

/// An answer as it is sent, in code page 1252.
fn framed(text: &str) -> Vec<u8> {
    let bytes = text.chars().map(|c| u8::try_from(c).unwrap_or(b'?'));
    let end: &[u8] = if text.is_empty() { b"" } else { b"\r\n" };
    [&[0x13], &*bytes.collect::<Vec<u8>>(), end, &[0x11]].concat()
}
