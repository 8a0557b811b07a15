//! Files into records and back: bytes in, [`Record`](crate::Record) out.
//!
//! A format turns bytes into a [`Table`] of named columns; the names, and a [`ColumnSelection`] where they do not
//! suffice, say which column is the time, the input and the output. Nothing here opens a file, and nothing is guessed:
//! what could mean two things is refused, with the option that decides it.
//!
//! The formats are the rows of [`FORMATS`], one file each. A file is recognised by its content ([`read`]), whatever it
//! is called.

mod bytes;
mod channel;
mod csv;
mod hdf5;
mod matlab;
mod numpy;
mod quote;
mod selection;
mod table;
mod time;

pub use channel::Channel;
pub use selection::ColumnSelection;
pub use table::{Signal, Table};

use crate::Error;
use std::path::Path;

/// A format of files that hold records.
#[derive(Debug)]
pub struct Format {
    /// What it is called.
    pub name: &'static str,
    /// How the names of its files end, in small letters.
    pub extensions: &'static [&'static str],
    /// What it holds, in one line.
    pub summary: &'static str,
    /// Where it is described.
    pub reference: &'static str,
    /// Whether a file begins as this format does.
    pub matches: fn(&[u8]) -> bool,
    /// The table in a file.
    pub read: fn(&[u8]) -> Result<Table, Error>,
}

/// The formats that are read. A row is more particular than those above it: the last one that matches reads a file.
pub static FORMATS: &[Format] = &[csv::ROW, numpy::ROW, matlab::ROW, hdf5::ROW];

impl Table {
    /// The table in a file of any of [`FORMATS`]. Its name tells only what a file was meant to be that cannot be read.
    ///
    /// ```
    /// use piezoid::formats::{ColumnSelection, Table};
    /// let table = Table::read("sine.txt", b"t_s,u_V,y_um\n0.0,0.0,0.1\n0.0005,1.0,20.3\n")?;
    /// assert_eq!(table.record(&ColumnSelection::default())?.len(), 2);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The file is damaged, holds no named channels, or is in no format that is read.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Table, Error> {
        let extension = Path::new(name).extension().and_then(|extension| extension.to_str()).unwrap_or("");
        let meant = FORMATS.iter().find(|format| format.extensions.contains(&extension.to_ascii_lowercase().as_str()));
        if let Some(format) = FORMATS.iter().skip(1).rfind(|format| (format.matches)(bytes)) {
            return (format.read)(bytes);
        }
        Table::parse(bytes).map_err(|error| match meant {
            Some(Format { name, summary, .. }) if *name != csv::ROW.name => Error::Content(format!(
                "cannot be read: a .{extension} file should hold {summary}, but this one does not start with the \
                 signature of that format: it is damaged, or has another format"
            )),
            _ => error,
        })
    }
}
