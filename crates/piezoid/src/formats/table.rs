//! A table: the content of a file before the meaning of its columns is known. It has names, and numbers below them.
//!
//! A column that contains more than numbers (remarks, gaps) is an error only if it is used: its first flaw is stored
//! and becomes the error. A table does not interpolate, resample or repair.

use super::quote::{listed, quoted, shortened};
use super::selection::{ColumnRole, ColumnSelection, INPUT, OUTPUT, REFERENCE, TIME, in_seconds};
use super::time;
use crate::error::{Error, positive};
use crate::record::{Record, Units};

/// Named columns of numbers, all equally long.
///
/// ```
/// use piezoid::formats::{ColumnSelection, Table};
///
/// let table = Table::parse(b"t_s,u_V,y_um\n0.0,0.0,0.1\n0.0005,1.0,20.3\n")?;
/// let record = table.record(&ColumnSelection::default())?;
/// assert_eq!((record.ts(), record.u(), record.units().y.as_str()), (5e-4, &[0.0, 1.0][..], "um"));
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub(super) columns: Vec<Column>,
    /// Line of the names; 0 if the format has no lines.
    pub(super) header: u64,
    /// Line of the first row; each row has one line.
    pub(super) first: u64,
    /// Sampling period [s], if the format states it.
    pub(super) ts: Option<f64>,
    /// Channels that were left out, with the reasons.
    pub(super) left: String,
}

/// One column of a [`Table`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    pub(super) name: String,
    /// Its unit, if the format states it separately from the name.
    pub(super) unit: Option<String>,
    /// The numbers before the first flaw.
    pub(super) samples: Vec<f64>,
    /// The first cell that is not a finite number, as the error if the column is used.
    pub(super) flaw: Option<Error>,
    /// The decimal separator, point or comma, and the line of its first use.
    pub(super) decimal: Option<(char, u64)>,
}

impl Record {
    /// The record in a CSV file. Columns are found by their names, unless `columns` selects others.
    ///
    /// ```
    /// use piezoid::{Record, formats::ColumnSelection};
    /// let record = Record::from_csv(b"t_s,u_V,y_um\n0.0,0.0,0.1\n0.0005,1.0,20.3\n", &ColumnSelection::default())?;
    /// assert_eq!((record.ts(), record.y()), (5e-4, &[0.1, 20.3][..]));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Table::parse`] and [`Table::record`].
    pub fn from_csv(bytes: &[u8], columns: &ColumnSelection) -> Result<Self, Error> {
        Table::parse(bytes)?.record(columns)
    }
}

/// One column with its sampling period: an input to simulate, a reference to follow.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Sampling period [s].
    pub ts: f64,
    /// The samples, in `unit`.
    pub samples: Vec<f64>,
    /// Unit of the samples, from the column's name.
    pub unit: String,
}

impl Table {
    /// A table without columns or lines.
    pub(super) fn empty() -> Self {
        Table { columns: Vec::new(), header: 0, first: 0, ts: None, left: String::new() }
    }

