//! Columns as an archive of arrays, which `numpy.load` reads: doubles of shape (n,), the times first.

use super::{MAGIC, zip};
use crate::formats::csv::times;
use crate::formats::history;
use piezoid_numerics::error::Error;

/// Arrays begin at multiples of this many bytes.
const ALIGNED: usize = 64;

pub(super) fn write(ts: f64, columns: &[(&str, &[f64])], steps: &[String]) -> Result<Vec<u8>, Error> {
    let times = times(ts, columns.first().map_or(0, |(_, samples)| samples.len()));
    let columns = std::iter::once(("t_s", &times[..])).chain(columns.iter().copied());
    let message = (!steps.is_empty()).then(|| (format!("{}.npy", history::NAME), letters(&history::text(steps))));
    zip::archive(columns.map(|(name, samples)| (format!("{name}.npy"), array(samples))).chain(message))
}

/// An array of doubles.
fn array(samples: &[f64]) -> Vec<u8> {
    let data = samples.iter().flat_map(|sample| sample.to_le_bytes());
    file("<f8", &format!("({},)", samples.len()), data)
}

/// A single text; each letter takes four bytes.
fn letters(text: &str) -> Vec<u8> {
    let data = text.chars().flat_map(|letter| u32::from(letter).to_le_bytes());
    file(&format!("<U{}", text.chars().count()), "()", data)
}

/// A `.npy` file of version 1.0.
fn file(descr: &str, shape: &str, data: impl Iterator<Item = u8>) -> Vec<u8> {
    let head = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let start = MAGIC.len() + 4;
    // Spaces and a line end fill it up.
    let len = (start + head.len() + 1).next_multiple_of(ALIGNED) - start;
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((len as u16).to_le_bytes());
    bytes.extend(format!("{head:<0$}\n", len - 1).into_bytes());
    bytes.extend(data);
    bytes
}
