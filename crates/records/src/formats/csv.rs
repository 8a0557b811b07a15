//! CSV as other programs write it: a head with names, then rows of numbers.
//!
//! Tabs, semicolons, commas or spaces separate; the decimal separator may be a comma. Read: UTF-8, UTF-16 and
//! Windows-1252; any line ends; quotes and spaces around cells; blank lines; remarks above the rows, among them those
//! of oscilloscopes and loggers; units in a row of their own; times of day; a summary below the rows. [`head`] finds
//! names, units and sampling period, [`dialect`] what separates cells. Everything else is an error with line and
//! column. Not supported: cells that span lines, several tables in one file.
//!
//! The lines are split here and not by the csv crate: an error names its line for any line ends, an unclosed quote ends
//! at its line and does not include the rest of the file, and no cell is copied. In tests, the csv crate reads what is
//! written here. [`Table::parse`] is pure and accepts any bytes, so a fuzzer can call it directly.

mod cells;
mod clock;
mod dialect;
mod encoding;
mod head;
mod number;
mod rows;
mod text;
mod write;

#[cfg(feature = "foreign")]
pub(super) use encoding::decode;
pub(super) use encoding::lines;
pub(super) use head::stated_period;
pub(super) use rows::{Rows, read};
pub(super) use text::PIECE;
pub(super) use write::{Writer, times};

use super::Format;
use super::column::Column;
use super::quote::shortened;
use super::table::Table;
use cells::cells;
use dialect::Dialect;
use head::Head;
use piezoid_numerics::error::Error;

/// The row of CSV. It matches every file that no other row matches: its errors say what a file should look like.
pub(super) const ROW: Format = Format {
    name: "csv",
    extensions: &["csv", "tsv", "txt", "dat", "asc", "lvm"],
    summary: "text, a row of names above rows of numbers",
    reference: "RFC 4180, https://doi.org/10.17487/RFC4180",
    matches: |_| true,
    read: Table::parse,
    in_pieces: true,
    write: Some(write::write),
};

/// What a file should look like, for messages.
const EXAMPLE: &str = "`t_s,u_V,y_um`";
/// Signs at the start of a remark.
const REMARKS: [&str; 3] = ["#", "%", "//"];
/// Maximum number of columns: more than any logger has.
const MAX_COLUMNS: usize = 10_000;

impl Table {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// Returns an error if the file is not text, has no rows, or has a row that is shorter or longer than the others. A
    /// cell that is not a number is an error only if its column is used.
    pub fn parse(bytes: &[u8]) -> Result<Table, Error> {
        read(bytes)
    }

    /// A table without rows below a head.
    fn below(head: Head, first: u64, row: &str, dialect: &Dialect) -> Result<Table, Error> {
        let Head { line, names, units, ts, .. } = head;
        let width = dialect.width();
        if width > MAX_COLUMNS {
            let question = "are rows and columns exchanged?";
            return Err(Error::line(first, format!("{width} columns, but at most {MAX_COLUMNS} are read: {question}")));
        }
        let more = cells(row, dialect.separator).skip(names.len()).any(|cell| cell != Ok(""));
        let header = if names.is_empty() { 0 } else { line };
        let mut table = Table { header, first, ts, ..Table::default() };
        if header > 0 && more {
            table.columns = names.into_iter().map(Column::new).collect();
            return Err(table.ragged(first, width, dialect.separator));
        }
        let mut names = names.into_iter();
        table.columns = (0..width.max(names.len()))
            .map(|k| Column {
                unit: units.get(k).filter(|unit| !unit.is_empty()).cloned(),
                ..Column::new(names.next().unwrap_or_default())
            })
            .collect();
        Ok(table)
    }

