//! Which rows of a table are used, and when they were sampled.
//!
//! A cut counts time from the first row. If the times of all rows are even, row k is at k Ts. If they are not, or if
//! some are missing, the stamps tell which rows a cut keeps: what lies outside does not matter.

use super::super::column::Column;
use super::super::quote::{quoted, shortened};
use super::super::selection::ColumnSelection;
use super::super::time;
use super::super::units::Quantity;
use super::{ROUNDED, SLOW, Table};
use crate::quality::runs;
use crate::record::Record;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{exact, join};
use serde_json::Value;
use std::ops::Range;

/// Relative deviation of the stamps from a stated period that is the rounding of the stamps.
const NOMINAL: f64 = 1e-5;
/// Largest number of places that a message lists.
const PLACES: usize = 4;
/// Digits of a time that tell every row of a record from the next.
const DIGITS: usize = 12;

/// The rows that are used.
#[derive(Debug, PartialEq)]
pub(super) struct Rows {
    pub(super) range: Range<usize>,
    /// Sampling period [s].
    pub(super) ts: f64,
    /// The seconds of the unit of the stamps, if these tell the rows; else row k is at k Ts.
    pub(super) unit: Option<f64>,
    /// Times of these rows [s], if they are uneven.
    pub(super) stamps: Option<Vec<f64>>,
}

impl Table {
    /// The rows that a cut keeps of rows that are `ts` [s] apart.
    pub(super) fn cut(&self, ts: f64, selection: &ColumnSelection, n: usize) -> Result<Rows, Error> {
        Ok(Rows { range: selection.part(ts, n)?, ts, unit: None, stamps: None })
    }

    /// The rows that a cut keeps, by a time column; uneven times are kept if they are `expected`.
    pub(super) fn timed(
        &self,
        time: &Column,
        selection: &ColumnSelection,
        stated: Option<f64>,
        expected: bool,
    ) -> Result<Rows, Error> {
        let n = time.samples.len();
        let whole = self.period(time, 0..n, selection, stated);
        let cut = selection.from.is_some() || selection.to.is_some();
        match whole {
            Ok(ts) => return self.cut(ts, selection, n),
            Err(error) if !cut && !expected => return Err(error),
            _ => {}
        }
        let unit = self.seconds(time, selection, stated)?.unwrap_or(1.0);
        let range = if cut { between(&time.samples, unit, selection)? } else { 0..n };
        self.finite(&[time], &range, &|row| elapsed(&time.samples, unit, row))?;
        match self.period(time, range.clone(), selection, stated) {
            Ok(ts) => Ok(Rows { range, ts, unit: Some(unit), stamps: None }),
            Err(error) if !expected => Err(error),
            Err(error) => {
                let stamps: Vec<f64> = time.samples[range.clone()].iter().map(|t| t * unit).collect();
                let ts = time::step(&stamps).ok_or(error)?;
                Ok(Rows { range, ts, unit: Some(unit), stamps: Some(stamps) })
            }
        }
    }

    /// The number of seconds of the unit of a time column; a stated period determines the unit of a time without one.
    fn seconds(&self, time: &Column, selection: &ColumnSelection, stated: Option<f64>) -> Result<Option<f64>, Error> {
        if let (Some(seconds), _) | (None, Some(Quantity::Time(seconds))) = (selection.seconds()?, time.quantity()) {
            return Ok(Some(seconds));
        }
        if let Some(unit) = time.stated() {
            return self.unclear(time, format!("the unit {} of the time is not known: ", quoted(unit)));
        }
        let mean = time::mean(&time.samples);
        let agrees = |unit: &f64| stated.is_some_and(|ts| (mean * unit / ts - 1.0).abs() < ROUNDED);
        Ok([1.0, 1e-3, 1e-6, 1e-9].into_iter().find(agrees))
    }

    /// The error about a time column whose unit is not clear.
    fn unclear<T>(&self, time: &Column, problem: String) -> Result<T, Error> {
        Err(time.error(self.header, problem).advised(vec![("time_unit", Value::Null), ("fs", Value::Null)]))
    }

