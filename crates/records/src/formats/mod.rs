//! File formats: from bytes to a [`Record`](crate::record::Record), and back.
//!
//! A format converts bytes to a [`Table`] of named columns. Names and units, and a [`ColumnSelection`] if they are not
//! sufficient, determine which column is the time, the input and the output. No file is opened here. An ambiguity is an
//! error, which names the options that resolve it.
//!
//! The formats are the rows of [`FORMATS`], one file each. [`Table::read`] recognises a file by its content, whatever
//! its name; [`InputPieces`] and [`LongRecord`] read a long one piece by piece. [`Table::write`] writes CSV, `.npz` or
//! `.mat`, by the extension of the name.
//!
//! Why: docs/decisions/data-and-records.md, "HDF5 is read by a crate, other binary formats by piezoid".

#[cfg_attr(not(feature = "foreign"), allow(dead_code))]
mod bytes;
mod channel;
mod column;
mod csv;
mod gcs;
#[cfg(feature = "foreign")]
mod hdf5;
mod history;
#[cfg(feature = "foreign")]
mod igor;
mod layout;
mod long;
#[cfg(feature = "foreign")]
mod matlab;
#[cfg_attr(not(feature = "foreign"), allow(dead_code))]
mod numpy;
mod pieces;
mod quote;
mod read;
mod roles;
mod selection;
mod table;
#[cfg(feature = "foreign")]
mod tdms;
mod time;
#[cfg_attr(not(feature = "foreign"), allow(dead_code))]
mod tree;
mod units;
#[cfg(feature = "foreign")]
mod wav;
mod words;
mod write;

pub use channel::Channel;
pub use long::{LongRecord, MAX_HELD_SAMPLES, Opened, Take};
pub use numpy::{archive, unpacked};
pub use pieces::{InputPieces, Open};

pub use selection::ColumnSelection;
pub use table::{Signal, Table};
pub use units::{is_displacement, is_voltage};
pub use write::TextWriter;

use piezoid_numerics::error::Error;
use serde::Serialize;
use std::path::Path;

/// A format of files that hold records.
#[derive(Debug, Serialize)]
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// Extensions of its files, in lower case. Files that are written have the first one; text may have any.
    pub extensions: &'static [&'static str],
    /// Content of its files, in one line.
    pub summary: &'static str,
    /// Reference for a description.
    pub reference: &'static str,
    /// True if the first bytes of a file match this format.
    #[serde(skip)]
    pub matches: fn(&[u8]) -> bool,
    /// Reads the table in a file.
    #[serde(skip)]
    pub read: fn(&[u8]) -> Result<Table, Error>,
    /// True if its files are text with columns, which is read in pieces.
    #[serde(skip)]
    pub in_pieces: bool,
    /// Writes columns sampled every `ts` [s], which [`Table::write`] has checked, and the steps of their history;
    /// `None` if it is only read.
    #[serde(skip)]
    pub write: Option<Write>,
}

type Write = fn(ts: f64, columns: &[(&str, &[f64])], history: &[String]) -> Result<Vec<u8>, Error>;

/// The formats that are read. Later rows are more specific: the last one that matches reads a file.
pub static FORMATS: &[Format] = &[
    csv::ROW,
    gcs::ROW,
    #[cfg(feature = "foreign")]
    igor::ROW,
    #[cfg(feature = "foreign")]
    numpy::ROW,
    #[cfg(feature = "foreign")]
    matlab::ROW,
    #[cfg(feature = "foreign")]
    hdf5::ROW,
    #[cfg(feature = "foreign")]
    tdms::ROW,
    #[cfg(feature = "foreign")]
    wav::ROW,
];

impl Format {
    /// The format that the first bytes of a file match; CSV if they match no other.
    pub fn of(bytes: &[u8]) -> &'static Format {
        FORMATS.iter().rfind(|format| (format.matches)(bytes)).unwrap_or(&csv::ROW)
    }

    /// The format whose files have the extension of this name, and the extension.
    fn meant(name: &str) -> (Option<&'static Format>, &str) {
        let extension = Path::new(name).extension().and_then(|extension| extension.to_str()).unwrap_or("");
        let lower = extension.to_ascii_lowercase();
        (FORMATS.iter().find(|format| format.extensions.contains(&lower.as_str())), extension)
    }
}
