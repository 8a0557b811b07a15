//! Skipped tests and what was missing for them, read from their output.
//!
//! A Rust test prints `SKIPPED: <test>: <what is missing>`, pytest `SKIPPED [<number>] <place>: <why>`.

use crate::{announced, root, succeeded};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

/// Skipped tests by what was missing.
#[derive(Default)]
pub(crate) struct Skipped {
    tests: BTreeMap<String, BTreeSet<String>>,
}

impl Skipped {
    /// Adds a test that was skipped because something is missing.
    pub(crate) fn add(&mut self, test: &str, missing: &str) {
        self.tests.entry(missing.into()).or_default().insert(test.into());
    }

    /// These and the `others`.
    pub(crate) fn and(mut self, others: Skipped) -> Self {
        others.tests.into_iter().for_each(|(missing, tests)| self.tests.entry(missing).or_default().extend(tests));
        self
    }

    /// Runs a command in the workspace, passes its output on, and adds the skipped tests.
    pub(crate) fn step(&mut self, command: &mut Command) -> Result<(), String> {
        let line = announced(command);
        let command = command.current_dir(root()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| format!("cannot start `{line}`: {e}"))?;
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let message = std::thread::scope(|scope| {
            let err = scope.spawn(|| passed_on(err, std::io::stderr()));
            let out = passed_on(out, std::io::stdout());
            [out, err.join().unwrap_or_default()].concat()
        });
        let status = child.wait().map_err(|e| format!("cannot wait for `{line}`: {e}"))?;
        message.iter().filter_map(|line| read(line)).for_each(|(test, missing)| self.add(test, missing));
        succeeded(&line, status)
    }
}

/// Copies the input line by line; returns the lines about skipped tests.
fn passed_on(from: Option<impl Read>, mut to: impl Write) -> Vec<String> {
    let mut message = Vec::new();
    let Some(from) = from else { return message };
    for line in BufReader::new(from).split(b'\n').map_while(Result::ok) {
        // The reader of the output may be gone.
        let _ = to.write_all(&[&line[..], b"\n"].concat());
        let line = String::from_utf8_lossy(&line);
        message.extend(line.starts_with("SKIPPED").then(|| line.into_owned()));
    }
    message
}

/// The test and what it lacks, from a line about a skipped test.
fn read(line: &str) -> Option<(&str, &str)> {
    match line.strip_prefix("SKIPPED: ") {
        // Names of tests contain double colons.
        Some(message) => message.split_once(": "),
        None => line.strip_prefix("SKIPPED [")?.split_once("] ")?.1.split_once(": "),
    }
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let all: BTreeSet<&String> = self.tests.values().flatten().collect();
        let count = |n: usize| if n == 1 { "1 test".into() } else { format!("{n} tests") };
        writeln!(f, "{} skipped, wholly or in part", if all.is_empty() { "no test".into() } else { count(all.len()) })?;
        self.tests.iter().try_for_each(|(missing, tests)| writeln!(f, "  {missing}: {}", count(tests.len())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_are_counted_once_and_by_what_they_lack() {
        let mut skipped = Skipped::default();
        assert_eq!(skipped.to_string(), "no test skipped, wholly or in part\n");
        for line in [
            "SKIPPED: c::models_are_the_same: no clang",
            "SKIPPED: c::models_are_the_same: no gcc",
            "SKIPPED: simulink::a_class_is_run: no gcc",
            "SKIPPED [1] tests/test_bench.py:22: pyswarms is not installed: pip has it",
        ] {
            let (test, missing) = read(line).expect("a line with both");
            skipped.add(test, missing);
        }
        let message = "3 tests skipped, wholly or in part\n  no clang: 1 test\n  no gcc: 2 tests\n  pyswarms is not installed: pip has it: 1 test\n";
        assert_eq!(skipped.to_string(), message);
        assert_eq!(read("SKIPPED it is"), None);
    }
}
