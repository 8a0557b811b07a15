//! Files as tables, whole or in pieces.

use super::csv::{self, Rows};
use super::{ColumnSelection, Format, Signal, Table};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::exact;
use std::io::{Chain, Cursor, Read};

/// Number of bytes at the start of a file that show its format.
const HEAD: u64 = 1 << 16;

impl Table {
    /// Reads the table in a file of any of [`FORMATS`](super::FORMATS). Only errors use the name, whose extension shows
    /// the intended format.
    ///
    /// ```
    /// use piezoid::formats::{ColumnSelection, Table};
    /// let table = Table::read("sine.txt", b"t_s,u_V,y_um\n0.0,0.0,0.1\n0.0005,1.0,20.3\n")?;
    /// assert_eq!(table.record(&ColumnSelection::default())?.len(), 2);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the file is damaged, contains no named channels, or has an unknown format.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Table, Error> {
        Table::read_from(name, bytes).map(|(table, _)| table)
    }

    /// The same from a source of bytes, and the format. Text with columns is read in pieces and never held.
    ///
    /// # Errors
    /// The errors of [`read`](Table::read), and an error if the source cannot be read to its end.
    pub fn read_from(name: &str, source: impl Read) -> Result<(Table, &'static Format), Error> {
        let (format, source) = recognised(source)?;
        let table = if format.in_pieces { csv::read(source) } else { whole(source).and_then(|b| (format.read)(&b)) };
        Ok((table.map_err(|error| unlike_its_name(name, format, error))?, format))
    }
}

/// Least number of rows of a piece.
const ROWS: usize = 1 << 18;
/// Sampling periods of pieces agree within this, relative to the first, as the steps of one record do.
const EVEN: f64 = 0.01;

/// The input in a file, in pieces that follow each other. Text with columns is never held; a file of another format,
/// and one of which a part is selected, is one piece.
///
/// ```
/// use piezoid_records::formats::{ColumnSelection, InputPieces};
/// let file = b"t_s,u_V\n0,1\n0.1,2\n0.2,3\n";
/// let mut samples = Vec::new();
/// for piece in InputPieces::new("u.csv", &file[..], &ColumnSelection::default())? {
///     samples.extend(piece?.samples);
/// }
/// assert_eq!(samples, [1.0, 2.0, 3.0]);
/// # Ok::<(), piezoid_numerics::error::Error>(())
/// ```
pub struct InputPieces<R> {
    /// What was not read; `None` after the last piece, and after an error.
    rest: Option<Rest<R>>,
    selection: ColumnSelection,
    /// The sampling period of the first piece.
    ts: Option<f64>,
    /// Least number of rows of a piece.
    rows: usize,
}

enum Rest<R> {
    Text(Box<Rows<Begun<R>>>),
    Whole(Table),
}

impl<R: Read> InputPieces<R> {
    /// The input in a source of bytes; only errors use the name.
    ///
    /// # Errors
    /// The errors of [`Table::read_from`] about what stands above the rows, or about the whole if it is one piece.
    pub fn new(name: &str, source: R, selection: &ColumnSelection) -> Result<Self, Error> {
        let (format, source) = recognised(source)?;
        let is_cut = selection.from.is_some() || selection.to.is_some();
        let rest = match format.in_pieces {
            true if !is_cut => Rows::new(source).map(|rows| Rest::Text(Box::new(rows))),
            true => csv::read(source).map(Rest::Whole),
            false => whole(source).and_then(|bytes| (format.read)(&bytes)).map(Rest::Whole),
        };
        let rest = Some(rest.map_err(|error| unlike_its_name(name, format, error))?);
        Ok(InputPieces { rest, selection: selection.clone(), ts: None, rows: ROWS })
    }

    /// The next piece of the table; its first row is the last one of the piece before.
    fn table(&mut self) -> Result<Option<Table>, Error> {
        let mut rows = match self.rest.take() {
            None => return Ok(None),
            Some(Rest::Whole(table)) => return Ok(Some(table)),
            Some(Rest::Text(rows)) => rows,
        };
        while rows.read()? {
            if rows.table.count > self.rows {
                let table = rows.take();
                self.rest = Some(Rest::Text(rows));
                return Ok(Some(table));
            }
        }
        rows.end().map(Some)
    }

