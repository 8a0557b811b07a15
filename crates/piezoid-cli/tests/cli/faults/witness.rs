//! The log of the simulated controller, as a witness of what the client did.

use std::path::Path;

/// A line of the log: the state before a command.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) time: f64,
    pub(super) voltage: f64,
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// Largest change in a servo cycle since the line before.
    pub(super) step: f64,
    pub(super) servo: bool,
    pub(super) runs: bool,
    pub(super) command: String,
}

/// The complete lines of a log: a controller that is killed may leave a part of one.
pub(super) fn read(path: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
    whole.lines().skip(1).map(entry).collect()
}

fn entry(line: &str) -> Entry {
    let mut words = line.splitn(8, ' ');
    let mut word = || words.next().unwrap_or_else(|| panic!("a line of the log is torn: `{line}`"));
    let mut number = || word().parse::<f64>().unwrap();
    let [time, voltage, lowest, highest, step] = std::array::from_fn(|_| number());
    let mut flag = || word() == "1";
    let (servo, runs) = (flag(), flag());
    Entry { time, voltage, lowest, highest, step, servo, runs, command: word().into() }
}

impl Entry {
    /// True for a command that changes the voltage, or what sets it.
    pub(super) fn moves(&self) -> bool {
        let command = &self.command;
        let begins = ["SVA ", "SVO ", "MOV ", "set,", "modsrc,"];
        begins.iter().any(|name| command.starts_with(name)) || self.starts()
    }

    /// True for the start of a wave.
    pub(super) fn starts(&self) -> bool {
        matches!(&*self.command, "WGO 1 1" | "grun,1")
    }

    pub(super) fn stops(&self) -> bool {
        matches!(&*self.command, "WGO 1 0" | "grun,0")
    }

    /// The voltage that it requests [V].
    pub(super) fn target(&self) -> Option<f64> {
        let value = self.command.strip_prefix("SVA 1 ").or_else(|| self.command.strip_prefix("set,"))?;
        value.trim().parse().ok()
    }
}
