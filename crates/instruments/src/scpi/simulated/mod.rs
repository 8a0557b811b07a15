//! A generator and an oscilloscope with SCPI, simulated around a plant, each at a port of its own.
//!
//! ```text
//! generator -> amplifier (gain) -> plant -> sensor          -> channel 2 of the oscilloscope
//!     Sync -> EXT TRIG              monitor, u/10           -> channel 1
//! ```
//! The sensor has the round sensitivity with which 8 V or less are its largest displacement; `*IDN?` states it. A line
//! has commands with `;` between them. Headers are known in their short and long forms, with and without `SOUR1`. What
//! is refused has its error in a queue (-113 for unknown commands) and is not obeyed, but for an offset that an
//! amplitude leaves no room for: it is adjusted, with error -221, as by the maker's instruments.
//!
//! Reference: as of the [client](super). It does not do: modulation, sweeps, sequences, gated bursts, measurements.

mod commands;
mod generator;
mod oscilloscope;
#[cfg(test)]
mod tests;
mod words;

use crate::simulated::axis::Axis;
use crate::simulated::{Behaviour, Simulated, Simulation, Time};
use generator::Generator;
use oscilloscope::Oscilloscope;
use piezoid::Error;
use piezoid::control::SimulatedActuator;
use std::collections::VecDeque;

/// Voltage at the actuator for 1 V at the monitor.
const MONITOR: f64 = 10.0;

/// Voltage of the sensor that its largest displacement stays below [V].
const MOST: f64 = 8.0;

/// Errors that a queue holds.
const QUEUE: usize = 20;

/// The instruments of a simulation with this plant, and its name.
pub(crate) fn simulated(simulation: &Simulation, name: &str, plant: &SimulatedActuator) -> Result<Simulated, Error> {
    if simulation.axes != 1 {
        return Err(Error::parameter("axes", simulation.axes, "is 1 on the model scpi"));
    }
    let axis = Axis::new("1", plant, simulation.gain, simulation.seed)?;
    // The travel leaves out a sixth of the displacement.
    let volt = 1.2 * axis.travel.0.abs().max(axis.travel.1.abs()) / MOST;
    let decade = libm::pow(10.0, libm::floor(libm::log10(volt)));
    let sensor = [1.0, 2.0, 5.0].map(|k| k * decade).into_iter().find(|k| *k >= volt).unwrap_or(10.0 * decade);
    let device = Device {
        plant: name.into(),
        axis,
        sensor,
        generator: Generator::default(),
        oscilloscope: Oscilloscope::new(simulation.seed),
        errors: Default::default(),
        time: Time::new(simulation.virtual_time),
    };
    Ok(Simulated::new(device))
}

/// Both instruments, without their lines.
#[derive(Debug)]
struct Device {
    plant: String,
    axis: Axis,
    /// Displacement for 1 V of the sensor [um].
    sensor: f64,
    generator: Generator,
    oscilloscope: Oscilloscope,
    /// Errors of the generator and of the oscilloscope that were not read yet.
    errors: [VecDeque<i32>; 2],
    time: Time,
}

impl Behaviour for Device {
    fn state(&self) -> (f64, bool, bool) {
        (self.axis.voltage, false, self.generator.is_bursting())
    }

    fn time(&mut self) -> &mut Time {
        &mut self.time
    }

    fn step(&mut self) -> bool {
        let output = self.generator.step();
        self.axis.cycle(Some(output));
        self.oscilloscope.step([self.axis.voltage / MONITOR, self.axis.position / self.sensor]);
        self.generator.is_moving() || self.oscilloscope.is_running()
    }

    fn hold(&mut self) {
        self.axis.hold();
    }

    fn clients(&self) -> usize {
        8
    }

    fn has_blocks(&self) -> bool {
        true
    }

    fn answer(&mut self, line: &str) -> Vec<u8> {
        self.answer_at(0, line)
    }

    fn answer_at(&mut self, port: usize, line: &str) -> Vec<u8> {
        self.time.clock.wait();
        self.update();
        self.time.calm = 0;
        self.log(&line.chars().take(80).collect::<String>());
        let answer = self.obey(port.min(1), line);
        // The level of the output follows at once.
        let output = self.generator.output();
        self.axis.jump(output * self.axis.gain);
        answer
    }

    fn too_long(&mut self) -> Vec<u8> {
        self.error(0, commands::TOO_LONG);
        Vec::new()
    }
}

impl Device {
    /// Puts an error into a queue.
    fn error(&mut self, port: usize, code: i32) {
        if self.errors[port].len() < QUEUE {
            self.errors[port].push_back(code);
        }
    }
}
