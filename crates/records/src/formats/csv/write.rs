//! Columns as CSV.
//!
//! Each sample is written as the shortest decimal number that reads back as the same number. Time stamps are exact
//! decimal multiples of the sampling period as it is written: 0.0015, never 0.0015000000000000002.

use crate::formats::history;
use piezoid_numerics::error::Error;
use std::fmt::Write;
use std::io;

/// Number of bytes that are written at once.
const BLOCK: usize = 1 << 16;

/// The columns as text, below their names and beside their times; above all of it the steps of their history.
pub(super) fn write(ts: f64, columns: &[(&str, &[f64])], steps: &[String]) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let (names, samples): (Vec<&str>, Vec<&[f64]>) = columns.iter().copied().unzip();
    Writer::new(&mut bytes, ts, &names, steps)?.rows(&samples)?;
    Ok(bytes)
}

/// Writes rows that follow each other, piece by piece.
pub(in crate::formats) struct Writer<W> {
    to: W,
    stamps: Stamps,
    /// Number of rows that were written.
    rows: usize,
    text: String,
}

impl<W: io::Write> Writer<W> {
    /// Writes the steps of the history and the names.
    pub(in crate::formats) fn new(to: W, ts: f64, names: &[&str], steps: &[String]) -> Result<Self, Error> {
        let mut text = history::lines(steps);
        text.push_str("t_s");
        for name in names {
            text.push(',');
            push_name(&mut text, name);
        }
        text.push('\n');
        let mut writer = Writer { to, stamps: Stamps::new(ts), rows: 0, text };
        writer.flush()?;
        Ok(writer)
    }

    /// Writes rows of these columns, which are equally long.
    pub(in crate::formats) fn rows(&mut self, columns: &[&[f64]]) -> Result<(), Error> {
        for row in 0..columns.first().map_or(0, |samples| samples.len()) {
            self.stamps.push(&mut self.text, self.rows);
            for samples in columns {
                self.text.push(',');
                push_number(&mut self.text, samples[row]);
            }
            self.text.push('\n');
            self.rows += 1;
            if self.text.len() > BLOCK {
                self.flush()?;
            }
        }
        self.flush()
    }

    fn flush(&mut self) -> Result<(), Error> {
        let written = self.to.write_all(self.text.as_bytes());
        self.text.clear();
        written.map_err(|error| Error::Content(format!("cannot be written to its end: {error}")))
    }
}

/// The time stamps [s] of this many rows: the numbers that are read from those of [`write`].
pub(in crate::formats) fn times(ts: f64, rows: usize) -> Vec<f64> {
    let stamps = Stamps::new(ts);
    let mut text = String::new();
    let time = |row: usize| {
        text.clear();
        stamps.push(&mut text, row);
        text.parse().unwrap_or(row as f64 * ts)
    };
    (0..rows).map(time).collect()
}

/// A name, in quotes if it contains a separator or a quote.
fn push_name(text: &mut String, name: &str) {
    if name.contains([',', ';', '"']) {
        text.extend(["\"", &name.replace('"', "\"\""), "\""]);
    } else {
        text.push_str(name);
    }
}

/// The shortest number that reads back as this one, with a power of ten if there would be many zeros.
fn push_number(text: &mut String, value: f64) {
    let plain = value == 0.0 || (1e-5..1e16).contains(&value.abs());
    // Writing to a String cannot fail.
    let _ = if plain { write!(text, "{value}") } else { write!(text, "{value:e}") };
}

/// Decimal multiples of a sampling period `digits` x 10^-`decimals`.
struct Stamps {
    digits: u128,
    decimals: i32,
}

impl Stamps {
    fn new(ts: f64) -> Self {
        let written = format!("{ts:e}");
        let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
        let fraction = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
        let digit = |c: char| c.to_digit(10).map(u128::from);
        Stamps {
            digits: mantissa.chars().filter_map(digit).fold(0, |number, digit| 10 * number + digit),
            decimals: fraction - exponent.parse::<i32>().unwrap_or(0),
        }
    }

    /// Time stamp `k`. The product of 17 and 20 digits fits into the 38 digits of an u128.
    fn push(&self, text: &mut String, k: usize) {
        let product = self.digits * k as u128;
        let decimals = usize::try_from(self.decimals).unwrap_or(0);
        let zeros = usize::try_from(-self.decimals).unwrap_or(0);
        let _ = write!(text, "{product:0>width$}", width = decimals + 1);
        if decimals > 0 {
            text.insert(text.len() - decimals, '.');
        }
        if product > 0 {
            text.extend(std::iter::repeat_n('0', zeros));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(ts: f64, rows: usize) -> Vec<String> {
        let text = String::from_utf8(write(ts, &[("u_V", &vec![0.0; rows])], &[]).unwrap()).unwrap();
        text.lines().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect()
    }

    #[test]
    fn time_is_written_in_exact_decimals() {
        assert_eq!(stamps(5e-4, 4), ["0.0000", "0.0005", "0.0010", "0.0015"]);
        assert_eq!(stamps(0.1, 4)[3], "0.3");
        assert_eq!(stamps(2.0, 3), ["0", "2", "4"]);
        assert_eq!(stamps(300.0, 3), ["0", "300", "600"]);
        assert_eq!(stamps(2.5e-5, 4)[3], "0.000075");
        assert_eq!(stamps(1.0 / 3.0, 3)[2], "0.6666666666666666");
        assert_eq!(times(0.1, 4), [0.0, 0.1, 0.2, 0.3]);
    }
}
