//! Records and signals as CSV. Reading them gives bit-identical numbers.
//!
//! Each sample is written as the shortest decimal number that reads back as the same number. Time stamps are exact
//! decimal multiples of the sampling period as it is written: 0.0015, never 0.0015000000000000002.

use crate::error::{Error, finite, positive};
use crate::formats::Table;
use crate::record::Record;
use std::fmt::Write;

impl Table {
    /// A CSV file: the time column `t_s`, multiples of `ts` [s] from 0, then these columns, named with their units.
    ///
    /// ```
    /// let text = piezoid::formats::Table::write(5e-4, &[("u_V", &[0.0, 1.0, 2.5]), ("y_um", &[0.1, -0.2, 1e-9])])?;
    /// assert_eq!(text, "t_s,u_V,y_um\n0.0000,0,0.1\n0.0005,1,-0.2\n0.0010,2.5,1e-9\n");
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// `ts` must be positive, the columns equally long and finite, and their names different and without line ends.
    pub fn write(ts: f64, columns: &[(&str, &[f64])]) -> Result<String, Error> {
        positive("ts", ts, "seconds")?;
        let rows = columns.first().map_or(0, |(_, samples)| samples.len());
        positive("time of the last row", rows.max(1) as f64 * ts, "seconds")?;
        for (i, (name, samples)) in columns.iter().enumerate() {
            let twice = *name == "t_s" || columns[..i].iter().any(|(earlier, _)| earlier == name);
            if twice || name.trim() != *name || name.is_empty() || name.contains(char::is_control) {
                return Err(Error::parameter(
                    "column name",
                    format!("{name:?}"),
                    "must be on one line, and there only once",
                ));
            }
            if samples.len() != rows {
                let (left, left_len) = (columns[0].0.into(), rows);
                return Err(Error::Lengths { left, left_len, right: (*name).into(), right_len: samples.len() });
            }
            finite(name, samples)?;
        }
        let mut text = String::from("t_s");
        for (name, _) in columns {
            text.push(',');
            push_name(&mut text, name);
        }
        let stamps = Stamps::new(ts);
        for row in 0..rows {
            text.push('\n');
            stamps.push(&mut text, row);
            for (_, samples) in columns {
                text.push(',');
                push_number(&mut text, samples[row]);
            }
        }
        text.push('\n');
        Ok(text)
    }
}

impl Record {
    /// This record as a CSV file with the columns `t_s`, `u_*` and `y_*` in its units.
    ///
    /// # Errors
    /// Returns an error if the units contain a line end.
    pub fn to_csv(&self) -> Result<String, Error> {
        let name = |prefix: &str, unit: &str| format!("{prefix}{unit}");
        let (u, y) = (name("u_", &self.units().u), name("y_", &self.units().y));
        Table::write(self.ts(), &[(&u, self.u()), (&y, self.y())])
    }
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
    use crate::formats::{ColumnSelection, Table};
    use crate::record::Units;

    fn stamps(ts: f64, rows: usize) -> Vec<String> {
        let text = Table::write(ts, &[("u_V", &vec![0.0; rows])]).unwrap();
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
    }

    #[test]
    fn what_could_not_be_read_back_is_refused() {
        let refusal = |ts, columns: &[(&str, &[f64])]| Table::write(ts, columns).unwrap_err().to_string();
        assert!(refusal(0.0, &[]).starts_with("ts = 0"));
        assert!(refusal(1e308, &[("u_V", &[0.0; 20])]).starts_with("time of the last row = inf"));
        assert!(refusal(1.0, &[("u_V", &[f64::NAN])]).starts_with("u_V[0] is NaN"));
        assert!(refusal(1.0, &[("u_V", &[0.0]), ("y_um", &[])]).starts_with("u_V has 1 samples but y_um has 0"));
        assert!(refusal(1.0, &[("u_V", &[0.0]), ("u_V", &[0.0])]).contains("only once"));
        assert!(refusal(1.0, &[("u\n", &[0.0])]).starts_with("column name = \"u\\n\""));
    }

    #[test]
    fn a_record_keeps_its_units_however_odd() {
        let units = Units { u: "mV".into(), y: "a;\"b\", c".into() };
        let record = Record::new(0.3, vec![-0.0, 1e-300], vec![f64::MAX, f64::MIN_POSITIVE]).unwrap().with_units(units);
        let text = record.to_csv().unwrap();
        assert_eq!(Table::parse(text.as_bytes()).unwrap().record(&ColumnSelection::default()).unwrap(), record);
    }
}
