//! The line to an instrument with SCPI.
//!
//! Each command is followed by `SYST:ERR?`, whose answer ends it and states its error. The queue of errors is emptied
//! once the line is open.

use crate::watch::Watch;
use crate::wire::Wire;
use piezoid::Error;
use std::time::Duration;

/// An answer has at most so many bytes: eight million samples.
const LONGEST: usize = 1 << 25;

/// A connection to an instrument.
pub(crate) struct Line<'a> {
    pub(crate) wire: Wire<'a>,
    /// What it answers to `*IDN?`.
    pub(crate) identity: String,
    /// True while an answer is still to come.
    is_pending: bool,
}

impl<'a> Line<'a> {
    /// Connects to the instrument at an address.
    pub(crate) fn open(host: (&str, u16), patience: Duration, watch: Watch<'a>) -> Result<Self, Error> {
        let wire = Wire::open(host, patience, watch)?;
        let mut line = Line { wire, identity: String::new(), is_pending: false };
        line.identity = line.query("*IDN?")?;
        // Maker, model, serial number, firmware.
        if line.identity.split(',').count() < 4 {
            return Err(line.strange(&line.identity, "the name of an instrument with SCPI"));
        }
        line.command("*CLS")?;
        Ok(line)
    }

    /// Makes sure that no old answer is to come, if need be by connecting again.
    pub(crate) fn clear(&mut self, again: bool) -> Result<(), Error> {
        if again || self.is_pending {
            self.wire.reconnect()?;
        }
        self.command("*CLS")
    }

    /// The bytes that answer a query.
    fn answer(&mut self, sent: &[u8], ends: impl Fn(&[u8], usize) -> bool) -> Result<Vec<u8>, Error> {
        self.is_pending = true;
        self.wire.send(sent)?;
        let bytes = self.wire.until(LONGEST, ends)?;
        self.is_pending = false;
        Ok(bytes)
    }

    /// The text that answers a query.
    pub(crate) fn query(&mut self, query: &str) -> Result<String, Error> {
        let bytes = self.answer(format!("{query}\n").as_bytes(), |all, k| all[k] == b'\n')?;
        Ok(String::from_utf8_lossy(&bytes).trim().to_string())
    }

    /// The number that answers a query.
    pub(crate) fn number(&mut self, query: &str) -> Result<f64, Error> {
        let text = self.query(query)?;
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.strange(&text, &format!("a number for `{query}`")))
    }

    /// The block of bytes that answers a query: `#`, the number of digits, the number of bytes, the bytes.
    pub(crate) fn block(&mut self, query: &str) -> Result<Vec<u8>, Error> {
        // Its bytes may be line feeds; what does not begin as a block ends with one.
        let ends = |all: &[u8], k: usize| all[k] == b'\n' && head(all).is_none_or(|(head, length)| k >= head + length);
        let bytes = self.answer(format!("{query}\n").as_bytes(), ends)?;
        match head(&bytes).and_then(|(head, length)| bytes.get(head..head + length)) {
            Some(block) => Ok(block.to_vec()),
            None => Err(self.strange(&String::from_utf8_lossy(&bytes), &format!("a block for `{query}`"))),
        }
    }

    /// Gives a command. It is an error if the instrument has one.
    pub(crate) fn command(&mut self, command: &str) -> Result<(), Error> {
        self.command_bytes(command, &[])
    }

    /// Gives a command with a block of bytes after it.
    pub(crate) fn command_bytes(&mut self, command: &str, bytes: &[u8]) -> Result<(), Error> {
        let sent = [command.as_bytes(), bytes, b"\nSYST:ERR?\n"].concat();
        let answer = self.answer(&sent, |all, k| all[k] == b'\n')?;
        let text = String::from_utf8_lossy(&answer).trim().to_string();
        match text.split(',').next().and_then(|code| code.trim().parse::<i32>().ok()) {
            Some(0) => Ok(()),
            Some(_) => {
                let (short, address): (String, _) = (command.chars().take(60).collect(), &self.wire.address);
                Err(Error::Content(format!("the instrument at {address} refuses `{short}`: {text}")))
            }
            None => Err(self.strange(&text, "the answer to `SYST:ERR?`")),
        }
    }

    pub(crate) fn strange(&self, answer: &str, expected: &str) -> Error {
        let (short, address): (String, _) = (answer.chars().take(60).collect(), &self.wire.address);
        Error::Content(format!(
            "the instrument at {address} answers {short:?}, which is not {expected}: check that it speaks SCPI"
        ))
    }
}

/// Bytes before a block and bytes in it; `None` for what does not begin as one.
fn head(all: &[u8]) -> Option<(usize, usize)> {
    let digits = (*all.get(1)? as char).to_digit(10)? as usize;
    let length: usize = std::str::from_utf8(all.get(2..2 + digits)?).ok()?.parse().ok()?;
    (all[0] == b'#' && length <= LONGEST).then_some((2 + digits, length))
}
