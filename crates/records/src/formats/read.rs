//! Files as tables, whole or in pieces.

use super::csv;
use super::{Format, Table};
use piezoid_numerics::error::Error;
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

/// A file whose first bytes were read.
pub(super) type Begun<R> = Chain<Cursor<Vec<u8>>, R>;

/// The format of a source of bytes, and the same bytes.
pub(super) fn recognised<R: Read>(mut source: R) -> Result<(&'static Format, Begun<R>), Error> {
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
