//! The line to a controller: commands out, answers in.
//!
//! A command is a line. It has no answer; `ERR?` answers the number of its error, or 0. A query ends with `?`, and its
//! answer has one line or more: all but the last end with a space before the line feed. An unknown query has no answer.

use crate::codes::meaning;
use piezoid::Error;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::time::Duration;

/// An answer has at most so many bytes, unless it has tables.
const LONGEST: u64 = 1 << 16;

/// The error of an unknown command.
const UNKNOWN: i32 = 2;

/// A connection to a controller.
#[derive(Debug)]
pub(crate) struct Line {
    input: BufReader<TcpStream>,
    /// Host and port, for messages.
    address: String,
}

impl Line {
    /// Connects to the controller at an address.
    pub(crate) fn open(host: &str, port: u16, patience: Duration) -> Result<Self, Error> {
        let address = format!("{host}:{port}");
        let refused = |e: &dyn std::fmt::Display| {
            let advice = "check that it is switched on, its address, and that no other program is connected to it";
            Error::Content(format!("no controller answers at {address}: {e}; {advice}"))
        };
        let mut last = None;
        for one in (host, port).to_socket_addrs().map_err(|e| refused(&e))? {
            match TcpStream::connect_timeout(&one, patience) {
                Ok(stream) => {
                    let set = stream.set_nodelay(true).and_then(|()| stream.set_read_timeout(Some(patience)));
                    set.and_then(|()| stream.set_write_timeout(Some(patience))).map_err(|e| refused(&e))?;
                    return Ok(Line { input: BufReader::new(stream), address });
                }
                Err(e) => last = Some(e),
            }
        }
        Err(last.map_or_else(|| refused(&"the name has no address"), |e| refused(&e)))
    }

    /// Sends bytes as they are.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.input.get_mut().write_all(bytes).map_err(|e| self.lost(&e))
    }

    /// Gives a command. It is an error if the controller refuses it.
    pub(crate) fn command(&mut self, command: &str) -> Result<(), Error> {
        match self.arguments(command)? {
            0 => Ok(()),
            code => Err(self.refused(command, code)),
        }
    }

    /// Gives a command that not every controller knows.
    pub(crate) fn command_if_known(&mut self, command: &str) -> Result<(), Error> {
        match self.arguments(command)? {
            0 | UNKNOWN => Ok(()),
            code => Err(self.refused(command, code)),
        }
    }

    /// Gives a command; its error, or 0.
    fn arguments(&mut self, command: &str) -> Result<i32, Error> {
        self.send(format!("{command}\nERR?\n").as_bytes())?;
        let text = self.lines(LONGEST)?.concat();
        self.code(&text)
    }

    fn refused(&self, command: &str, code: i32) -> Error {
        let short: String = command.chars().take(60).collect();
        let (address, meaning) = (&self.address, meaning(code));
        Error::Content(format!("the controller at {address} refuses `{short}`: error {code}, {meaning}"))
    }

    /// The lines of the answer to a query that the controller knows.
    pub(crate) fn query(&mut self, query: &str) -> Result<Vec<String>, Error> {
        self.query_long(query, LONGEST)
    }

    /// The same for an answer of at most so many bytes.
    pub(crate) fn query_long(&mut self, query: &str, longest: u64) -> Result<Vec<String>, Error> {
        self.send(format!("{query}\n").as_bytes())?;
        self.lines(longest)
    }

    /// The lines of the answer to a query whose answer has an equals sign; `None` if the controller refuses it.
    pub(crate) fn optional_query(&mut self, query: &str) -> Result<Option<Vec<String>>, Error> {
        self.send(format!("{query}\nERR?\n").as_bytes())?;
        let lines = self.lines(LONGEST)?;
        if lines.iter().any(|line| line.contains('=')) {
            self.lines(LONGEST)?;
            return Ok(Some(lines));
        }
        // Without an answer, this is the number of the error.
        match self.code(&lines.concat())? {
            0 => Err(self.strange("", &format!("an answer to `{query}`"))),
            _ => Ok(None),
        }
    }

    /// The hexadecimal number that is the whole answer to a byte.
    pub(crate) fn number(&mut self, byte: u8) -> Result<u64, Error> {
        self.send(&[byte])?;
        let text = self.lines(LONGEST)?.concat();
        let digits = text.trim().trim_start_matches("0x");
        u64::from_str_radix(digits, 16).map_err(|_| self.strange(&text, "a whole number"))
    }

    fn code(&self, text: &str) -> Result<i32, Error> {
        text.trim().parse().map_err(|_| self.strange(text, "the number of an error"))
    }

    fn lines(&mut self, longest: u64) -> Result<Vec<String>, Error> {
        let mut lines = Vec::new();
        let mut left = longest;
        loop {
            let mut line = Vec::new();
            match self.input.by_ref().take(left).read_until(b'\n', &mut line) {
                Ok(_) if line.ends_with(b"\n") => left -= line.len() as u64,
                Ok(_) if left <= line.len() as u64 => return Err(self.lost(&"its answer does not end")),
                Ok(_) => return Err(self.lost(&"it closed the connection")),
                Err(e) => return Err(self.lost(&e)),
            }
            // Code page 1252, in which micro is the same as in Unicode.
            lines.push(line.iter().map(|byte| char::from(*byte)).collect::<String>().trim_end().to_string());
            if !line.ends_with(b" \n") {
                return Ok(lines);
            }
        }
    }

    /// An error about an answer.
    pub(crate) fn strange(&self, answer: &str, expected: &str) -> Error {
        let (short, address): (String, _) = (answer.chars().take(60).collect(), &self.address);
        Error::Content(format!(
            "the controller at {address} answers {short:?}, which is not {expected}: check that it speaks GCS 2.0"
        ))
    }

    fn lost(&self, e: &dyn std::fmt::Display) -> Error {
        let address = &self.address;
        Error::Content(format!("the controller at {address} does not answer: {e}; check the connection and try again"))
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        drop(self.input.get_ref().shutdown(Shutdown::Both));
    }
}