    /// Reads one row; an error leaves the table as it was. `split` keeps its room from row to row.
    fn row<'a>(&mut self, line: u64, row: &'a str, dialect: &Dialect, split: &mut Vec<&'a str>) -> Result<(), Error> {
        split.clear();
        for cell in cells(row, dialect.separator) {
            let at = split.len();
            let column = || self.columns.get(at).map_or((at + 1).to_string(), |column| shortened(&column.name));
            let refused = |problem: &str| Error::Line { line, column: Some(column()), problem: problem.into() };
            let cell = cell.map_err(refused)?;
            // A word in place of the first number: a summary, or another head.
            let word = |cell: &str| cell.starts_with(|c: char| c.is_alphabetic() || c == '#' || c == '*');
            if at == dialect.first() && word(cell) && !number::not_finite(cell) {
                let problem = "words stand here, but rows follow further down: if another table starts here, split \
                               the file; if not, delete the line";
                return Err(Error::line(line, problem));
            }
            split.push(cell);
        }
        let filled = split.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        if split.len() <= dialect.last() || filled > self.columns.len() {
            return Err(self.ragged(line, split.len(), dialect.separator));
        }
        for (at, column) in self.columns.iter_mut().enumerate() {
            column.take(split.get(at).copied().unwrap_or_default(), line);
        }
        self.count += 1;
        Ok(())
    }

    /// Refuses columns whose commas may stand between thousands, unless another column has decimal commas: `1,234`
    /// beside whole numbers, or not between semicolons.
    fn doubt_commas(&mut self, separator: char) {
        if self.columns.iter().any(|column| column.proven) {
            return;
        }
        for column in self.columns.iter_mut().filter(|column| separator != ';' || column.whole) {
            if let (Some((',', line)), None) = (column.decimal, &column.doubt) {
                let problem = "the comma before three digits may be a decimal comma (1,234 is 1.234) or stand between \
                               thousands (1234): write the numbers with a decimal point and without other marks";
                column.doubt = Some(column.error(line, problem));
            }
        }
    }

    /// The error for a row that is shorter or longer than the header.
    fn ragged(&self, line: u64, count: usize, separator: char) -> Error {
        let names = self.columns.len();
        let advice = if separator == ',' && count == 2 * names {
            "if the numbers have decimal commas, separate them with semicolons or tabs"
        } else if count < names {
            "complete the row, or delete it if it is the last one (the file was cut short)"
        } else {
            "remove the additional cells, or name their columns in the header"
        };
        let (fields, columns) = (counted(count, "field"), counted(names, "column"));
        let than = match self.header {
            0 => format!("but most rows have {names}"),
            line => format!("but the header on line {line} names {columns}"),
        };
        Error::line(line, format!("{fields}, {than}: {advice}"))
    }
}

fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// True if a line contains only separators and spaces.
fn blank(line: &str) -> bool {
    line.chars().all(|c| c.is_whitespace() || ",;|\"\u{1a}".contains(c))
}

/// True if a line is a remark.
fn remark(line: &str) -> bool {
    let line = line.trim_start();
    REMARKS.iter().any(|sign| line.starts_with(sign))
}

/// The error for a text without rows.
fn without_numbers(text: &str) -> Error {
    let filled = || text.lines().filter(|line| !blank(line));
    let what = match filled().count() {
        0 => "the file is empty",
        _ if filled().all(remark) => "the file holds only comments",
        _ => "there are no rows of numbers",
    };
    Error::Content(format!("{what}: a header such as {EXAMPLE} and rows of numbers are needed"))
}

impl Column {
    /// Reads one cell. One that is not a number leaves a gap: a cut may leave out its row.
    fn take(&mut self, cell: &str, line: u64) {
        let value = self.number(cell, line);
        if value.is_none() && self.flaw.is_none() {
            self.flaw = Some(self.error(line, number::problem(cell)));
        }
        self.samples.push(value.unwrap_or(f64::NAN));
    }

    /// The number in a cell.
    fn number(&mut self, cell: &str, line: u64) -> Option<f64> {
        let Some((value, sign)) = number::read(cell) else {
            let timed = self.samples.is_empty() || self.clock.is_some();
            return if timed { self.time_of_day(cell) } else { None };
        };
        // The point of a plain number is looked for until one is found.
        let sign =
            sign.or_else(|| (self.decimal.is_none_or(|(sign, _)| sign == ',') && cell.contains('.')).then_some('.'));
        if let (Some((known, above)), Some(sign)) = (self.decimal, sign)
            && known != sign
        {
            let error = self.error(line, number::mixed(cell, known, above));
            self.doubt.get_or_insert(error);
        }
        self.decimal = self.decimal.or(sign.map(|sign| (sign, line)));
        self.proven |= sign == Some(',') && !number::may_group(cell);
        self.whole |= sign.is_none() && value.abs() >= 1.0;
        Some(value)
    }

