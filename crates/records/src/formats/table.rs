//! A table: the content of a file before the meaning of its columns is known. It has names, and numbers below them.
//!
//! A column that contains more than numbers (remarks, gaps) is an error only if it is used: its first flaw is stored
//! and becomes the error. A table does not repair; it interpolates only where it is asked for a sampling period.

mod even;
mod inspection;
mod rows;

use super::column::Column;
use super::quote::{listed, quoted, shortened};
use super::roles::{Missing, Role};
use super::selection::ColumnSelection;
use crate::record::{Record, Units};
use even::Even;
use piezoid_numerics::error::Error;
use std::ops::Range;

/// Relative deviation of the mean step from a stated period that is rounding.
const ROUNDED: f64 = 0.01;
/// Steps [s] from which on a time without a unit may be in milliseconds, or be the numbers of samples.
const SLOW: f64 = 0.1;

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
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    pub(super) columns: Vec<Column>,
    /// Columns of other lengths: only the user chooses them.
    pub(super) others: Vec<Column>,
    /// Line of the names; 0 if the format has no lines.
    pub(super) header: u64,
    /// Line of the first row.
    pub(super) first: u64,
    /// Number of rows.
    pub(super) count: usize,
    /// Rows before which an empty line stands.
    pub(super) gaps: Vec<usize>,
    /// Rows before which the names stand again.
    pub(super) again: Vec<usize>,
    /// Sampling period [s], if the format states it.
    pub(super) ts: Option<f64>,
    /// Channels that were left out, with the reasons.
    pub(super) left: String,
    /// The history of the record that was written.
    pub(super) steps: Vec<String>,
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

impl Signal {
    /// The samples in another unit; `what` names them in the error.
    ///
    /// # Errors
    /// Returns an error if the conversion is unknown (see [`Units::factor`]).
    pub fn samples_in(self, unit: &str, what: &str) -> Result<Vec<f64>, Error> {
        let factor = Units::factor(&self.unit, unit).ok_or_else(|| Error::units(what, &self.unit, unit))?;
        Ok(self.samples.into_iter().map(|v| v * factor).collect())
    }
}

