//! The line to a controller with GCS 2.0: bytes out, answers in.
//!
//! An answer has one line or more: all but the last end with a space before the line feed.

use crate::watch::Watch;
use crate::wire::Wire;
use piezoid::Error;
use std::ops::{Deref, DerefMut};
use std::time::Duration;

/// An answer that is skipped has at most so many bytes.
const SKIPPED: usize = 1 << 20;

/// The query that every controller answers with the version of the command set, and with nothing like any other answer.
const VERSION: &str = "CSV?";

/// A connection to a controller.
pub(crate) struct Line<'a> {
    wire: Wire<'a>,
    /// The answer to [`VERSION`].
    version: String,
}

impl<'a> Deref for Line<'a> {
    type Target = Wire<'a>;

    fn deref(&self) -> &Wire<'a> {
        &self.wire
    }
}

impl DerefMut for Line<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.wire
    }
}

impl<'a> Line<'a> {
    /// Connects to the controller at an address.
    pub(crate) fn open(host: (&str, u16), patience: Duration, watch: Watch<'a>) -> Result<Self, Error> {
        let mut line = Line { wire: Wire::open(host, patience, watch)?, version: String::new() };
        let answer = line.query(VERSION).map_err(|error| match error {
            Error::Cancelled { .. } => error,
            other => Error::Content(format!(
                "{other}; most controllers serve one program at a time: end the other one, if there is one"
            )),
        })?;
        line.version = answer.concat().trim().to_string();
        if line.version.starts_with('2') {
            Ok(line)
        } else {
            Err(line.strange(&line.version, "the version of GCS 2.0"))
        }
    }

    /// Connects again, and gives a command before anything else.
    pub(crate) fn again(&mut self, first: &str) -> Result<(), Error> {
        self.wire.reconnect()?;
        self.urgent(first)
    }

    /// Gives a command whatever is still unanswered, then skips the answers to what was sent before.
    pub(crate) fn urgent(&mut self, command: &str) -> Result<(), Error> {
        let end = if self.wire.take_partial() { "\n" } else { "" };
        self.send(format!("{end}{command}\n{VERSION}\n").as_bytes())?;
        while self.lines(SKIPPED)?.concat().trim() != self.version {}
        Ok(())
    }

    /// The lines of an answer of at most so many bytes.
    pub(crate) fn lines(&mut self, longest: usize) -> Result<Vec<String>, Error> {
        let bytes = self.wire.until(longest, |all, k| all[k] == b'\n' && (k == 0 || all[k - 1] != b' '))?;
        // Code page 1252, in which micro is the same as in Unicode.
        let text: String = bytes.into_iter().map(char::from).collect();
        Ok(text.lines().map(|line| line.trim_end().to_string()).collect())
    }

    /// An error about an answer.
    pub(crate) fn strange(&self, answer: &str, expected: &str) -> Error {
        let (short, address): (String, _) = (answer.chars().take(60).collect(), &self.address);
        Error::Content(format!(
            "the controller at {address} answers {short:?}, which is not {expected}: check that it speaks GCS 2.0"
        ))
    }
}