    /// The sampling period [s] of these rows of a time column.
    pub(super) fn period(
        &self,
        time: &Column,
        rows: Range<usize>,
        selection: &ColumnSelection,
        stated: Option<f64>,
    ) -> Result<f64, Error> {
        let seconds = self.seconds(time, selection, stated)?;
        let unit = seconds.unwrap_or(1.0);
        self.finite(&[time], &rows, &|row| elapsed(&time.samples, unit, row))?;
        let stamps = &time.samples[rows.clone()];
        let line = |row: usize| self.line(rows.start + row);
        let scaled = || stamps.iter().map(|t| t * unit).collect::<Vec<_>>();
        let found = time::period(stamps, &shortened(&time.name), &line).map_err(|error| match unit {
            1.0 => error,
            // The message is in seconds.
            _ => time::period(&scaled(), &shortened(&time.name), &line).err().unwrap_or(error),
        });
        // Rounded stamps are no error if the file states the period that they mean.
        let found = match (found, stated) {
            (Err(_), Some(ts)) if time::rounds(stamps, ts / unit) => return Ok(ts),
            (found, _) => found?,
        };
        let found_seconds = seconds.map(|seconds| time::times(found, seconds));
        if let (Some(found), Some(stated)) = (found_seconds, stated)
            && (found / stated - 1.0).abs() < NOMINAL
        {
            return Ok(stated);
        }
        self.in_seconds(time, seconds, found)
    }

    /// A period of a time column, whose unit has so many seconds if it is known, in seconds.
    fn in_seconds(&self, time: &Column, seconds: Option<f64>, found: f64) -> Result<f64, Error> {
        match seconds {
            Some(seconds) => Ok(time::times(found, seconds)),
            None if found < SLOW || time.name == "t_s" => Ok(found),
            None => {
                self.unclear(time, format!("the unit of the time is not stated, and its steps are {}: ", exact(found)))
            }
        }
    }

    /// The sampling period [s] of a time column whose stamps have this period in their unit.
    pub(in crate::formats) fn seconds_of(
        &self,
        time: &Column,
        selection: &ColumnSelection,
        period: f64,
    ) -> Result<f64, Error> {
        self.in_seconds(time, self.seconds(time, selection, None)?, period)
    }

    /// Returns an error if one of these columns has no number in one of these rows, which are at the times `at` [s].
    pub(super) fn finite(
        &self,
        columns: &[&Column],
        rows: &Range<usize>,
        at: &dyn Fn(usize) -> f64,
    ) -> Result<(), Error> {
        let lacks = |row: usize| columns.iter().any(|column| !column.samples[row].is_finite());
        let places = runs(rows.end, 0, |row| row >= rows.start && lacks(row));
        let Some(first) = places.first().map(|place| place.start) else { return Ok(()) };
        let Some(column) = columns.iter().find(|column| !column.samples[first].is_finite()) else { return Ok(()) };
        let message = match &column.flaw {
            Some(Error::Line { line, problem, .. }) if *line == self.line(first) => problem.clone(),
            Some(Error::NotFinite { .. }) => format!("the sample is {}", column.samples[first]),
            _ => "the cell holds no number".into(),
        };
        let count = places.iter().map(Range::len).sum::<usize>();
        let where_ = if count > 1 { format!("; {}", self.placed(&places, count, at)) } else { String::new() };
        // The longest part without them.
        let starts = std::iter::once(rows.start).chain(places.iter().map(|place| place.end));
        let ends = places.iter().map(|place| place.start).chain([rows.end]);
        let part = starts.zip(ends).map(|(start, end)| start..end).max_by_key(Range::len).unwrap_or_default();
        let it = if count > 1 { "them" } else { "it" };
        let problem = format!("{message}{where_}: repair {it} in the file");
        if part.len() < 2 {
            return Err(column.error(self.line(first), problem));
        }
        let time = |row: usize| Value::from(time::rounded(at(row), DIGITS));
        let from = (part.start > 0).then(|| ("from", time(part.start)));
        let to = (part.end < column.samples.len()).then(|| ("to", time(part.end)));
        let longest = if places.len() > 1 { "longest" } else { "longer" };
        let problem = format!("{problem}, or cut the record to the {longest} part without {it}: ");
        Err(column.error(self.line(first), problem).needing(from.into_iter().chain(to).collect()))
    }

