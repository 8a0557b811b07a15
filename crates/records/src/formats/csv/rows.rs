//! The rows of a file, read piece by piece into a table.

use super::cells::cells;
use super::dialect::Dialect;
use super::head::Head;
use super::text::{PIECE, Piece, Text};
use super::{blank, counted, number, remark, without_numbers};
use crate::formats::history;
use crate::formats::table::Table;
use piezoid_numerics::error::Error;
use std::io::Read;
use std::iter::Peekable;

/// The table in a source of text.
pub(in crate::formats) fn read(source: impl Read) -> Result<Table, Error> {
    let mut rows = Rows::in_pieces(source, PIECE)?;
    while rows.read()? {}
    rows.end()
}

/// The rows of a source of text.
pub(in crate::formats) struct Rows<R> {
    /// The rows that were read.
    pub(in crate::formats) table: Table,
    text: Text<R>,
    /// The first piece, until its rows are read.
    first: Option<Piece>,
    layout: Layout,
    /// Number of rows in all pieces.
    count: usize,
    /// The lines below the last row: the error for the first of them, if rows follow after all, and their number.
    below: Option<(Error, usize)>,
}

/// What the head shows of the rows.
struct Layout {
    /// Number of lines above them.
    above: usize,
    dialect: Dialect,
    /// The line of the names, which may stand again between rows.
    header: Option<String>,
    /// Number of rows that the head states.
    stated: Option<usize>,
}

impl Layout {
    /// The table without rows of a text that begins with a head, and what this shows; `None` if no row stands here.
    fn of(piece: &Piece) -> Result<Option<(Table, Layout)>, Error> {
        let (steps, start) = history::before(&piece.text);
        let Some(dialect) = Dialect::of(&piece.text[start..]) else { return Ok(None) };
        let mut lines = piece.lines().skip(steps.len()).peekable();
        let above = above(&mut lines, &dialect);
        let Some(&(first, row)) = lines.peek() else { return Ok(None) };
        if let Some(&(line, text)) = above.iter().rfind(|(_, line)| !blank(line))
            && let Some(problem) = cells(text, dialect.separator).find_map(Result::err)
        {
            return Err(Error::line(line, problem));
        }
        let numbered = dialect.is_numbered(lines.clone().map(|(_, row)| row).filter(|row| !blank(row)));
        let head = Head::read(&above, &dialect, numbered);
        let stated = head.rows;
        let header = above.iter().find(|(line, _)| *line == head.line).map(|(_, text)| text.to_string());
        let lines = steps.len() + above.len();
        let table = Table { steps, ..Table::below(head, first, row, &dialect)? };
        Ok(Some((table, Layout { above: lines, dialect, header, stated })))
    }
}

impl<R: Read> Rows<R> {
    /// Reads the head of a text, which is read in pieces of so many bytes.
    pub(in crate::formats) fn in_pieces(source: R, size: usize) -> Result<Self, Error> {
        let mut text = Text::new(source, size);
        let mut first = text.next()?.ok_or_else(|| without_numbers(""))?;
        loop {
            if let Some((table, layout)) = Layout::of(&first)? {
                return Ok(Rows { table, text, first: Some(first), layout, count: 0, below: None });
            }
            // The lines above the rows may be longer than a piece.
            let len = first.text.len();
            while first.text.len() <= 2 * len {
                match text.next()? {
                    Some(next) => first = first.and(&next),
                    None if first.text.len() == len => return Err(without_numbers(&first.text)),
                    None => break,
                }
            }
        }
    }

    /// Reads the rows of the next piece; false if there is none.
    fn read(&mut self) -> Result<bool, Error> {
        let (piece, above) = match self.first.take() {
            Some(first) => (first, self.layout.above),
            None => match self.text.next()? {
                Some(piece) => (piece, 0),
                None => return Ok(false),
            },
        };
        let Layout { dialect, header, .. } = &self.layout;
        let before = self.table.count;
        let mut split = Vec::new();
        for (line, row) in piece.lines().skip(above) {
            if let Some((error, count)) = &mut self.below {
                if dialect.is_row(row) {
                    return Err(error.clone());
                }
                *count += usize::from(!blank(row));
                continue;
            }
            // Remarks, and the header again, may stand between rows.
            let missing =
                || cells(row, dialect.separator).next().is_some_and(|cell| cell.is_ok_and(number::not_finite));
            let again = header.as_deref() == Some(row);
            let table = &mut self.table;
            if blank(row) || remark(row) && !missing() || again {
                table.again.extend(again.then_some(table.count));
                table.gaps.push(table.count);
            } else if let Err(error) = table.row(line, row, dialect, &mut split) {
                // Words below the last row are a summary.
                if dialect.begins_like_a_row(row) {
                    return Err(error);
                }
                self.below = Some((error, 1));
            }
        }
        self.count += self.table.count - before;
        Ok(true)
    }