    /// Names of the columns, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|c| c.name.as_str())
    }

    /// Input and output, with their units and sampling period.
    ///
    /// # Errors
    /// Returns an error if a column is missing or ambiguous, if a cell in a used column is not a finite number, or if
    /// the time is uneven.
    pub fn record(&self, selection: &ColumnSelection) -> Result<Record, Error> {
        let (ts, [u, y]) = self.sampled([&INPUT, &OUTPUT], selection)?;
        let units = Units { u: u.unit("u_"), y: y.unit("y_") };
        let part = selection.part(ts, u.samples.len())?;
        Ok(Record::new(ts, u.samples[part.clone()].to_vec(), y.samples[part].to_vec())?.with_units(units))
    }

    /// The input alone; the file need not have an output.
    ///
    /// # Errors
    /// The errors of [`record`](Table::record).
    pub fn input(&self, selection: &ColumnSelection) -> Result<Signal, Error> {
        let (ts, [u]) = self.sampled([&INPUT], selection)?;
        Ok(Signal { ts, samples: u.samples[selection.part(ts, u.samples.len())?].to_vec(), unit: u.unit("u_") })
    }

    /// A reference; the file need not have an input. It is the only `r_*`, or if there is none, the output.
    ///
    /// # Errors
    /// The errors of [`record`](Table::record).
    pub fn reference(&self, selection: &ColumnSelection) -> Result<Signal, Error> {
        let any = |prefix| self.names().any(|name| name.starts_with(prefix));
        let said = selection.output_col.is_none() && (any("r_") || !any("y_"));
        let (role, prefix) = if said { (&REFERENCE, "r_") } else { (&OUTPUT, "y_") };
        let (ts, [r]) = self.sampled([role], selection)?;
        Ok(Signal { ts, samples: r.samples[selection.part(ts, r.samples.len())?].to_vec(), unit: r.unit(prefix) })
    }

    /// The sampling period [s], and the columns with these roles, which have no flaw.
    fn sampled<const N: usize>(
        &self,
        roles: [&ColumnRole; N],
        selection: &ColumnSelection,
    ) -> Result<(f64, [&Column; N]), Error> {
        self.found(roles, selection).map_err(|error| if self.header > 0 { error } else { self.without_lines(error) })
    }

    fn found<const N: usize>(
        &self,
        roles: [&ColumnRole; N],
        selection: &ColumnSelection,
    ) -> Result<(f64, [&Column; N]), Error> {
        let mut needed = Vec::with_capacity(N + 1);
        for role in roles {
            needed.push(role.find(self, selection)?);
        }
        // The period that the user gives, else that of the time stamps, else that of the format.
        let time = TIME.find(self, selection);
        let stated = selection.ts.or_else(|| self.ts.filter(|_| time.is_err() && selection.time_col.is_none()));
        if stated.is_none() {
            needed.push(in_seconds(time?, self.header)?);
        }
        self.usable(&needed)?;
        let ts = match stated {
            Some(ts) => ts,
            None => time::period(&needed[N].samples, &shortened(&needed[N].name), self.first)?,
        };
        Ok((positive("ts", ts, "seconds")?, std::array::from_fn(|i| needed[i])))
    }

    /// Returns an error if a column is used twice, if it has a flaw, or if the decimal separators of columns differ.
    fn usable(&self, needed: &[&Column]) -> Result<(), Error> {
        for (i, column) in needed.iter().enumerate() {
            if needed[..i].iter().any(|earlier| earlier.name == column.name) {
                return Err(Error::Line {
                    line: self.header,
                    column: Some(shortened(&column.name)),
                    problem: "chosen twice: time, input and output must be different columns".into(),
                });
            }
            if let Some(flaw) = &column.flaw {
                return Err(flaw.clone());
            }
        }
        let sign = |wanted: char| {
            needed.iter().find_map(|c| c.decimal.filter(|(sign, _)| *sign == wanted).map(|(_, line)| (&c.name, line)))
        };
        match (sign('.'), sign(',')) {
            (Some((point, above)), Some((comma, line))) => Err(Error::Line {
                line,
                column: Some(shortened(comma)),
                problem: format!(
                    "a decimal comma, but line {above} has a decimal point in {}: use one of them throughout, and no \
                     thousands separator",
                    quoted(point)
                ),
            }),
            _ => Ok(()),
        }
    }

    /// The error for a format that has rows, counted from 0, instead of lines. It also lists what was left out, because
    /// a missing name may be there.
    fn without_lines(&self, error: Error) -> Error {
        let left = if self.left.is_empty() { String::new() } else { format!("; left out: {}", self.left) };
        match error {
            Error::Line { line: 0, column, problem } if problem.ends_with("; ") => {
                Error::Row { row: None, column, problem: format!("{}{left}; ", problem.trim_end_matches("; ")) }
            }
            Error::Line { line: 0, column, problem } => Error::Row { row: None, column, problem: problem + &left },
            Error::Advised { error, options } => {
                Error::Advised { error: Box::new(self.without_lines(*error)), options }
            }
            Error::Line { line, column, problem } => Error::Row { row: Some(line), column, problem },
            Error::Unknown { .. } => Error::Content(format!("{error}{left}")),
            other => other,
        }
    }

    /// An error about the names as a whole, with all names.
    pub(super) fn about_names(&self, wrong: &str, remedy: &str) -> Error {
        Error::Line {
            line: self.header,
            column: None,
            problem: format!("{wrong} among the columns {}{remedy}", listed(self.names())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(file: &str) -> Table {
        Table::parse(file.as_bytes()).unwrap()
    }

    #[test]
    fn units_come_with_the_names() {
        let record = parsed("t_s,u_cmdV,y_counts\n0,1,2\n1,2,3\n").record(&ColumnSelection::default()).unwrap();
        assert_eq!(record.units(), &Units { u: "cmdV".into(), y: "counts".into() });
    }

    #[test]
    fn an_input_needs_no_output() {
        let table = parsed("t_s,u_V,note\n0,1,\n0.1,2,\n");
        let signal = table.input(&ColumnSelection::default()).unwrap();
        assert_eq!(signal, Signal { ts: 0.1, samples: vec![1.0, 2.0], unit: "V".into() });
        assert!(table.record(&ColumnSelection::default()).unwrap_err().to_string().contains("no output column"));
    }

    #[test]
    fn ts_replaces_the_time_column_whatever_it_holds() {
        let ts = ColumnSelection { ts: Some(0.005), ..ColumnSelection::default() };
        for file in ["u_V,y_um\n1,2\n", "t_s,u_V,y_um\nnoon,1,2\n", "t_s,u_V,y_um\n0,1,2\n0,1,2\n"] {
            assert_eq!(parsed(file).record(&ts).unwrap().ts(), 0.005);
        }
        let wrong = ColumnSelection { ts: Some(-1.0), ..ColumnSelection::default() };
        assert_eq!(
            parsed("u_V,y_um\n1,2\n").record(&wrong).unwrap_err().to_string(),
            "ts = -1: must be a positive number of seconds"
        );
    }

    #[test]
    fn columns_are_chosen_by_name() {
        let table = parsed("clock,monitor,Sensor [nm],u_V,y_um\n0,1,2,x,x\n0.1,2,3,x,x\n");
        let selection = ColumnSelection {
            input_col: Some("monitor".into()),
            output_col: Some("Sensor [nm]".into()),
            time_col: Some("clock".into()),
            ..ColumnSelection::default()
        };
        let record = table.record(&selection).unwrap();
        assert_eq!((record.u(), record.y()), (&[1.0, 2.0][..], &[2.0, 3.0][..]));
        assert_eq!(record.units(), &Units { u: String::new(), y: "nm".into() });
    }

    #[test]
    fn one_column_cannot_play_two_roles() {
        let twice = ColumnSelection {
            input_col: Some("y_um".into()),
            output_col: Some("y_um".into()),
            ..ColumnSelection::default()
        };
        assert_eq!(
            parsed("t_s,u_V,y_um\n0,1,2\n1,2,3\n").record(&twice).unwrap_err().to_string(),
            "line 1, column y_um: chosen twice: time, input and output must be different columns"
        );
    }
}
