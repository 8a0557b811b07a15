//! CSV: a header row, then numbers.
//!
//! Commas, semicolons or tabs separate, as in the header. With semicolons and tabs, the decimal separator may be a
//! comma. Accepted: a byte-order mark; any line ends; quotes and spaces around cells; `#` lines, `sep=;` and blank
//! lines above the header; blank lines at the end; the header as the last `#` line, as numpy.savetxt writes it.
//! Everything else is an error with line and column. Not supported: cells that span lines, encodings other than UTF-8,
//! dates.
//!
//! The lines are split here and not by the csv crate: an error names its line for any line ends, an unclosed quote ends
//! at its line and does not include the rest of the file, and no cell is copied. [`Table::parse`] is pure and accepts
//! any bytes, so a fuzzer can call it directly.

mod cells;
mod header;
mod number;
mod text;
mod write;

use super::Format;
use super::quote::shortened;
use super::table::{Column, Table};
use crate::Error;
use cells::{blank, cells};
use header::Header;
use number::NumberReader;

/// The row of CSV. It matches every file that no other row matches: its errors say what a file should look like.
pub(super) const ROW: Format = Format {
    name: "csv",
    extensions: &["csv", "tsv", "txt"],
    summary: "text, a row of names above rows of numbers",
    reference: "RFC 4180, https://doi.org/10.17487/RFC4180",
    matches: |_| true,
    read: Table::parse,
};

/// What a file should look like, for messages.
const EXAMPLE: &str = "`t_s,u_V,y_um`";

impl Table {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// Returns an error if the file is not text, has no header or no rows, or has a row whose length differs from the
    /// header. A cell that is not a number is an error only if its column is used.
    pub fn parse(bytes: &[u8]) -> Result<Table, Error> {
        let text = text::decode(bytes)?;
        let mut lines = text::lines(text).peekable();
        let header = Header::read(&mut lines)?;
        let columns = header.names.into_iter().map(Column::new).collect();
        let mut table = Table { columns, header: header.line, ..Table::empty() };
        let mut numbers = NumberReader::new(header.separator);
        let mut gap = None;
        for (line, row) in lines {
            if blank(row, header.separator) {
                gap = gap.or((table.first > 0).then_some(line));
                continue;
            }
            if let Some(gap) = gap {
                let problem = format!(
                    "this line is empty, but rows follow from line {line} on: delete the empty line, or \
                             everything after it"
                );
                return Err(Error::Line { line: gap, column: None, problem });
            }
            if table.first == 0 {
                table.first = line;
            }
            table.row(line, row, header.separator, &mut numbers)?;
        }
        if table.first == 0 {
            return Err(Error::Content(format!(
                "there are no numbers: the file ends after its header on line {}; rows must follow",
                table.header
            )));
        }
        Ok(table)
    }

    /// Reads one row.
    fn row(&mut self, line: u64, row: &str, separator: char, numbers: &mut NumberReader) -> Result<(), Error> {
        let mut count = 0;
        for cell in cells(row, separator) {
            let column = self.columns.get_mut(count);
            count += 1;
            match (column, cell) {
                (Some(column), Ok(cell)) => column.take(cell, line, line == self.first, numbers),
                (None, Ok(_)) => {}
                (column, Err(problem)) => {
                    let column = column.map_or(count.to_string(), |c| shortened(&c.name));
                    return Err(Error::Line { line, column: Some(column), problem: problem.into() });
                }
            }
        }
        if count == self.columns.len() { Ok(()) } else { Err(self.ragged(line, row, count, separator)) }
    }

    /// The error for a row that is shorter or longer than the header.
    fn ragged(&self, line: u64, row: &str, count: usize, separator: char) -> Error {
        let names = self.columns.len();
        let advice = if row.trim_start().starts_with('#') {
            "comments may only stand above the header"
        } else if separator == ',' && count == 2 * names {
            "if the numbers have decimal commas, separate them with semicolons or tabs"
        } else if count < names {
            "complete the row, or delete it if it is the last one (the file was cut short)"
        } else {
            "remove the additional cells, or name their columns in the header"
        };
        let [fields, columns] = [(count, "field"), (names, "column")].map(|(n, what)| match n {
            1 => format!("1 {what}"),
            _ => format!("{n} {what}s"),
        });
        let problem = format!("{fields}, but the header on line {} names {columns}: {advice}", self.header);
        Error::Line { line, column: None, problem }
    }
}

impl Column {
    fn new(name: String) -> Self {
        Column { name, unit: None, samples: Vec::new(), flaw: None, decimal: None }
    }

