//! The header: names, and the separator that the whole file uses.

use super::EXAMPLE;
use super::cells::cells;
use super::number::looks_numeric;
use crate::Error;
use crate::formats::quote::{listed, quoted};
use std::collections::HashMap;
use std::iter::Peekable;

/// Maximum number of columns: more than any logger has.
const MOST: usize = 10_000;

/// The row of names.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub(super) line: u64,
    pub(super) separator: char,
    /// One per column; empty if a column has no name and therefore cannot be selected.
    pub(super) names: Vec<String>,
}

impl Header {
    /// Takes the header and everything above it off the lines.
    pub(super) fn read<'a>(lines: &mut Peekable<impl Iterator<Item = (u64, &'a str)>>) -> Result<Header, Error> {
        let mut comment = None;
        while let Some((line, text)) = lines.next_if(|(_, text)| comment_text(text).is_some() || text.trim().is_empty())
        {
            comment = comment_text(text).map(|text| (line, text)).or(comment);
        }
        let Some(&(line, text)) = lines.peek() else {
            let what = if comment.is_some() { "holds only comments" } else { "is empty" };
            return Err(Error::Content(format!(
                "the file {what}: a header such as {EXAMPLE} and rows of numbers are needed"
            )));
        };
        let header = Header::from_line(line, text)?;
        if !header.is_a_row() {
            lines.next();
            return header.checked();
        }
        // numpy.savetxt writes the header as a comment.
        match comment.and_then(|(line, text)| Header::from_line(line, text).ok()) {
            Some(above) if above.names.len() == header.names.len() && !above.is_a_row() => above.checked(),
            _ => Err(header.is_missing()),
        }
    }

    fn from_line(line: u64, text: &str) -> Result<Header, Error> {
        let separator = separator(text);
        let count = text.matches(separator).count() + 1;
        if count > MOST {
            let problem = format!("{count} columns, but at most {MOST} are read: are rows and columns exchanged?");
            return Err(Error::Line { line, column: None, problem });
        }
        let name = |cell: Result<&str, &str>| match cell {
            Ok(name) => Ok(name.replace("\"\"", "\"")),
            Err(problem) => Err(Error::Line { line, column: None, problem: problem.into() }),
        };
        Ok(Header { line, separator, names: cells(text, separator).map(name).collect::<Result<_, _>>()? })
    }

    /// True if these are numbers and not names.
    fn is_a_row(&self) -> bool {
        let mut named = self.names.iter().filter(|name| !name.is_empty()).peekable();
        named.peek().is_some() && named.all(|name| looks_numeric(name))
    }

    fn is_missing(&self) -> Error {
        let problem = format!(
            "there is no header: the first row holds the numbers {}; put a row of names above it, such as {EXAMPLE}",
            listed(self.names.iter().map(String::as_str))
        );
        Error::Line { line: self.line, column: None, problem }
    }

    /// Returns an error if a name occurs twice, or if there are no names.
    fn checked(self) -> Result<Header, Error> {
        let refused = |column, problem| Err(Error::Line { line: self.line, column, problem });
        let mut seen = HashMap::new();
        for (name, number) in self.names.iter().zip(1..).filter(|(name, _)| !name.is_empty()) {
            if let Some(earlier) = seen.insert(name, number) {
                let name = quoted(name);
                let problem = format!("{name} is also the name of column {earlier}: rename one of them");
                return refused(Some(number.to_string()), problem);
            }
        }
        if seen.is_empty() {
            return refused(None, format!("the header has no names: write some, such as {EXAMPLE}"));
        }
        Ok(self)
    }
}

/// The text after the `#` of a comment, or after the `sep=` with which spreadsheets name the separator.
fn comment_text(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix('#').or_else(|| line.strip_prefix("sep="))
}

/// A tab if the header has one outside quotes, else a semicolon if it has one, else a comma: a name may contain a comma
/// if semicolons or tabs separate, but hardly a semicolon if commas separate.
fn separator(header: &str) -> char {
    let outside = || header.split('"').step_by(2);
    ['\t', ';'].into_iter().find(|c| outside().any(|part| part.contains(*c))).unwrap_or(',')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::csv::text::lines;

    fn read(text: &str) -> Result<Header, String> {
        Header::read(&mut lines(text).peekable()).map_err(|e| e.to_string())
    }

    #[test]
    fn the_separator_is_the_one_of_the_header() {
        for (text, separator) in [("a,b", ','), ("a;b", ';'), ("a\tb", '\t'), ("\"a;b\",c", ','), ("a", ',')] {
            assert_eq!(read(text).unwrap().separator, separator, "{text}");
        }
        assert_eq!(read("\"Time, s\"\t\"say \"\"u\"\"\"").unwrap().names, ["Time, s", "say \"u\""]);
    }

    #[test]
    fn comments_and_blank_lines_may_stand_above() {
        let header = read("# rig 2, 23 C\n\n  # by night\nt_s,u_V\n0,1\n").unwrap();
        assert_eq!((header.line, header.names), (4, vec!["t_s".into(), "u_V".into()]));
    }

    #[test]
    fn the_header_of_savetxt_is_a_comment() {
        let header = read("# made by numpy\n# t_s,u_V\n0,1\n").unwrap();
        assert_eq!((header.line, header.names), (2, vec!["t_s".into(), "u_V".into()]));
    }

    #[test]
    fn a_file_without_names_is_told_so() {
        assert_eq!(
            read("0.0,1.8,-123.06\n0.1,1.9,-120\n").unwrap_err(),
            "line 1: there is no header: the first row holds the numbers `0.0`, `1.8`, `-123.06`; put a row of names \
             above it, such as `t_s,u_V,y_um`"
        );
        assert!(read("0,0;1,5;nan\n").unwrap_err().contains("no header"));
        assert_eq!(read(",,\n").unwrap_err(), "line 1: the header has no names: write some, such as `t_s,u_V,y_um`");
    }

    #[test]
    fn a_file_without_lines_is_told_so() {
        let needed = "a header such as `t_s,u_V,y_um` and rows of numbers are needed";
        assert_eq!(read("").unwrap_err(), format!("the file is empty: {needed}"));
        assert_eq!(read("\n \n").unwrap_err(), format!("the file is empty: {needed}"));
        assert_eq!(read("# only this\n").unwrap_err(), format!("the file holds only comments: {needed}"));
    }

    #[test]
    fn a_file_on_its_side_is_told_so() {
        assert_eq!(
            read(&"0,".repeat(20_000)).unwrap_err(),
            "line 1: 20001 columns, but at most 10000 are read: are rows and columns exchanged?"
        );
    }

    #[test]
    fn a_name_that_stands_twice_is_refused() {
        assert_eq!(
            read("t_s,u_V,y_um,u_V").unwrap_err(),
            "line 1, column 4: `u_V` is also the name of column 2: rename one of them"
        );
        assert!(read("t_s,u_V,,").is_ok(), "columns without a name cannot be confused");
    }
}
