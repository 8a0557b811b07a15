//! Columns as variables of version 5, which MATLAB, Octave and scipy read: doubles of shape n x 1, the times first.

use crate::formats::bytes::stored;
use crate::formats::csv::times;
use crate::formats::history;
use piezoid_numerics::error::Error;

/// Types of elements.
const INT8: u8 = 1;
const UINT16: u8 = 4;
const INT32: u8 = 5;
const UINT32: u8 = 6;
const DOUBLE: u8 = 9;
const MATRIX: u8 = 14;
/// Classes of arrays: text, doubles.
const TEXT: u8 = 4;
const NUMBERS: u8 = 6;
/// Maximum length of a name.
const LONGEST: usize = 63;

pub(super) fn write(ts: f64, columns: &[(&str, &[f64])], steps: &[String]) -> Result<Vec<u8>, Error> {
    let times = times(ts, columns.first().map_or(0, |(_, samples)| samples.len()));
    // A text without a date, then the version and the byte order.
    let mut file = format!("{:<116}", "MATLAB 5.0 MAT-file, written by piezoid").into_bytes();
    file.extend(*b"\0\0\0\0\0\0\0\0\0\x01IM");
    for (name, samples) in std::iter::once(("t_s", &times[..])).chain(columns.iter().copied()) {
        file.extend(variable(name, samples)?);
    }
    if !steps.is_empty() {
        let units: Vec<u16> = history::text(steps).encode_utf16().collect();
        let data = units.iter().flat_map(|unit| unit.to_le_bytes()).collect::<Vec<u8>>();
        file.extend(array(history::NAME, (TEXT, [1, units.len()]), element(UINT16, &data)?)?);
    }
    Ok(file)
}

fn variable(name: &str, samples: &[f64]) -> Result<Vec<u8>, Error> {
    let of_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if !(name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(of_word) && name.len() <= LONGEST) {
        let rule = "is no name of a variable of MATLAB (a letter, then up to 62 letters, digits or _): write \
                    .npz or .csv, or give the column a unit of letters";
        return Err(Error::parameter("column name", format!("{name:?}"), rule));
    }
    let data: Vec<u8> = samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
    array(name, (NUMBERS, [samples.len(), 1]), element(DOUBLE, &data)?)
}

/// An array of a class and of these dimensions.
fn array(name: &str, (class, dims): (u8, [usize; 2]), data: Vec<u8>) -> Result<Vec<u8>, Error> {
    let parts = [
        element(UINT32, &[class, 0, 0, 0, 0, 0, 0, 0])?,
        element(INT32, &[stored(dims[0])?, stored(dims[1])?].concat())?,
        element(INT8, name.as_bytes())?,
        data,
    ];
    element(MATRIX, &parts.concat())
}

/// An element, padded to eight bytes.
fn element(kind: u8, bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let len = stored(bytes.len())?;
    // Up to four bytes are stored within the tag.
    let mut element = match bytes.len() {
        1..=4 => vec![kind, 0, len[0], 0],
        _ => [[kind, 0, 0, 0], len].concat(),
    };
    element.extend(bytes);
    element.resize(element.len().next_multiple_of(8), 0);
    Ok(element)
}