    /// Reads rows until there are so many cells; false if the text ended before.
    pub(in crate::formats) fn fill(&mut self, cells: usize) -> Result<bool, Error> {
        // With the two first stamps, and with a row that is new.
        let most = 2.max(cells / self.table.columns.len().max(1));
        while self.read()? {
            if self.table.count > most {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Number of rows that were read, with those that were dropped.
    pub(in crate::formats) fn count(&self) -> usize {
        self.count
    }

    /// Drops the rows that were read, except the last one: it shows that the time goes on.
    pub(in crate::formats) fn drop_rows(&mut self) {
        self.table.drop_rows();
    }

    /// The table of the rows, all of which were read.
    pub(in crate::formats) fn end(mut self) -> Result<Table, Error> {
        let (mut table, count) = (self.table, self.count);
        if let Some((_, below)) = self.below.take() {
            table.steps.push(format!("{} below the last row left out", counted(below, "line")));
        }
        // Words only: a remark.
        for column in table.columns.iter_mut().filter(|column| column.samples.iter().all(|sample| sample.is_nan())) {
            column.samples = Vec::new();
        }
        table.doubt_commas(self.layout.dialect.separator);
        match self.layout.stated {
            Some(rows) if count < rows => Err(Error::Content(format!(
                "the head states {rows} rows, but {count} follow: the file was cut; to use what is there, set NDATA to \
                 {count}"
            ))),
            _ => Ok(table),
        }
    }
}

/// The lines above the rows: those before the first two rows in sequence, or before the only row. The first of two may
/// have a flaw, which is reported later.
pub(super) fn above<'a>(
    lines: &mut Peekable<impl Iterator<Item = (u64, &'a str)> + Clone>,
    dialect: &Dialect,
) -> Vec<(u64, &'a str)> {
    let mut above = Vec::new();
    while let Some(&(_, line)) = lines.peek() {
        let (begins, row) = (dialect.begins_like_a_row(line), dialect.is_row(line));
        if begins || row {
            let mut next = lines.clone().skip(1).filter(|(_, line)| !blank(line) && !remark(line));
            if next.next().map_or(row, |(_, next)| dialect.is_row(next)) {
                break;
            }
        }
        above.extend(lines.next());
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_same_in_pieces_of_any_length() {
        let rows: String = (0..300).map(|k| format!("{k},{}.5,{}\n", k % 7, k % 11)).collect();
        let files = [
            format!("t_s,u_V,y_um\n{rows}"),
            format!("# piezoid: cut\n# rig 3\n\nTime (s),Drive (V),Position (um)\n{rows}# end\nMean,3,4\n"),
            format!("t_s,u_V,y_um\n{}", rows.replace("77,", "\n# a mark\n77,").replace("200,", "t_s,u_V,y_um\n200,")),
            format!("t_s,u_V,y_um,note\n{}", rows.replace("150,", "150,x")),
            format!(
                "clock,u_V,y_um\n{}",
                (0..300).map(|k| format!("23:59:{}.{},1,2\n", k / 10 % 60, k % 10)).collect::<String>()
            ),
            rows.replace(',', ";").replace('.', ","),
            format!("t_s,u_V,y_um\n{rows}words,a,b\n300,1,2\n"),
            format!("t_s,u_V,y_um\n{rows}300,1\n"),
        ];
        for file in files {
            let whole = read(file.as_bytes());
            for size in [200, 256, 1000] {
                let mut pieces = Rows::in_pieces(file.as_bytes(), size).unwrap();
                let found = loop {
                    match pieces.read() {
                        Ok(true) => {}
                        Ok(false) => break pieces.end(),
                        Err(error) => break Err(error),
                    }
                };
                // NaN is not equal to itself.
                assert_eq!(format!("{found:?}"), format!("{whole:?}"), "{size}: {file}");
            }
        }
    }

    #[test]
    fn a_head_may_be_longer_than_a_piece() {
        let file = format!("{}t_s,u_V,y_um\n0,1,2\n0.1,2,3\n", "# nothing but remarks\n".repeat(100));
        let mut pieces = Rows::in_pieces(file.as_bytes(), 128).unwrap();
        while pieces.read().unwrap() {}
        assert_eq!(pieces.end().unwrap().count, 2);
    }

    #[test]
    fn fewer_rows_than_the_head_states_are_a_file_that_was_cut() {
        let file = |rows: usize| format!("# NDATA = {rows}\nt_s,u_V\n0,1\n1,2\n");
        assert_eq!(
            read(file(3).as_bytes()).unwrap_err().to_string(),
            "the head states 3 rows, but 2 follow: the file was cut; to use what is there, set NDATA to 2"
        );
        assert!([1, 2].iter().all(|rows| read(file(*rows).as_bytes()).is_ok_and(|table| table.count == 2)));
    }
}