    /// The rows without numbers, in words: how many, where, and when.
    fn placed(&self, places: &[Range<usize>], count: usize, at: &dyn Fn(usize) -> f64) -> String {
        let (what, many) = if self.first > 0 { ("line", "lines") } else { ("row", "rows") };
        let number = |row: usize| if self.first > 0 { self.line(row) } else { row as u64 };
        let one = |place: &Range<usize>| match place.len() {
            1 => format!("{what} {}", number(place.start)),
            _ => format!("{many} {} to {}", number(place.start), number(place.end - 1)),
        };
        let [first, .., last] = places else {
            let all: Vec<String> = places.iter().map(one).collect();
            return format!("{count} rows have no number here: {}", join(&all));
        };
        let listed = match places.len() {
            ..=PLACES => join(&places.iter().map(one).collect::<Vec<_>>()),
            n => format!("{n} places, the first {} and the last {}", one(first), one(last)),
        };
        let [from, to] = [first.start, last.end - 1].map(|row| time::rounded(at(row), 6));
        format!("{count} rows have no number: {listed} ({from} s to {to} s)")
    }
}

/// The time of row 0 and the mean step, in the unit of stamps of which some are missing.
fn course(t: &[f64]) -> (f64, f64) {
    let numbers = || t.iter().enumerate().filter(|(_, t)| t.is_finite());
    let (Some((first, start)), Some((last, end))) = (numbers().next(), numbers().next_back()) else {
        return (0.0, 0.0);
    };
    let step = if last > first { (end - start) / (last - first) as f64 } else { 0.0 };
    (start - first as f64 * step, step)
}

/// The time of a row after row 0 [s], of stamps in a unit of so many seconds.
pub(super) fn elapsed(t: &[f64], unit: f64, row: usize) -> f64 {
    let (start, step) = course(t);
    let stamp = t.get(row).filter(|t| t.is_finite());
    stamp.map_or(row as f64 * step, |stamp| stamp - start) * unit
}

