//! A controller that is simulated around a plant, for programs that are tried without hardware.
//!
//! It lives in time: its plants go on between commands, moves take time, waves are played and recorded with the clock.
//! Each command finds the state of its moment. With a virtual clock, time passes by answers alone, and the same
//! commands give the same numbers.
//!
//! Each axis has a plant of its own; wave generator and output channel of the same number belong to it.

mod axis;
#[cfg(test)]
mod clients;
mod clock;
mod commands;
mod errors;
mod generators;
mod model;
mod parameters;
mod queries;
mod recorder;
mod segments;
mod server;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod transcripts;
mod waves;
mod words;
#[cfg(test)]
mod wrong;

pub use model::Model;
pub use server::Simulated;

use axis::{Axis, COARSE};
use clock::Clock;
use errors::STOPPED;
use generators::{Generator, Tables};
use model::MODELS;
use piezoid::Error;
use piezoid::plant::{Preset, Spec};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use recorder::Recorder;
use std::collections::BTreeMap;

options! {
    /// How to simulate a controller.
    pub struct Simulation {
        /// The plant of each axis (see {list}).
        plant: String = "pl140".into(), OptionRow::new(OptionKind::Text("NAME")).list("plants");
        /// Seed of the noise of the sensor of axis 1; that of axis 2 has the next one.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Voltage that an open-loop value of 1 gives.
        gain: f64 = 1.0, OptionRow::positive("V");
        /// The model of the controller: its name and the commands that it knows.
        model: Model = Model::default(), OptionRow::new(MODELS);
        /// Number of axes.
        axes: usize = 1, OptionRow::new(OptionKind::Integer(1, 3));
        /// Time that passes with each answer, in place of the clock: the same commands then give the same numbers.
        virtual_time: Option<f64> = None, OptionRow {
            unit: "s", absent: "the clock of this machine",
            ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: 10.0 })
        };
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
    /// The errors of [`Plant::new`](piezoid::plant::Plant::new).
    pub fn around(&self, spec: &Spec, name: &str) -> Result<Simulated, Error> {
        let range = voltages(spec)?;
        let axis = |k: usize| Axis::new(&k.to_string(), spec, range, self.gain, self.seed.wrapping_add(k as u64 - 1));
        let axes = (1..=self.axes.clamp(1, 3)).map(axis).collect::<Result<Vec<_>, _>>()?;
        let (title, version) = (self.model.title(), env!("CARGO_PKG_VERSION"));
        Ok(Simulated::new(Device {
            identity: format!("piezoid, {title}, simulated controller with {name}, {version}"),
            plant: name.to_uppercase(),
            model: self.model,
            error: 0,
            level: 0,
            generators: axes.iter().map(|_| Generator::default()).collect(),
            axes,
            tables: Tables::new(),
            recorder: Recorder::default(),
            saved: BTreeMap::new(),
            clock: Clock::new(self.virtual_time),
            cycle: 0,
            calm: 0,
            #[cfg(test)]
            log: std::sync::Arc::default(),
        }))
    }
}

/// Servo cycle [s].
const CYCLE: f64 = 5e-5;

/// Time after which nothing vibrates any more [servo cycles].
const CALM: u64 = 40_000;

/// At most so many servo cycles, and so many coarse steps, are computed at once. If the machine was busy or asleep
/// meanwhile, the clock of the controller stands still for the rest.
const AT_ONCE: u64 = 20_000;
const COARSE_AT_ONCE: u64 = 100_000;

/// Lowest and highest voltage of a plant [V].
fn voltages(spec: &Spec) -> Result<(f64, f64), Error> {
    let read: serde_json::Value = serde_json::from_str(&spec.to_json()?).unwrap_or_default();
    let [low, high] = ["min_v", "max_v"].map(|name| read["driver"][name].as_f64());
    low.zip(high).ok_or_else(|| Error::Content("the plant has a driver without limits".into()))
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
    /// What `SEP` keeps, by axis and number.
    saved: BTreeMap<(usize, u32), f64>,
    clock: Clock,
    /// Servo cycles until now.
    cycle: u64,
    /// Servo cycles since something moved or was recorded.
    calm: u64,
    /// What it was given, for tests.
    #[cfg(test)]
    log: std::sync::Arc<std::sync::Mutex<Vec<Entry>>>,
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

impl Device {
    /// Brings the state up to the present.
    fn update(&mut self) {
        let (mut fine, mut coarse) = (0, 0);
        while let Some(left) = self.clock.now().checked_sub(self.cycle).filter(|left| *left > 0) {
            let is_real = self.clock.is_real();
            if self.is_calm() && left >= COARSE {
                coarse += 1;
                if is_real && coarse > COARSE_AT_ONCE {
                    self.cycle += left;
                    return;
                }
                self.axes.iter_mut().for_each(Axis::hold);
                self.cycle += COARSE;
            } else if is_real && fine == AT_ONCE {
                self.clock.lose(left);
            } else {
                fine += 1;
                self.step();
            }
        }
    }

    /// One servo cycle.
    fn step(&mut self) {
        for (axis, generator) in self.axes.iter_mut().zip(&mut self.generators) {
            axis.cycle(generator.next());
        }
        self.recorder.cycle(&self.axes);
        self.cycle += 1;
        let moves = self.axes.iter().any(Axis::is_moving) || self.generators.iter().any(Generator::is_running);
        self.calm = if moves || self.recorder.is_running() { 0 } else { self.calm + 1 };
    }

    /// True if nothing moves, vibrates or is recorded.
    fn is_calm(&self) -> bool {
        self.calm >= CALM
    }

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

    /// Keeps a command for tests.
    #[cfg(test)]
    fn log(&self, command: &str) {
        let (voltage, servo, runs) = (self.axes[0].voltage, self.axes[0].servo, self.generators[0].is_running());
        self.log.lock().unwrap().push(Entry { command: command.into(), voltage, servo, runs });
    }
}

fn bits(flags: impl Iterator<Item = bool>) -> u32 {
    flags.enumerate().map(|(k, flag)| u32::from(flag) << k).sum()
}