    /// Reads one cell; ignores all cells after the first flaw.
    fn take(&mut self, cell: &str, line: u64, first: bool, numbers: &mut NumberReader) {
        if self.flaw.is_some() {
            return;
        }
        let sign = numbers.decimal_sign(cell);
        let mixed = self.decimal.zip(sign).filter(|((sign, _), other)| sign != other);
        let value = match (mixed, numbers.read(cell)) {
            (None, Ok(value)) => Ok(value),
            (None, Err(number::NotANumber)) => Err(number::problem(cell, first)),
            (Some(((sign, above), _)), _) => Err(number::mixed(cell, sign, above)),
        };
        match value {
            Ok(value) => self.samples.push(value),
            Err(problem) => self.flaw = Some(Error::Line { line, column: Some(shortened(&self.name)), problem }),
        }
        self.decimal = self.decimal.or(sign.map(|sign| (sign, line)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;

    fn record(file: &str) -> Result<crate::Record, Error> {
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
        let wanted = record(plain).unwrap();
        assert_eq!((wanted.ts(), wanted.u(), wanted.y()), (0.1, &[1.5, 2.0][..], &[-2e-3, 3.0][..]));
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
            assert_eq!(record(&file).as_ref(), Ok(&wanted), "{file:?}");
        }
    }

    #[test]
    fn a_file_without_rows_is_refused() {
        assert!(refusal("").starts_with("the file is empty"));
        assert_eq!(
            refusal("t_s,u_V,y_um\n\n"),
            "there are no numbers: the file ends after its header on line 1; rows must follow"
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
        assert!(
            third("# end").ends_with(
                "1 field, but the header on line 1 names 3 columns: comments may only stand above the header"
            )
        );
        assert!(refusal("u_V\n1\n1,2\n").contains("names 1 column: if the numbers have decimal commas"));
    }

    #[test]
    fn a_cell_that_is_no_number_is_refused_with_its_place() {
        assert_eq!(third("0.2,abc,4"), "line 4, column u_V: `abc` is not a number");
        assert_eq!(third("0.2,3,"), "line 4, column y_um: the cell is empty: every row needs a number here");
        assert_eq!(
            third("0.2,3,NaN"),
            "line 4, column y_um: `NaN` is not a finite number: repair the sample, or end the record above this line"
        );
        assert!(third("0.2,-inf,4").starts_with("line 4, column u_V: `-inf` is not a finite number"));
        assert!(third("12:30:01,3,4").starts_with("line 4, column t_s: `12:30:01` is not a number"));
        assert!(third("0.2,\"3,5\",4").contains("decimal commas need semicolons or tabs"));
        let long = third(&format!("0.2,{},4", "x".repeat(100_000)));
        assert!(long.contains("xxx... (100000 characters)") && long.len() < 150, "{long}");
        assert!(
            refusal("t_s,u_V,y_um\ns,V,um\n0,1,2\n")
                .starts_with("line 2, column u_V: `V` is not a number: if this is a row of units")
        );
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
    fn an_empty_line_between_rows_is_refused() {
        assert_eq!(
            refusal("t_s,u_V,y_um\r\n0,1,2\r\n\r\n0.1,2,3\r\n"),
            "line 3: this line is empty, but rows follow from line 4 on: delete the empty line, or everything after it"
        );
    }

    #[test]
    fn lines_are_counted_alike_whatever_ends_them() {
        let file = "# rig\n\nt_s,u_V,y_um\n0,1,2\n0.1,x,3\n";
        for end in ["\n", "\r\n", "\r"] {
            assert_eq!(refusal(&file.replace('\n', end)), "line 5, column u_V: `x` is not a number");
        }
    }

    #[test]
    fn decimal_signs_are_not_mixed_as_a_sign_between_thousands_would_be() {
        assert_eq!(
            refusal("t_s;u_V;y_um\n0;1,5;2\n1;1.5;3\n"),
            "line 3, column u_V: `1.5` has another decimal separator than line 2 (`,`): use one of them throughout, and no thousands separator"
        );
        assert_eq!(
            refusal("t_s;u_V;y_um\n0.0;1;2\n0.1;1,234;3\n"),
            "line 3, column u_V: a decimal comma, but line 2 has a decimal point in `t_s`: use one of them throughout, \
             and no thousands separator"
        );
        assert!(record("version;t_s;u_V;y_um\n1.10;0;1,5;2\n1.10;1;2;3\n").is_ok(), "a column that is not read");
    }
}
