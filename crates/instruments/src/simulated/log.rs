//! The log of a simulated controller: what it was given, and the state of its first axis before each command.

use super::CYCLE;
use std::fmt::{self, Debug, Formatter};
use std::io::Write;

/// The first line.
const HEAD: &str = "# time [s], voltage [V], the lowest, the highest and the largest step of a servo cycle since the \
                    line before [V], servo, wave generator; command";

/// A log, and the voltage since its last line.
pub(crate) struct LogFile {
    to: Box<dyn Write + Send>,
    last: f64,
    lowest: f64,
    highest: f64,
    step: f64,
}

impl Debug for LogFile {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.debug_struct("LogFile").field("last", &self.last).finish_non_exhaustive()
    }
}

impl LogFile {
    /// A log that begins at this voltage.
    pub(crate) fn new(mut to: Box<dyn Write + Send>, voltage: f64) -> std::io::Result<Self> {
        writeln!(to, "{HEAD}")?;
        Ok(LogFile { to, last: voltage, lowest: voltage, highest: voltage, step: 0.0 })
    }

    /// The voltage after a servo cycle.
    pub(crate) fn cycle(&mut self, voltage: f64) {
        self.step = self.step.max((voltage - self.last).abs());
        (self.lowest, self.highest) = (self.lowest.min(voltage), self.highest.max(voltage));
        self.last = voltage;
    }

    /// A command at this cycle, and the state before it. What is written reaches the file at once, so that a controller
    /// that is killed leaves all of it.
    pub(crate) fn line(&mut self, cycle: u64, (voltage, servo, runs): (f64, bool, bool), command: &str) {
        self.cycle(voltage);
        let time = cycle as f64 * CYCLE;
        let [servo, runs] = [servo, runs].map(u8::from);
        let LogFile { lowest, highest, step, .. } = *self;
        let command = command.escape_debug();
        let text = format!("{time:.5} {voltage:.6} {lowest:.6} {highest:.6} {step:.6} {servo} {runs} {command}\n");
        // The controller goes on without a line that cannot be written.
        drop(self.to.write_all(text.as_bytes()).and_then(|()| self.to.flush()));
        (self.lowest, self.highest, self.step) = (voltage, voltage, 0.0);
    }
}