/// The rows whose stamps, in a unit of so many seconds, lie within the cut.
fn between(t: &[f64], unit: f64, selection: &ColumnSelection) -> Result<Range<usize>, Error> {
    let (from, to) = (selection.from.unwrap_or(0.0), selection.to.unwrap_or(f64::INFINITY));
    let ((start, step), n) = (course(t), t.len());
    // As in `Record::span`: a time within a millionth of a step of a row is that row.
    let after = |row: &usize, time: f64| (t[*row] - start) * unit >= time - 1e-6 * step * unit;
    let first = if from == 0.0 { 0 } else { (0..n).find(|row| after(row, from)).unwrap_or(n) };
    let mut end = (first..n).find(|row| after(row, to)).unwrap_or(n);
    // Rows without a time before the first row after the cut belong to neither.
    while end < n && end > first && !t[end - 1].is_finite() {
        end -= 1;
    }
    let last = elapsed(t, unit, n - 1);
    if first < end && from >= 0.0 { Ok(first..end) } else { Err(Record::outside(from, to, last)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Channel;

    /// Rows 1 ms apart; these rows have this in place of one column.
    fn table(gaps: &[(usize, &str)], column: usize) -> Table {
        let mut text = String::from("t_s,u_V,y_um\n");
        for k in 0..100 {
            let mut cells = [format!("{}", f64::from(k) / 1000.0), format!("{k}"), format!("{}", 2 * k)];
            for (_, cell) in gaps.iter().filter(|(row, _)| *row == k as usize) {
                cells[column] = (*cell).into();
            }
            text += &format!("{}\n", cells.join(","));
        }
        Table::parse(text.as_bytes()).unwrap()
    }

    fn cut(from: Option<f64>, to: Option<f64>) -> ColumnSelection {
        ColumnSelection { from, to, ..ColumnSelection::default() }
    }

    const GAPS: &[(usize, &str)] = &[(30, "NaN"), (31, "NaN"), (60, ""), (61, "--"), (62, "#N/A")];

    #[test]
    fn rows_outside_a_cut_need_no_numbers() {
        for column in 0..3 {
            let table = table(GAPS, column);
            let read = |from, to| table.record(&cut(from, to)).map(|record| (record.ts(), record.u().to_vec()));
            let counted = |range: Range<i32>| range.map(f64::from).collect::<Vec<_>>();
            assert_eq!(read(None, Some(0.03)).unwrap(), (1e-3, counted(0..30)), "column {column}");
            assert_eq!(read(Some(0.032), Some(0.06)).unwrap(), (1e-3, counted(32..60)), "column {column}");
            assert_eq!(read(Some(0.063), None).unwrap(), (1e-3, counted(63..100)), "column {column}");
            let refused = read(Some(0.05), Some(0.07)).unwrap_err().to_string();
            assert!(refused.starts_with("line 62, column"), "{refused}");
        }
    }

    #[test]
    fn rows_outside_a_cut_may_have_uneven_times() {
        let table = table(&[(10, "0.0094"), (80, "0.0"), (81, "0.0")], 0);
        assert_eq!(table.record(&cut(Some(0.02), Some(0.07))).unwrap().len(), 50);
        assert!(table.record(&cut(None, Some(0.07))).unwrap_err().to_string().starts_with("line 12, column t_s"));
    }

    #[test]
    fn all_rows_without_numbers_are_told_with_a_cut_that_helps() {
        let refused = table(GAPS, 2).record(&cut(None, None)).unwrap_err().to_string();
        assert_eq!(
            refused,
            "line 32, column y_um: `NaN` is not a finite number; 5 rows have no number: lines 32 to 33 and lines 62 \
             to 64 (0.03 s to 0.062 s): repair them in the file, or cut the record to the longest part without them: \
             give `from` = 0.063"
        );
        assert!(table(GAPS, 2).record(&cut(Some(0.063), None)).is_ok());
        let many: Vec<_> = (0..100).step_by(5).map(|row| (row, "x")).collect();
        let refused = table(&many, 1).record(&cut(None, None)).unwrap_err().to_string();
        assert!(
            refused.contains("20 rows have no number: 20 places, the first line 2 and the last line 97"),
            "{refused}"
        );
        assert!(refused.ends_with("give `from` = 0.096"), "{refused}");
    }

    #[test]
    fn a_cut_beyond_the_end_of_uneven_times_is_refused_with_the_end() {
        let refused = table(GAPS, 0).record(&cut(Some(3.0), None)).unwrap_err().to_string();
        assert_eq!(refused, "no sample lies from 3 s on: the data span 0 s to 0.099 s");
    }

    #[test]
    fn a_stated_period_tells_the_unit_of_stamps_and_what_they_round() {
        let read = |text: &str| Table::parse(text.as_bytes()).unwrap().record(&cut(None, None));
        let rows = |times: &[f64]| times.iter().map(|t| format!("{t},1,2\n")).collect::<String>();
        let ts = |head: &str, times: &[f64]| read(&format!("{head},u_V,y_um\n{}", rows(times))).map(|r| r.ts());
        // Of milliseconds, or of nothing.
        assert_eq!(ts("# dt: 0.5 ms\nTime", &[0.0, 0.5, 1.0]), Ok(5e-4));
        assert!(ts("# dt: 0.51 ms\nTime", &[0.0, 0.5, 1.0]).is_err());
        assert_eq!(ts("# dt: 0.5 ms\nt (ms)", &[0.0, 0.0, 1.0, 1.0, 2.0, 2.0]), Ok(5e-4));
        let gap = ts("# dt: 0.5 ms\nt_s", &[0.0, 0.0005, 0.001, 0.0015, 0.003]).unwrap_err().to_string();
        assert!(gap.contains("2 rows seem to be missing"), "{gap}");
        let printed: Vec<f64> = (0..1000).map(|k| (f64::from(k) / 3e-3).round() * 1e-6).collect();
        assert_eq!(ts("# rate: 3000 Hz\nt_s", &printed), Ok(1.0 / 3000.0));
        assert_eq!(ts("# rate: 2001 Hz\nt_s", &[0.0, 0.0005, 0.001]), Ok(5e-4), "another period");
    }

    #[test]
    fn times_in_milliseconds_are_told_and_interpolated_in_seconds() {
        let table = |rows: &str| Table::parse(format!("t (ms),u_V,y_um\n{rows}").as_bytes()).unwrap();
        let back = table("0,0,0\n1,1,1\n2,2,2\n1,3,3\n").record(&cut(None, None)).unwrap_err().to_string();
        assert!(back.starts_with("line 5, column t (ms): time goes back from 0.002 s to 0.001 s"), "{back}");
        let uneven = table("0,0,0\n1200,12,24\n2000,20,40\n3200,32,64\n4000,40,80\n");
        let record = uneven.resampled(&cut(None, None), Some(1.0)).unwrap();
        assert_eq!(record.ts(), 1.0);
        piezoid_testing::assert_close(record.u(), &[0.0, 10.0, 20.0, 30.0, 40.0], 1e-12, 1e-12);
    }

    #[test]
    fn what_is_wrong_within_a_cut_is_told_with_its_place_in_the_file() {
        let refused = table(&[(80, "0.0")], 0).record(&cut(Some(0.02), None)).unwrap_err().to_string();
        assert!(refused.starts_with("line 82, column t_s: time goes back from 0.079 s to 0 s"), "{refused}");
        assert_eq!(
            table(GAPS, 2).record(&cut(Some(0.05), None)).unwrap_err().to_string(),
            "line 62, column y_um: the cell holds no number; 3 rows have no number here: lines 62 to 64: repair them \
             in the file, or cut the record to the longer part without them: give `from` = 0.063"
        );
        let counted: Vec<f64> = (0..10).map(f64::from).collect();
        let mut gaps = counted.clone();
        gaps[3..5].fill(f64::NAN);
        let channels = [("t_s", counted.clone()), ("u_V", gaps), ("y_um", counted)];
        let table = Table::of(channels.map(|(name, samples)| Channel::new(name, samples)));
        let refused = table.record(&cut(None, None)).unwrap_err().to_string();
        let expected = "row 3, u_V: the sample is NaN; 2 rows have no number here: rows 3 to 4: repair them";
        assert!(refused.starts_with(expected), "{refused}");
    }

    #[test]
    fn a_cut_takes_the_rows_whose_stamps_are_within_a_millionth_of_a_step() {
        // Half seconds, from 10 on.
        let whole = [10.0, 12.0, 14.0, 16.0, 18.0];
        let rows = |from, to| between(&whole, 0.5, &cut(from, to)).ok();
        assert_eq!((rows(Some(1.0), Some(3.0)), rows(None, Some(2.0))), (Some(1..3), Some(0..2)));
        assert_eq!((rows(Some(1.000_000_4), None), rows(Some(1.000_002), None)), (Some(1..5), Some(2..5)));
        assert_eq!([rows(Some(3.0), Some(3.0)), rows(Some(-1.0), None), rows(Some(4.5), None)], [None, None, None]);
        // Rows without a time.
        let none = f64::NAN;
        let to = |t: &[f64], to| between(t, 1.0, &cut(None, to)).ok();
        assert_eq!(to(&[0.0, 1.0, none, 3.0, 4.0], Some(2.5)), Some(0..2));
        assert_eq!((to(&[0.0, 1.0, 2.0, none], None), to(&[none, none, 2.0, 3.0], Some(1.0))), (Some(0..4), None));
        let gaps = [none, 12.0, none, 16.0];
        assert_eq!([0, 1, 2, 3, 9].map(|row| elapsed(&gaps, 0.5, row)), [0.0, 1.0, 2.0, 3.0, 9.0]);
        assert_eq!(elapsed(&[none, 5.0, none], 1.0, 2), 0.0, "a single time");
    }
}
