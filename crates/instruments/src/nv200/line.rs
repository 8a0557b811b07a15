//! The line to an NV200.
//!
//! Each command is followed by the query of the same value. The answer of the query ends the command, whether or not
//! the controller answers the command itself, and shows what was kept. XON, XOFF and other control characters are
//! skipped.

use super::codes::meaning;
use crate::watch::Watch;
use crate::wire::Wire;
use piezoid::Error;
use std::time::Duration;

/// A line of an answer has at most so many bytes: a whole recorder.
const LONGEST: usize = 1 << 18;

/// The name that an empty line is answered with.
const NAME: &str = "NV200";

/// A connection to a controller.
pub(crate) struct Line<'a> {
    pub(crate) wire: Wire<'a>,
    /// True once answers to what was sent before may still come.
    is_behind: bool,
}

impl<'a> Line<'a> {
    /// Connects to the controller at an address. What it is.
    pub(crate) fn open(host: (&str, u16), patience: Duration, watch: Watch<'a>) -> Result<(Self, String), Error> {
        let mut line = Line { wire: Wire::open(host, patience, watch)?, is_behind: false };
        line.wire.send(b"\r\n")?;
        let answer = line.next().map_err(|error| match error {
            Error::Cancelled { .. } => error,
            other => Error::Content(format!("{other}; an NV200 serves one program at a time: end the other one")),
        })?;
        let name = answer.trim_end_matches('>').to_string();
        if name.starts_with(NAME) { Ok((line, name)) } else { Err(line.strange(&answer, "the name of an NV200")) }
    }

    /// Connects again, and gives a command before anything else.
    pub(crate) fn again(&mut self, first: &str) -> Result<(), Error> {
        self.wire.reconnect()?;
        self.urgent(first)
    }

    /// Gives a command whatever is still unanswered. From now on, answers to what was sent before are skipped.
    pub(crate) fn urgent(&mut self, command: &str) -> Result<(), Error> {
        self.is_behind = true;
        let end = if self.wire.take_partial() { "\r\n" } else { "" };
        self.wire.send(format!("{end}{command}\r\n\r\n").as_bytes())?;
        // Nothing but an empty line is answered with the name.
        while !self.next()?.starts_with(NAME) {}
        Ok(())
    }

    /// The next line that is not empty, without control characters.
    fn next(&mut self) -> Result<String, Error> {
        loop {
            let bytes = self.wire.until(LONGEST, |all, k| all[k] == b'\n')?;
            let text: String = bytes.into_iter().map(char::from).filter(|c| !c.is_control()).collect();
            if !text.trim().is_empty() {
                return Ok(text.trim().to_string());
            }
        }
    }

    /// The words that answer a query after those of the query itself.
    pub(crate) fn query(&mut self, query: &str) -> Result<Vec<String>, Error> {
        self.wire.send(format!("{query}\r\n").as_bytes())?;
        self.answer(query, query, 1)
    }

    /// The words after `head` of an answer to the last of so many lines. It is an error if one of them is refused.
    fn answer(&mut self, sent: &str, head: &str, lines: usize) -> Result<Vec<String>, Error> {
        let (mut refused, mut errors) = (None, 0);
        loop {
            let text = self.next()?;
            let rest = text.strip_prefix(head).filter(|rest| rest.starts_with(','));
            if let Some(code) = text.strip_prefix("error").filter(|_| !self.is_behind) {
                let code = code.trim_start_matches(',').trim().parse().unwrap_or_default();
                let (short, address, meaning): (String, _, _) =
                    (sent.chars().take(60).collect(), &self.wire.address, meaning(code));
                let message = format!("the controller at {address} refuses `{short}`: error {code}, {meaning}");
                refused.get_or_insert(Error::Content(message));
                errors += 1;
                if errors == lines {
                    break;
                }
            } else if let Some(rest) = rest {
                if refused.is_some() {
                    break;
                }
                return Ok(rest.split(',').skip(1).map(|word| word.trim().to_string()).collect());
            } else if !self.is_behind {
                return Err(self.strange(&text, &format!("an answer to `{head}`")));
            }
        }
        Err(refused.unwrap_or_else(|| Error::Content("the controller refuses a command".into())))
    }

    /// The number that answers a query.
    pub(crate) fn number(&mut self, query: &str) -> Result<f64, Error> {
        self.number_of(query, query)
    }

    /// The number that answers a query after these words.
    pub(crate) fn number_of(&mut self, query: &str, head: &str) -> Result<f64, Error> {
        self.wire.send(format!("{query}\r\n").as_bytes())?;
        let words = self.answer(query, head, 1)?;
        self.real(words.first())
    }

    fn real(&self, word: Option<&String>) -> Result<f64, Error> {
        let word = word.map_or("", |word| word);
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.strange(word, "a number"))
    }

    /// The numbers that answer a query.
    pub(crate) fn numbers(&mut self, query: &str) -> Result<Vec<f64>, Error> {
        let words = self.query(query)?;
        words.iter().map(|word| self.real(Some(word))).collect()
    }

    /// The number that a value has after it was set to this one.
    pub(crate) fn assign(&mut self, name: &str, value: &str) -> Result<f64, Error> {
        let command = format!("{name},{value}");
        self.wire.send(format!("{command}\r\n{name}\r\n").as_bytes())?;
        let words = self.answer(&command, name, 2)?;
        self.real(words.first())
    }

    /// Sets a value. It is an error if the controller keeps one that differs by more than `error`.
    pub(crate) fn set(&mut self, name: &str, value: f64, error: f64) -> Result<(), Error> {
        let text = if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.5}") };
        let kept = self.assign(name, &text)?;
        if (kept - value).abs() <= error {
            return Ok(());
        }
        let address = &self.wire.address;
        Err(Error::Content(format!("the controller at {address} keeps {kept} as `{name}`, not {text}")))
    }

    /// Sets a whole number.
    pub(crate) fn choose(&mut self, name: &str, value: usize) -> Result<(), Error> {
        self.set(name, value as f64, 0.0)
    }

    fn strange(&self, answer: &str, expected: &str) -> Error {
        let (short, address): (String, _) = (answer.chars().take(60).collect(), &self.wire.address);
        Error::Content(format!(
            "the controller at {address} answers {short:?}, which is not {expected}: check that it is an NV200"
        ))
    }
}