    /// The time of day in a cell [s], with the days that have passed.
    fn time_of_day(&mut self, cell: &str) -> Option<f64> {
        let time = clock::read(cell)?;
        let days = self.clock.unwrap_or(0.0);
        let before = self.samples.iter().rfind(|time| time.is_finite()).copied().unwrap_or(time);
        let days = if time + days < before - clock::DAY / 2.0 { days + clock::DAY } else { days };
        self.clock = Some(days);
        Some(time + days)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;

    fn record(file: &str) -> Result<crate::record::Record, Error> {
        Table::parse(file.as_bytes())?.record(&ColumnSelection::default())
    }

    fn refusal(file: &str) -> String {
        record(file).unwrap_err().to_string()
    }

    /// The error for a file with this last row after two valid rows.
    fn third(row: &str) -> String {
        refusal(&format!("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n{row}\n"))
    }

    #[test]
    fn the_same_record_is_read_however_it_is_dressed() {
        let plain = "t_s,u_V,y_um\n0.0,1.5,-2e-3\n0.1,2,3\n";
        let expected = record(plain).unwrap();
        assert_eq!((expected.ts(), expected.u(), expected.y()), (0.1, &[1.5, 2.0][..], &[-2e-3, 3.0][..]));
        let dressed = [
            format!("\u{feff}{plain}"),
            plain.replace('\n', "\r\n"),
            plain.replace('\n', "\r"),
            plain.replace('\n', "\r\r\n"),
            plain.trim_end().into(),
            plain.replace(',', ";"),
            plain.replace(',', "\t"),
            plain.replace(',', ";").replace('.', ","),
            plain.replace(',', "\t").replace('.', ","),
            plain.replace(',', " ,  "),
            plain.replace("t_s", "\"t_s\"").replace("u_V", " \"u_V\" ").replace("-2e-3", "\"-2e-3\""),
            format!("{plain}\n\r\n  \n,,\n"),
            format!("# stage 3\n#\n\n{plain}"),
            plain.replacen('\n', "\n\n", 1),
            format!("# {plain}"),
            format!("sep=,\n{plain}"),
            plain.replace('\n', ",\n"),
            plain.replace("2,3", "+2.,3E0"),
            "note,y_um,yref_um,t_s,u_V\n\"a, \"\"b\"\"\",-2e-3,nan,0,1.5\n,3,,.1,2\n".into(),
        ];
        for file in dressed {
            assert_eq!(record(&file).as_ref(), Ok(&expected), "{file:?}");
        }
    }

    #[test]
    fn a_file_without_rows_is_refused() {
        assert!(refusal("").starts_with("the file is empty"));
        assert_eq!(
            refusal("t_s,u_V,y_um\n\n"),
            "there are no rows of numbers: a header such as `t_s,u_V,y_um` and rows of numbers are needed"
        );
    }

    #[test]
    fn a_row_of_another_length_is_refused_with_both_counts() {
        assert_eq!(
            third("0.2,3"),
            "line 4: 2 fields, but the header on line 1 names 3 columns: complete the row, or delete it if it is the last one (the file was cut short)"
        );
        assert_eq!(
            third("0.2,3,4,5"),
            "line 4: 4 fields, but the header on line 1 names 3 columns: remove the additional cells, or name their columns in \
             the header"
        );
        assert!(third("0,2,3,0,4,0").contains("if the numbers have decimal commas"));
    }

    #[test]
    fn a_cell_that_is_no_number_is_refused_with_its_place() {
        let cut = "repair it in the file, or cut the record to the longer part without it: give `to` = 0.2";
        assert_eq!(third("0.2,abc,4"), format!("line 4, column u_V: `abc` is not a number: {cut}"));
        assert_eq!(third("0.2,3,"), format!("line 4, column y_um: the cell is empty: {cut}"));
        assert_eq!(third("0.2,3,NaN"), format!("line 4, column y_um: `NaN` is not a finite number: {cut}"));
        assert!(third("0.2,-inf,4").starts_with("line 4, column u_V: `-inf` is not a finite number"));
        assert!(third("12:30:01,3,4").starts_with("line 4, column t_s: `12:30:01` is not a number"));
        assert!(third("0.2,\"3,5\",4").contains("a decimal comma, but line 3 has a decimal point in `t_s`"));
        let long = third(&format!("0.2,{},4", "x".repeat(100_000)));
        assert!(long.contains("xxx... (100000 characters)") && long.len() < 200, "{long}");
    }

    #[test]
    fn a_quote_that_is_not_closed_ends_at_its_line() {
        assert_eq!(
            refusal("t_s,u_V,y_um\n0,\"1,2\n0.1,2,3\n"),
            "line 2, column u_V: a quote is opened and not closed on its line: close or delete it"
        );
        assert!(third("0.2,\"3\" V,4").contains("line 4, column u_V: text follows a closing quote"));
        assert!(refusal("t_s,\"u_V,y_um\n0,1,2\n").starts_with("line 1: a quote is opened"));
    }

    #[test]
    fn empty_lines_are_skipped_and_counted() {
        let expected = record("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n").unwrap();
        assert_eq!(record("\r\nt_s,u_V,y_um\r\n\r\n0,1,2\r\n\r\n,,\r\n0.1,2,3\r\n").unwrap(), expected);
        assert!(refusal("t_s,u_V,y_um\n0,1,2\n\n0.1,2,3\n\n\n0.1,2,3\n").starts_with("line 7, column t_s: two rows"));
    }

    #[test]
    fn remarks_and_the_header_may_stand_between_rows() {
        let expected = record("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.2,3,4\n").unwrap();
        for between in ["# marker\n", "// marker 1 set by user\n", "t_s,u_V,y_um\n"] {
            assert_eq!(
                record(&format!("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n{between}0.2,3,4\n")).as_ref(),
                Ok(&expected),
                "{between}"
            );
        }
        let again = "t_s,u_V,y_um\n0,1,2\n0.1,2,3\n";
        assert!(refusal(&format!("{again}{again}")).contains("time goes back"), "a second record");
    }

    #[test]
    fn words_below_the_last_row_are_a_summary_and_between_rows_an_error() {
        let rows = "t_s,u_V,y_um\n0,1,2\n0.1,2,3\n";
        for below in ["# end\n", "\nMean,1.5,2.5\nEnd of data\n", "\u{1a}"] {
            let (with, without) = (record(&format!("{rows}{below}")).unwrap(), record(rows).unwrap());
            assert_eq!((with.u(), with.y()), (without.u(), without.y()), "{below}");
            let message = with.history().join("; ");
            assert_eq!(message, if below.contains("Mean") { "2 lines below the last row left out" } else { "" });
        }
        assert_eq!(
            refusal(&format!("{rows}a,b,c\n0,1,2\n")),
            "line 4: words stand here, but rows follow further down: if another table starts here, split the file; if \
             not, delete the line"
        );
    }

    #[test]
    fn names_that_stand_again_without_a_time_may_begin_another_record() {
        let again = "u_V,y_um\n1,2\n2,3\nu_V,y_um\n3,4\n4,5\n";
        let every = ColumnSelection { ts: Some(0.1), ..ColumnSelection::default() };
        let read = |file: &str| Table::parse(file.as_bytes()).unwrap().record(&every);
        assert_eq!(
            read(again).unwrap_err().to_string(),
            "line 4: the names stand again: if another record begins here, split the file; if not, delete the line"
        );
        let timed = "t_s,u_V,y_um\n0,1,2\n0.1,2,3\nt_s,u_V,y_um\n0.2,3,4\n";
        assert_eq!(read(timed).unwrap().len(), 3);
        assert!(read(&timed.replace("0.2,", "0,")).is_err());
    }

    #[test]
    fn a_comma_that_may_stand_between_thousands_is_refused() {
        let rows = |separator: &str, y: [&str; 3]| {
            let quote = if separator == "," { "\"" } else { "" };
            let row = |(k, y): (usize, &str)| format!("{k}{separator}{k}{separator}{quote}{y}{quote}\n");
            ["t_s", "u_V", "y_nm"].join(separator) + "\n" + &y.into_iter().enumerate().map(row).collect::<String>()
        };
        for doubtful in [
            rows(",", ["1,234", "1,239", "1,301"]),
            rows("\t", ["1,234", "1,239", "1,301"]),
            rows(";", ["998", "1,002", "1,005"]),
        ] {
            let error = refusal(&doubtful);
            assert!(error.contains("the comma before three digits may be a decimal comma"), "{error}");
        }
        let decimal = |file: &str| record(file).unwrap().y()[2];
        assert_eq!(decimal(&rows(";", ["1,234", "1,239", "1,301"])), 1.301, "Excel writes no `;` with such thousands");
        assert_eq!(decimal(&rows(",", ["0,999", "1,002", "1,005"])), 1.005, "no thousands begin with 0");
        assert_eq!(decimal(&rows(",", ["1,234", "1,23", "1,301"])), 1.301, "two digits");
    }

    #[test]
    fn lines_are_counted_alike_whatever_ends_them() {
        let file = "# rig\n\nt_s,u_V,y_um\n0,1,2\n0.1,x,3\n";
        for end in ["\n", "\r\n", "\r"] {
            let refused = refusal(&file.replace('\n', end));
            assert_eq!(refused, "line 5, column u_V: `x` is not a number: repair it in the file");
        }
    }

    #[test]
    fn decimal_signs_are_not_mixed_as_a_sign_between_thousands_would_be() {
        assert_eq!(
            refusal("t_s;u_V;y_um\n0;1,5;2\n1;1.5;3\n"),
            "line 3, column u_V: `1.5` has another decimal separator than line 2 (`,`): use one of them throughout, and no thousands separator"
        );
        assert_eq!(
            refusal("t_s;u_V;y_um\n0.0;1;2\n0.1;1,23;3\n"),
            "line 3, column u_V: a decimal comma, but line 2 has a decimal point in `t_s`: use one of them throughout, \
             and no thousands separator"
        );
        assert!(record("version;t_s;u_V;y_um\n1.10;0;1,5;2\n1.10;1;2;3\n").is_ok(), "a column that is not read");
    }

    #[test]
    fn a_clock_that_goes_back_by_more_than_half_a_day_has_passed_midnight() {
        let seconds = |cells: &[&str]| {
            let mut column = Column::new("clock".into());
            cells.iter().for_each(|cell| column.take(cell, 1));
            column.samples
        };
        let times = seconds(&["08:00:02", "16:00:02", "00:00:02", "08:00:02", "16:00:02", "00:00:02"]);
        assert_eq!(times, [28_802.0, 57_602.0, 86_402.0, 115_202.0, 144_002.0, 172_802.0]);
        assert_eq!(seconds(&["12:00:00", "11:00:00", "00:00:00"]), [43_200.0, 39_600.0, 0.0]);
        assert_eq!(seconds(&["12:00:00", "00:00:00"]), [43_200.0, 0.0], "half a day");
    }

    #[test]
    fn a_file_with_more_columns_than_a_logger_has_is_refused() {
        let rows = |width: usize| [vec!["1"; width].join(","), vec!["2"; width].join(",")].join("\n");
        assert_eq!(Table::parse(rows(MAX_COLUMNS).as_bytes()).unwrap().names().count(), MAX_COLUMNS);
        let refused = Table::parse(rows(MAX_COLUMNS + 1).as_bytes()).unwrap_err().to_string();
        assert!(refused.starts_with("line 1: 10001 columns, but at most 10000 are read"), "{refused}");
    }
}
