//! A controller with GCS 2.0 that is simulated around a plant.
//!
//! Each axis has a plant of its own; wave generator and output channel of the same number belong to it.

#[cfg(test)]
mod clients;
mod commands;
mod errors;
mod generators;
mod help;
mod parameters;
mod queries;
mod recorder;
mod segments;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod transcripts;
mod waves;
mod words;
#[cfg(test)]
mod wrong;

use crate::simulated::axis::Axis;
use crate::simulated::{Behaviour, CYCLE, Model, Simulated, Simulation, Time};
use errors::{STOPPED, TOO_LONG};
use generators::{Generator, Tables};
use piezoid::Error;
use piezoid::control::SimulatedActuator;
use recorder::Recorder;
use std::collections::BTreeMap;

/// The controller of a simulation with this plant, and its name.
pub(crate) fn simulated(simulation: &Simulation, name: &str, plant: &SimulatedActuator) -> Result<Simulated, Error> {
    let seed = simulation.seed;
    let axis = |k: usize| Axis::new(&k.to_string(), plant, simulation.gain, seed.wrapping_add(k as u64 - 1));
    let axes = (1..=simulation.axes.clamp(1, 3)).map(axis).collect::<Result<Vec<_>, _>>()?;
    let (title, version) = (simulation.model.title(), env!("CARGO_PKG_VERSION"));
    let device = Device {
        identity: format!("piezoid, {title}, simulated controller with {name}, {version}"),
        plant: name.to_uppercase(),
        model: simulation.model,
        error: 0,
        level: 0,
        generators: axes.iter().map(|_| Generator::default()).collect(),
        axes,
        tables: Tables::new(),
        recorder: Recorder::default(),
        kept: BTreeMap::new(),
        saved: BTreeMap::new(),
        time: Time::new(simulation.virtual_time),
    };
    Ok(Simulated::new(device))
}

/// The controller itself, without its line.
#[derive(Debug)]
struct Device {
    identity: String,
    /// What `CST?` answers.
    plant: String,
    model: Model,
    /// What `ERR?` answers next. All clients share it.
    error: i32,
    /// Command level.
    level: u8,
    axes: Vec<Axis>,
    generators: Vec<Generator>,
    tables: Tables,
    recorder: Recorder,
    /// What `SPA` changed of parameters that nothing uses, by axis and number.
    kept: BTreeMap<(usize, u32), f64>,
    /// What `SEP` keeps.
    saved: BTreeMap<(usize, u32), f64>,
    time: Time,
}

impl Behaviour for Device {
    fn state(&self) -> (f64, bool, bool) {
        (self.axes[0].voltage, self.axes[0].servo, self.generators[0].is_running())
    }

    fn time(&mut self) -> &mut Time {
        &mut self.time
    }

    fn step(&mut self) -> bool {
        for (axis, generator) in self.axes.iter_mut().zip(&mut self.generators) {
            axis.cycle(generator.next());
        }
        self.recorder.cycle(&self.axes);
        let moves = self.axes.iter().any(Axis::is_moving) || self.generators.iter().any(Generator::is_running);
        moves || self.recorder.is_running()
    }

    fn hold(&mut self) {
        self.axes.iter_mut().for_each(Axis::hold);
    }

    fn clients(&self) -> usize {
        self.model.clients()
    }

    fn answer(&mut self, line: &str) -> Vec<u8> {
        let lines = self.lines(line);
        // A line of the answer that is not the last ends with a space.
        if lines.is_empty() { Vec::new() } else { (lines.join(" \n") + "\n").into_bytes() }
    }

    fn answer_byte(&mut self, byte: u8) -> Vec<u8> {
        self.at_once(byte)
    }

    fn too_long(&mut self) -> Vec<u8> {
        self.error = TOO_LONG;
        Vec::new()
    }
}

impl Device {
    /// True for each axis that moves, as bits.
    fn moving(&self) -> u32 {
        bits(self.axes.iter().zip(&self.generators).map(|(axis, wave)| axis.is_moving() || wave.is_running()))
    }

    /// True for each generator that runs, as bits.
    fn running(&self) -> u32 {
        bits(self.generators.iter().map(Generator::is_running))
    }

    /// Stops these axes and their generators where they are.
    fn stop(&mut self, axes: &[usize]) {
        for k in axes {
            self.generators[*k].stop();
            self.axes[*k].stop();
        }
        self.error = STOPPED;
    }
}

fn bits(flags: impl Iterator<Item = bool>) -> u32 {
    flags.enumerate().map(|(k, flag)| u32::from(flag) << k).sum()
}