impl Table {
    /// Names of the columns, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|c| c.name.as_str())
    }

    /// Line of a row.
    fn line(&self, row: usize) -> u64 {
        self.first + (row + self.gaps.partition_point(|gap| *gap <= row)) as u64
    }

    /// Drops all rows but the last one.
    pub(super) fn drop_rows(&mut self) {
        let last = self.count.saturating_sub(1);
        self.first = self.line(last);
        self.count -= last;
        self.columns.iter_mut().for_each(|column| drop(column.samples.drain(..last)));
        for rows in [&mut self.gaps, &mut self.again] {
            rows.retain(|row| *row > last);
            rows.iter_mut().for_each(|row| *row -= last);
        }
    }

    /// Input and output, with their units and sampling period.
    ///
    /// # Errors
    /// Returns an error if a column is missing or ambiguous, if a cell in a used column is not a finite number, or if
    /// the time is uneven.
    pub fn record(&self, selection: &ColumnSelection) -> Result<Record, Error> {
        self.resampled(selection, None)
    }

    /// Like [`record`](Table::record); uneven times are allowed if the record is resampled to a sampling period [s]:
    /// see `even`.
    pub fn resampled(&self, selection: &ColumnSelection, resample: Option<f64>) -> Result<Record, Error> {
        let found = self.sampled([Role::Input, Role::Output], selection, resample);
        let ([u, y], step) = found.map_err(|error| self.located(error))?;
        let units = Units { u: u.unit, y: y.unit };
        let record = Record::new(u.ts, u.samples, y.samples)?.with_units(units);
        let steps = self.steps.iter().cloned().chain(self.history(selection)).chain(step);
        Ok(steps.fold(record, Record::with_step))
    }

    /// The input alone; the file need not have an output.
    ///
    /// # Errors
    /// The errors of [`record`](Table::record).
    pub fn input(&self, selection: &ColumnSelection) -> Result<Signal, Error> {
        self.single(Role::Input, selection)
    }

    /// A reference; the file need not have an input. It is the only `r_*`, or if there is none, the output.
    ///
    /// # Errors
    /// The errors of [`record`](Table::record).
    pub fn reference(&self, selection: &ColumnSelection) -> Result<Signal, Error> {
        let any = |prefix| self.names().any(|name| name.starts_with(prefix));
        let sentence = selection.output_col.is_none() && (any("r_") || !any("y_"));
        self.single(if sentence { Role::Reference } else { Role::Output }, selection)
    }

    fn single(&self, role: Role, selection: &ColumnSelection) -> Result<Signal, Error> {
        self.sampled([role], selection, None).map(|([signal], _)| signal).map_err(|error| self.located(error))
    }

    /// True if something states the times of the rows: the selection, a column, or the format.
    pub fn is_timed(&self, selection: &ColumnSelection) -> bool {
        let own = self.ts.is_some() || self.columns.iter().any(|column| column.ts.is_some());
        own || selection.period() != Ok(None) || Role::Time.find(self, selection).is_ok()
    }

    /// The columns with these roles, which have no flaw, and how they were made even if they were not.
    fn sampled<const N: usize>(
        &self,
        roles: [Role; N],
        selection: &ColumnSelection,
        resample: Option<f64>,
    ) -> Result<([Signal; N], Option<String>), Error> {
        let mut needed = Vec::with_capacity(N + 1);
        let mut missing = Vec::new();
        let mut look = |role: Role, needed: &mut Vec<_>| match role.find(self, selection) {
            Ok(column) => needed.push(column),
            Err(error) => missing.push(error),
        };
        for role in roles {
            look(role, &mut needed);
        }
        // The period that the user gives, else that of the time stamps, else that of the format.
        let stated = selection.period()?;
        let count = needed.len();
        let own = needed.first().and_then(|column: &&Column| column.ts).or(self.ts);
        if stated.is_none()
            && (own.is_none() || selection.time_col.is_some() || Role::Time.find(self, selection).is_ok())
        {
            look(Role::Time, &mut needed);
        }
        if !missing.is_empty() {
            return Err(Missing::error(missing, self, selection));
        }
        self.usable(&needed)?;
        if needed.len() == count {
            let differs = |column: &&&Column| stated.is_none() && column.ts.is_some() && column.ts != own;
            if let (Some(other), Some(own)) = (needed.iter().find(differs), own) {
                let [first, other, ts] =
                    [quoted(&needed[0].name), quoted(&other.name), other.ts.unwrap_or_default().to_string()];
                let problem =
                    format!("{first} is sampled every {own} s, but {other} every {ts} s: resample one of them");
                return Err(Error::Content(problem));
            }
        }
        let n = needed[0].samples.len();
        let rows = match (stated, needed.get(count)) {
            (Some(ts), _) => self.cut(ts, selection, n)?,
            (None, Some(time)) => self.timed(time, selection, own, resample.is_some())?,
            (None, None) => self.cut(own.unwrap_or_default(), selection, n)?,
        };
        let at = |row: usize| match (rows.unit, needed.get(count)) {
            (Some(unit), Some(time)) => rows::elapsed(&time.samples, unit, row),
            _ => row as f64 * rows.ts,
        };
        self.finite(&needed, &rows.range, &at)?;
        if needed.len() == count {
            self.is_one_record(selection, &rows.range)?;
        }
        let even = rows.stamps.as_deref().map(|stamps| Even::over(stamps, rows.ts, resample, at(rows.range.start)));
        let even = even.transpose()?;
        let mut signals = Vec::with_capacity(N);
        for (role, column) in roles.into_iter().zip(&needed) {
            let (unit, factor) = column.unit_and_factor(role, selection)?;
            let mut samples = column.samples[rows.range.clone()].to_vec();
            if factor != 1.0 {
                samples.iter_mut().for_each(|sample| *sample *= factor);
            }
            if let Some(even) = &even {
                samples = even.interpolated(&samples);
            }
            signals.push(Signal { ts: even.as_ref().map_or(rows.ts, |even| even.ts), samples, unit });
        }
        // As many signals as roles.
        let signals = signals.try_into().map_err(|_| Error::Content("a column is missing".into()))?;
        Ok((signals, even.map(|even| even.step)))
    }

    /// Returns an error if the names stand again between these rows, and no time shows that the record goes on there.
    fn is_one_record(&self, selection: &ColumnSelection, rows: &Range<usize>) -> Result<(), Error> {
        let time = Role::Time.find(self, selection).ok();
        let goes_on = |row: usize| {
            time.is_some_and(|time| row > 0 && matches!(time.samples.get(row - 1..=row), Some([a, b]) if a < b))
        };
        let begins_another =
            |row: &usize| rows.contains(row) && (*row == 0 || rows.contains(&(row - 1))) && !goes_on(*row);
        let Some(row) = self.again.iter().copied().find(begins_another) else { return Ok(()) };
        let problem = "the names stand again: if another record begins here, split the file; if not, delete the line";
        Err(Error::line(self.line(row) - 1, problem))
    }

    /// Returns an error if a column is used twice, if its numbers are in doubt, or if the decimal separators of columns
    /// differ.
    fn usable(&self, needed: &[&Column]) -> Result<(), Error> {
        for (i, column) in needed.iter().enumerate() {
            if needed[..i].iter().any(|earlier| std::ptr::eq(*earlier, *column)) {
                let problem = "chosen twice: time, input and output must be different columns";
                return Err(column.error(self.header, problem));
            }
            let wordy = column.flaw.as_ref().filter(|_| column.samples.is_empty());
            if let Some(error) = column.doubt.as_ref().or(wordy) {
                return Err(error.clone());
            }
            let [(left, left_len), (right, right_len)] =
                [needed[0], column].map(|column| (shortened(&column.name), column.samples.len()));
            if left_len != right_len {
                return Err(Error::Lengths { left, left_len, right, right_len });
            }
        }
        let sign = |expected: char| {
            needed.iter().find_map(|c| c.decimal.filter(|(sign, _)| *sign == expected).map(|(_, line)| (c, line)))
        };
        let (Some((point, above)), Some((comma, line))) = (sign('.'), sign(',')) else { return Ok(()) };
        let name = quoted(&point.name);
        let problem = format!(
            "a decimal comma, but line {above} has a decimal point in {name}: use one of them throughout, and no \
             thousands separator"
        );
        Err(comma.error(line, problem))
    }

    /// The error for this table. If its format has rows, counted from 0, instead of lines, it also lists what was left
    /// out, because a missing name may be there.
    fn located(&self, error: Error) -> Error {
        if self.first > 0 {
            return error;
        }
        let left = if self.left.is_empty() { String::new() } else { format!("; left out: {}", self.left) };
        match error {
            Error::Line { line: 0, column, problem } => {
                // Options follow the last part of the message.
                let (sentence, more) = problem.split_at(problem.rfind("; ").unwrap_or(problem.len()));
                Error::Row { row: None, column, problem: format!("{sentence}{left}{more}") }
            }
            Error::Advised { error, options, all } => {
                Error::Advised { error: Box::new(self.located(*error)), options, all }
            }
            Error::Line { line, column, problem } => Error::Row { row: Some(line), column, problem },
            Error::Unknown { .. } => Error::Content(format!("{error}{left}")),
            other => other,
        }
    }

    /// An error about the names as a whole, with all names.
    pub fn about_names(&self, wrong: &str, remedy: &str) -> Error {
        let titles: Vec<String> = self.columns.iter().map(|column| self.title(column)).collect();
        let columns = match self.columns.iter().find(|column| !column.name.is_empty()) {
            _ if titles.is_empty() => ": there is no column of numbers".into(),
            None => format!(": the columns have no names, but numbers from 1 to {}", titles.len()),
            Some(_) => format!(" among the columns {}", listed(titles.iter().map(String::as_str))),
        };
        Error::line(if self.header > 0 { self.header } else { self.first }, format!("{wrong}{columns}{remedy}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(file: &str) -> Table {
        Table::parse(file.as_bytes()).unwrap()
    }

    #[test]
    fn a_stated_sampling_period_is_doubted_if_the_file_says_another_or_nobody_means_it() {
        let sentence = |text: &str, ts: Option<f64>, fs: Option<f64>| {
            let selection = ColumnSelection { ts, fs, ..ColumnSelection::default() };
            parsed(text).record(&selection).unwrap().history().join("; ")
        };
        let (timed, bare) = ("t_s,u_V,y_um\n0,1,2\n5e-4,2,3\n1e-3,3,4\n", "u_V,y_um\n1,2\n2,3\n");
        assert_eq!(sentence(timed, Some(5e-4), None) + &sentence(bare, Some(2.0), None), "");
        let doubt = sentence(timed, Some(2000.0), None);
        assert!(doubt.contains("the sampling period is 0.0005 s in the file, but 2000 s in the options"), "{doubt}");
        assert!(doubt.ends_with("if 2000 is the sampling rate in Hz, state it as such"), "{doubt}");
        let doubt = sentence(&format!("# rate: 10 kHz\n{timed}"), None, None);
        assert_eq!(
            doubt,
            "the file states a sampling period of 0.0001 s: the time column is used, which has steps of 0.0005 s"
        );
        let doubt = sentence(timed, None, Some(1000.0));
        assert!(doubt.ends_with("but 0.001 s in the options"), "{doubt}");
        let doubt = sentence(bare, None, Some(5e-4));
        assert!(doubt.ends_with("is 2000 s: if 0.0005 is the sampling period in s, state it as such"), "{doubt}");
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
        let table = parsed("clock_s,monitor,Sensor [nm],u_V,y_um\n0,1,2,x,x\n0.1,2,3,x,x\n");
        let selection = ColumnSelection {
            input_col: Some("monitor".into()),
            output_col: Some("Sensor [nm]".into()),
            time_col: Some("clock_s".into()),
            ..ColumnSelection::default()
        };
        let record = table.record(&selection).unwrap();
        assert_eq!((record.u(), record.y()), (&[1.0, 2.0][..], &[2.0, 3.0][..]));
        assert_eq!(record.units(), &Units { u: "V".into(), y: "nm".into() });
    }

    #[test]
    fn a_stated_unit_that_the_file_contradicts_is_told_and_one_that_is_none_refused() {
        let table = parsed("t (s),u (V),y (um)\n0,1,2\n1e-3,2,3\n");
        let sentence = |unit: &str| ColumnSelection { output_unit: Some(unit.into()), ..ColumnSelection::default() };
        let record = table.record(&sentence("nm")).unwrap();
        assert_eq!((record.y(), &*record.units().y), (&[2.0, 3.0][..], "nm"));
        let message = "unit of the output: nm as stated; the file has um";
        assert!(record.history().iter().any(|step| step == message), "{:?}", record.history());
        assert_eq!(table.described(&sentence("nm"))[2]["unit"], "nm");
        for agrees in ["um", "\u{b5}m"] {
            assert_eq!(table.record(&sentence(agrees)).unwrap().history().len(), 1, "{agrees}");
        }
        let millis = ColumnSelection { time_unit: Some("ms".into()), ..ColumnSelection::default() };
        let record = table.record(&millis).unwrap();
        assert!(record.history().iter().any(|step| step == "unit of the time: ms as stated; the file has s"));
        assert_eq!(table.record(&sentence("furlong")).unwrap().units().y, "furlong");
        for none in ["", "5", "12um", "--"] {
            let refused = table.record(&sentence(none)).unwrap_err().to_string();
            assert!(refused.ends_with("must be a word of letters such as um, or %, or counts"), "{refused}");
        }
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