    fn piece(&mut self) -> Result<Option<Signal>, Error> {
        let Some(table) = self.table()? else { return Ok(None) };
        let Some(ts) = self.ts else {
            let signal = table.input(&self.selection)?;
            // The columns of the other pieces are the same.
            self.selection = table.profile(&self.selection);
            self.ts = Some(signal.ts);
            return Ok(Some(signal));
        };
        if table.count < 2 {
            return Ok(None);
        }
        let mut signal = table.input(&self.selection)?;
        if (signal.ts / ts - 1.0).abs() > EVEN {
            return Err(Error::line(table.first, format!(
                "the sampling period is {} s from here on, but {} s above: split the file here, or, if only the time \
                 stamps are rounded, ",
                exact(signal.ts), exact(ts)
            )).advised(vec![("ts", ts.into())]));
        }
        signal.samples.remove(0);
        Ok(Some(Signal { ts, ..signal }))
    }
}

impl<R: Read> Iterator for InputPieces<R> {
    type Item = Result<Signal, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.piece().transpose()
    }
}

/// A file whose first bytes were read.
type Begun<R> = Chain<Cursor<Vec<u8>>, R>;

/// The format of a source of bytes, and the same bytes.
fn recognised<R: Read>(mut source: R) -> Result<(&'static Format, Begun<R>), Error> {
    let mut head = Vec::new();
    source.by_ref().take(HEAD).read_to_end(&mut head).map_err(broken)?;
    Ok((Format::of(&head), Cursor::new(head).chain(source)))
}

fn whole(mut source: impl Read) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    source.read_to_end(&mut bytes).map_err(broken)?;
    Ok(bytes)
}

/// The error for a source that ends early.
pub(super) fn broken(error: std::io::Error) -> Error {
    Error::Content(format!("the file cannot be read to its end: {error}"))
}

/// The error for a file that was read as CSV, because it has no other format, although its name says so.
fn unlike_its_name(name: &str, format: &Format, error: Error) -> Error {
    match Format::meant(name) {
        (Some(Format { name, summary, .. }), extension) if *name != csv::ROW.name && format.name == csv::ROW.name => {
            Error::Content(format!(
                "cannot be read: a .{extension} file should hold {summary}, but this one does not start with the \
                 signature of that format: it is damaged, or has another format"
            ))
        }
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The input of a text that is read in pieces of a few rows.
    fn pieces(text: &str) -> Result<(Vec<f64>, f64, usize), Error> {
        let mut pieces = InputPieces { rows: 10, ..InputPieces::new("u.csv", text.as_bytes(), &Default::default())? };
        if let Some(Rest::Text(rows)) = &mut pieces.rest {
            *rows = Box::new(Rows::in_pieces(Cursor::new(Vec::new()).chain(text.as_bytes()), 256)?);
        }
        let (mut samples, mut ts, mut count) = (Vec::new(), 0.0, 0);
        for piece in pieces {
            let piece = piece?;
            (ts, count) = (piece.ts, count + 1);
            samples.extend(piece.samples);
        }
        Ok((samples, ts, count))
    }

    #[test]
    fn the_input_is_the_same_in_pieces() {
        let rows = |n: u32| (0..n).map(|k| format!("{:.4},{}.5\n", f64::from(k) * 5e-4, k % 7)).collect::<String>();
        for n in [3, 11, 12, 300, 301, 302] {
            let text = format!("Time (s),Drive (V)\n{}", rows(n));
            let whole = Table::read("u.csv", text.as_bytes()).unwrap().input(&Default::default()).unwrap();
            let (samples, ts, count) = pieces(&text).unwrap();
            assert_eq!((samples, ts), (whole.samples, whole.ts), "{n}");
            assert!(count > 10 || n < 300, "{count} pieces");
        }
        let cut = ColumnSelection { from: Some(0.01), ..ColumnSelection::default() };
        let text = format!("t_s,u_V\n{}", rows(300));
        let part: Vec<_> = InputPieces::new("u.csv", text.as_bytes(), &cut).unwrap().collect();
        assert_eq!((part.len(), part[0].as_ref().unwrap().samples.len()), (1, 280));
    }

    #[test]
    fn flaws_in_later_pieces_are_named_with_their_lines() {
        let text: String = (0..200).map(|k| format!("{:.1},{k}\n", f64::from(k) * 0.1)).collect();
        let refused = |text: String| pieces(&format!("t_s,u_V\n{text}")).unwrap_err().to_string();
        assert!(refused(text.replace("\n15.0,150\n", "\n15.0,x\n")).starts_with("line 152, column u_V: `x` is not"));
        assert!(refused(text.replace("\n15.0,150\n", "\n")).starts_with("line 152, column t_s: the step to this row"));
        assert!(refused(text + "20.0,1,2\n").starts_with("line 202: 3 fields"));
        // Each step is 0.03 % longer than the one before.
        let slower = refused((0..200).map(|k| format!("{:.9},{k}\n", 1.0003f64.powi(k))).collect());
        assert!(slower.contains(" s from here on, but ") && slower.contains("give `ts` = "), "{slower}");
    }
}
