//! Commands and queries on the line to a controller.
//!
//! A command is a line. It has no answer; `ERR?` answers the number of its error, or 0. A query ends with `?`. An
//! unknown query has no answer.

use crate::gcs::codes::meaning;
use crate::gcs::controller::RUNNING;
use crate::gcs::line::Line;
use piezoid::Error;

/// An answer has at most so many bytes, unless it has tables.
const LONGEST: usize = 1 << 16;

/// The error of an unknown command.
const UNKNOWN: i32 = 2;

impl Line<'_> {
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
        self.code()
    }

    /// The error that is pending, or 0. The query clears it.
    pub(crate) fn pending(&mut self) -> Result<i32, Error> {
        self.send(b"ERR?\n")?;
        self.code()
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
    pub(crate) fn query_long(&mut self, query: &str, longest: usize) -> Result<Vec<String>, Error> {
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
        match self.number_of(&lines.concat())? {
            0 => Err(self.strange("", &format!("an answer to `{query}`"))),
            _ => Ok(None),
        }
    }

    /// The number that answers a query; `None` if the controller refuses it.
    pub(crate) fn value(&mut self, query: &str) -> Result<Option<f64>, Error> {
        let Some(lines) = self.optional_query(query)? else { return Ok(None) };
        let first = lines.first().map_or("", |line| line);
        self.real(first.rsplit('=').next().unwrap_or_default(), first).map(Some)
    }

    /// The numbers that answer these queries, which are sent at once; `None` if the controller refuses one of them.
    pub(crate) fn values(&mut self, queries: &[String]) -> Result<Option<Vec<f64>>, Error> {
        self.send(format!("{}\nERR?\n", queries.join("\n")).as_bytes())?;
        let mut found = Vec::new();
        loop {
            let text = self.lines(LONGEST)?.concat();
            if let Some((_, number)) = text.rsplit_once('=') {
                found.push(self.real(number, &text)?);
                continue;
            }
            let (code, are_all) = (self.number_of(&text)?, found.len() == queries.len());
            return match code {
                0 if are_all => Ok(Some(found)),
                0 => Err(self.strange("", &format!("an answer to `{}`", queries.join("`, `")))),
                // It is not theirs, and must not be lost.
                _ if are_all => Err(self.refused(&queries.concat(), code)),
                _ => Ok(None),
            };
        }
    }

    /// The number that these digits are, in an answer.
    fn real(&self, digits: &str, answer: &str) -> Result<f64, Error> {
        let number = digits.trim().parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.strange(answer, "a number"))
    }

    /// The number that answers a query that every controller knows.
    pub(crate) fn needed(&mut self, query: &str) -> Result<f64, Error> {
        let refused = || Error::Content(format!("the controller does not answer `{query}`, which is needed"));
        self.value(query)?.ok_or_else(refused)
    }

    /// The bits of the hexadecimal number that answers a byte.
    pub(crate) fn bits(&mut self, byte: u8) -> Result<u64, Error> {
        self.send(&[byte])?;
        let text = self.lines(LONGEST)?.concat();
        let digits = text.trim().trim_start_matches("0x");
        u64::from_str_radix(digits, 16).map_err(|_| self.strange(&text, "a whole number"))
    }

    /// True while the wave generator of this number runs.
    pub(crate) fn runs(&mut self, generator: usize) -> Result<bool, Error> {
        let all = self.bits(RUNNING)?;
        Ok(all.checked_shr(generator as u32 - 1).is_some_and(|one| one & 1 == 1))
    }

    fn code(&mut self) -> Result<i32, Error> {
        let text = self.lines(LONGEST)?.concat();
        self.number_of(&text)
    }

    fn number_of(&self, text: &str) -> Result<i32, Error> {
        text.trim().parse().map_err(|_| self.strange(text, "the number of an error"))
    }
}
