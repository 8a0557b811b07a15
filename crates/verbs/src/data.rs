//! Files of samples: records, drive signals, references. They are read in pieces, so that a long text is never held.

use super::{File, short};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::formats::{ColumnSelection, Format, InputPieces, LongRecord, Opened, Signal, Table};
use piezoid_records::record::Record;
use sha2::{Digest, Sha256};
use std::fmt::{self, Debug, Formatter};
use std::io::{self, Cursor, Read};
use std::sync::Arc;

/// A file of samples, which is opened whenever it is read.
#[derive(Clone)]
pub struct DataFile {
    /// Its name, with `/` between folders; errors about the file begin with it.
    pub name: String,
    open: Arc<Open>,
}

/// Opens a file at its start.
type Open = dyn Fn() -> io::Result<Box<dyn Read>> + Send + Sync;

impl Debug for DataFile {
    fn fmt(&self, to: &mut Formatter) -> fmt::Result {
        to.debug_struct("DataFile").field("name", &self.name).finish_non_exhaustive()
    }
}

impl From<File> for DataFile {
    fn from(file: File) -> Self {
        let bytes: Arc<[u8]> = file.bytes.into();
        DataFile::new(file.name, move || Ok(Box::new(Cursor::new(bytes.clone()))))
    }
}

impl DataFile {
    /// A file of this name; `open` gives its bytes from the first one on, each time it is called.
    pub fn new(name: impl Into<String>, open: impl Fn() -> io::Result<Box<dyn Read>> + Send + Sync + 'static) -> Self {
        DataFile { name: name.into(), open: Arc::new(open) }
    }

    /// The same file under another name.
    pub(super) fn named(self, name: &str) -> Self {
        DataFile { name: name.into(), ..self }
    }

    /// Its name without folders: the same work gives the same bytes in every folder.
    pub fn short(&self) -> &str {
        short(&self.name)
    }

    /// Its bytes.
    fn bytes(&self) -> Result<Box<dyn Read>, Error> {
        (self.open)().map_err(|error| self.unreadable(&error))
    }

    fn unreadable(&self, error: &io::Error) -> Error {
        Error::Content(format!("cannot be read: {error}")).of(&self.name)
    }

    /// All its bytes.
    pub(super) fn content(&self) -> Result<Vec<u8>, Error> {
        let mut content = Vec::new();
        self.bytes()?.read_to_end(&mut content).map_err(|error| self.unreadable(&error))?;
        Ok(content)
    }

    /// The table in it, and its format.
    ///
    /// # Errors
    /// The errors of [`Table::read_from`].
    pub fn table(&self) -> Result<(Table, &'static Format), Error> {
        Table::read_from(&self.name, self.bytes()?).map_err(|error| error.of(&self.name))
    }

    /// The table in it, or its record, if that has more than `held` samples and can be read in pieces.
    ///
    /// # Errors
    /// The errors of [`LongRecord::open`].
    pub fn opened(&self, columns: &ColumnSelection, held: usize) -> Result<Opened<'_>, Error> {
        LongRecord::open(&self.name, &*self.open, columns, held).map_err(|error| error.of(&self.name))
    }

    /// Applies `part` to the table in it.
    pub(super) fn read<T>(&self, part: impl FnOnce(Table) -> Result<T, Error>) -> Result<T, Error> {
        part(self.table()?.0).map_err(|error| error.of(&self.name))
    }

    /// The record in it.
    ///
    /// # Errors
    /// Returns an error if it contains no record, or not the selected columns.
    pub fn record(&self, columns: &ColumnSelection) -> Result<Record, Error> {
        self.read(|table| table.record(columns))
    }

    /// The input in it; other columns are not needed.
    ///
    /// # Errors
    /// The errors of [`DataFile::record`].
    pub fn input(&self, columns: &ColumnSelection) -> Result<Signal, Error> {
        self.read(|table| table.input(columns))
    }

    /// The same in pieces that follow each other.
    ///
    /// # Errors
    /// The errors of [`InputPieces`].
    pub fn input_in_pieces(
        &self,
        columns: &ColumnSelection,
    ) -> Result<impl Iterator<Item = Result<Signal, Error>> + use<>, Error> {
        let name = self.name.clone();
        let pieces = InputPieces::new(&name, &*self.open, columns).map_err(|error| error.of(&name))?;
        Ok(pieces.map(move |piece| piece.map_err(|error| error.of(&name))))
    }

    /// The reference in it, in the unit of the model's output; other columns are not needed.
    ///
    /// # Errors
    /// The errors of [`DataFile::record`], and errors for another sampling period than the model's and for a unit that
    /// cannot be converted.
    pub fn reference(&self, columns: &ColumnSelection, model: &Model) -> Result<Vec<f64>, Error> {
        self.read(|table| {
            let reference = table.reference(columns)?;
            Record::same_sampling("the model", model.ts(), "the reference", reference.ts)?;
            reference.samples_in(&model.units().y, "the reference")
        })
    }

    /// The requested displacement in it; other columns are not needed.
    ///
    /// # Errors
    /// The errors of [`DataFile::record`].
    pub fn path(&self, columns: &ColumnSelection) -> Result<Signal, Error> {
        self.read(|table| table.reference(columns))
    }

    /// The selection that reads records like this one: the columns and units that were found, and the options in
    /// `columns`.
    ///
    /// # Errors
    /// The errors of [`DataFile::record`].
    pub fn profile(&self, columns: &ColumnSelection) -> Result<ColumnSelection, Error> {
        self.read(|table| {
            table.record(columns)?;
            Ok(table.profile(columns))
        })
    }

    /// The table in it, its format, and the SHA-256 of the bytes that were read.
    ///
    /// # Errors
    /// The errors of [`DataFile::table`].
    pub fn hashed(&self) -> Result<(Table, &'static Format, String), Error> {
        let mut hash = Sha256::new();
        let source = Hashing { source: self.bytes()?, hash: &mut hash };
        let (table, format) = Table::read_from(&self.name, source).map_err(|error| error.of(&self.name))?;
        Ok((table, format, hex(hash)))
    }

    /// The SHA-256 of its bytes.
    pub(super) fn sha256(&self) -> Result<String, Error> {
        let mut hash = Sha256::new();
        let read = io::copy(&mut Hashing { source: self.bytes()?, hash: &mut hash }, &mut io::sink());
        read.map_err(|error| self.unreadable(&error))?;
        Ok(hex(hash))
    }
}

/// A source of bytes that hashes what is read.
struct Hashing<'a, R> {
    source: R,
    hash: &'a mut Sha256,
}

impl<R: Read> Read for Hashing<'_, R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let n = self.source.read(to)?;
        self.hash.update(&to[..n]);
        Ok(n)
    }
}

fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
