//! Controllers that are simulated around a plant, for programs that are tried without hardware.
//!
//! They live in time: their plants go on between commands, moves take time, waves are played and recorded with the
//! clock. Each command finds the state of its moment. With a virtual clock, time passes by answers alone, and the same
//! commands give the same numbers.

pub(crate) mod axis;
pub(crate) mod clock;
mod clocked;
mod log;
mod options;
mod server;

pub use options::{Model, Simulation};
pub use server::Simulated;
pub(crate) use server::head;
#[cfg(test)]
pub(crate) use server::locked;

use clock::Clock;
use log::LogFile;
use std::fmt::Debug;

/// Servo cycle [s].
pub(crate) const CYCLE: f64 = 5e-5;

/// A step of a time in which nothing moves [servo cycles].
pub(crate) const COARSE: u64 = 2000;

/// Time after which nothing vibrates any more [servo cycles].
const CALM: u64 = 40_000;

/// At most so many servo cycles, and so many coarse steps, are computed at once. If the machine was busy or asleep
/// meanwhile, the clock of the controller stands still for the rest.
const AT_ONCE: u64 = 20_000;
const COARSE_AT_ONCE: u64 = 100_000;

/// The time of a controller.
#[derive(Debug)]
pub(crate) struct Time {
    pub(crate) clock: Clock,
    /// Servo cycles until now.
    cycle: u64,
    /// Servo cycles since something moved or was recorded.
    pub(crate) calm: u64,
    /// Where it writes what it was given.
    pub(crate) file: Option<LogFile>,
    /// What it was given, for tests.
    #[cfg(test)]
    log: Log,
}

impl Time {
    /// The beginning; with a time for each answer [s], on a virtual clock.
    pub(crate) fn new(answer: Option<f64>) -> Self {
        Time {
            clock: Clock::new(answer),
            cycle: 0,
            calm: 0,
            file: None,
            #[cfg(test)]
            log: Log::default(),
        }
    }

    /// True if nothing moves, vibrates or is recorded.
    fn is_calm(&self) -> bool {
        self.calm >= CALM
    }
}

/// What a simulated controller does in time, and what it answers on its line.
pub(crate) trait Behaviour: Debug + Send + 'static {
    fn time(&mut self) -> &mut Time;

    /// One servo cycle. True if something moves or is recorded.
    fn step(&mut self) -> bool;

    /// A time of [`COARSE`] servo cycles in which nothing moves.
    fn hold(&mut self);

    /// Clients that it serves at once.
    fn clients(&self) -> usize;

    /// True if a carriage return ends a line too, alone or before a line feed.
    fn ends_at_return(&self) -> bool {
        false
    }

    /// True if a line may contain blocks: `#`, the number of digits, the number of bytes, the bytes.
    fn has_blocks(&self) -> bool {
        false
    }

    /// The answer to a line at the port of this number, of those that the controller has.
    fn answer_at(&mut self, _port: usize, line: &str) -> Vec<u8> {
        self.answer(line)
    }

    /// The answer to a line, which is not empty only if something is answered.
    fn answer(&mut self, line: &str) -> Vec<u8>;

    /// The answer to a byte that is a command.
    fn answer_byte(&mut self, _byte: u8) -> Vec<u8> {
        Vec::new()
    }

    /// The answer to a line that is too long, and not obeyed.
    fn too_long(&mut self) -> Vec<u8>;

    /// Voltage [V], servo, and whether a wave is played, of the first axis.
    fn state(&self) -> (f64, bool, bool);

    /// Keeps a command in the log.
    fn log(&mut self, command: &str) {
        let state = self.state();
        let time = self.time();
        if let Some(file) = &mut time.file {
            file.line(time.cycle, state, command);
        }
        #[cfg(test)]
        self.keep(command);
    }

    /// Keeps a command for tests.
    #[cfg(test)]
    fn keep(&mut self, command: &str) {
        let (voltage, servo, runs) = self.state();
        self.time().log.lock().unwrap().push(Entry { command: command.into(), voltage, servo, runs });
    }

    /// Brings the state up to the present.
    fn update(&mut self) {
        let (mut fine, mut coarse) = (0, 0);
        loop {
            let time = self.time();
            let Some(left) = time.clock.now().checked_sub(time.cycle).filter(|left| *left > 0) else { return };
            let is_real = time.clock.is_real();
            if time.is_calm() && left >= COARSE {
                coarse += 1;
                if is_real && coarse > COARSE_AT_ONCE {
                    time.cycle += left;
                    return;
                }
                time.cycle += COARSE;
                self.hold();
            } else if is_real && fine == AT_ONCE {
                time.clock.lose(left);
            } else {
                fine += 1;
                time.cycle += 1;
                let is_busy = self.step();
                if self.time().file.is_some() {
                    let (voltage, ..) = self.state();
                    if let Some(file) = &mut self.time().file {
                        file.cycle(voltage);
                    }
                }
                let time = self.time();
                time.calm = if is_busy { 0 } else { time.calm + 1 };
            }
        }
    }
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

/// The commands that a controller was given, for tests.
#[cfg(test)]
pub(crate) type Log = std::sync::Arc<std::sync::Mutex<Vec<Entry>>>;
