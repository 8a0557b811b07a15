//! Files of NumPy: an array with named fields (`.npy`), or an archive of named arrays (`.npz`).
//!
//! The names are those of fields and arrays; points in time become seconds from the earliest. Not supported: objects,
//! which only Python reads, and floats of 16 bytes, whose format depends on the machine.

mod descr;
mod literal;
mod write;
mod zip;

use super::bytes::{self, Unpacking, damaged, length, part, shape, whole};
use super::tree::{self, Node};
use super::{Channel, Format, Table, history};
use descr::{ArrayHead, Descr};
use piezoid_numerics::error::Error;
pub use zip::{archive, unpacked};

/// The row of NumPy.
pub(super) const ROW: Format = Format {
    name: "numpy",
    extensions: &["npz", "npy"],
    summary: "named arrays of NumPy, or an array with named fields",
    reference: "https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html",
    matches,
    read,
    in_pieces: false,
    write: Some(write::write),
};

const MAGIC: &[u8] = b"\x93NUMPY";

fn matches(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || zip::first(bytes).is_some_and(|name| name.ends_with(b".npy"))
}

fn read(file: &[u8]) -> Result<Table, Error> {
    let mut unpacking = Unpacking::of(file);
    if !file.starts_with(MAGIC) {
        let mut content = Vec::new();
        for member in zip::members(file)? {
            let Some(name) = member.name.strip_suffix(".npy") else { continue };
            let bytes = member.bytes(file, &mut unpacking)?;
            if name == history::NAME {
                content.push((name.to_string(), Node::Text(letters(&bytes)?)));
            } else {
                let channels = array(name, &bytes, &mut unpacking)?;
                content.extend(channels.into_iter().map(|channel| (channel.name.clone(), Node::Series(channel))));
            }
        }
        return Ok(tree::table(content));
    }
    let channels = array("", file, &mut unpacking)?;
    match &channels[..] {
        [Channel { name, .. }] if name.is_empty() => {
            let advice = "the file holds one array without column names: save the columns by name, as \
                          numpy.savez(file, t_s=..., u_V=..., y_um=...) does";
            Err(Error::Content(advice.into()))
        }
        _ => Ok(Table::of(channels)),
    }
}

/// The text of an array of little-endian texts.
fn letters(file: &[u8]) -> Result<String, Error> {
    let (_, start) = head(history::NAME, file)?;
    let letters = file[start..].as_chunks().0.iter().map(|letter| u32::from_le_bytes(*letter));
    Ok(letters.filter(|letter| *letter > 0).filter_map(char::from_u32).collect())
}

/// The header of an array, and where its data begin.
fn head(name: &str, file: &[u8]) -> Result<(ArrayHead, usize), Error> {
    if !file.starts_with(MAGIC) {
        return Err(damaged(format!("the array {name:?} does not begin as numpy writes it")));
    }
    // The width of a length depends on the version.
    let width = if part(file, MAGIC.len(), 1)? == [1] { 2 } else { 4 };
    let start = MAGIC.len() + 2 + width;
    let text = part(file, start, length(file, start - width, width, false)?)?;
    Ok((descr::head(text)?, start + text.len()))
}

/// The channels of an array: one with its name, or one for each of its fields.
fn array(name: &str, file: &[u8], unpacking: &mut Unpacking) -> Result<Vec<Channel>, Error> {
    let (ArrayHead { descr, dims }, start) = head(name, file)?;
    let fields = match descr {
        Descr::Fields(fields) => fields,
        plain => vec![(name.to_string(), plain)],
    };
    let item = fields.iter().try_fold(0, |sum: usize, (_, field)| sum.checked_add(field.size()?));
    let all = item.and_then(|item| item.checked_mul(bytes::size(&dims).ok()?));
    let (Some(item), Some(all)) = (item, all) else {
        return Err(damaged(format!("an array of shape {}", shape(&dims))));
    };
    let data = part(file, start, all)?;
    let single = fields.len() == 1;
    let mut at = 0;
    let mut channels = Vec::new();
    for (name, field) in fields {
        let size = field.size().unwrap_or(0);
        // Padding has no name.
        if single || !name.is_empty() {
            channels.extend(channel(name, &field, &dims, data.get(at..).unwrap_or_default(), item, unpacking)?);
        }
        at += size;
    }
    Ok(channels)
}

/// One field of an array, with a number every `item` bytes; `None` for a single text or similar information.
fn channel(
    name: String,
    field: &Descr,
    dims: &[usize],
    data: &[u8],
    item: usize,
    unpacking: &mut Unpacking,
) -> Result<Option<Channel>, Error> {
    let n = match bytes::vector(dims)? {
        Ok(n) => n,
        Err(what) => return Ok(Some(Channel::other(name, what))),
    };
    unpacking.count(n.saturating_mul(8))?;
    Ok(Some(match field {
        Descr::Numbers(numbers) => match numbers.read(data, item) {
            Some(samples) => Channel::new(name, samples),
            None => Channel::other(name, format!("numbers of {} bytes", numbers.size)),
        },
        Descr::Instants { big, unit, per_second } => {
            let ticks = (0..n).map(|k| whole(data, k * item, 8, *big).map(|bits| bits as i64));
            Channel::new(name, since_first(&ticks.collect::<Result<Vec<_>, _>>()?, *unit, *per_second))
        }
        Descr::Other(..) if n == 1 => return Ok(None),
        Descr::Other(what, _) => Channel::other(name, what.clone()),
        Descr::Fields(_) => Channel::other(name, "fields within a field"),
    }))
}

/// Points in time in seconds from the earliest; a tick is `unit` / `per_second` seconds. NaN for a missing one.
fn since_first(ticks: &[i64], unit: f64, per_second: f64) -> Vec<f64> {
    let none = |tick: &i64| *tick == i64::MIN;
    let first = ticks.iter().filter(|tick| !none(tick)).min().copied().unwrap_or(0);
    let seconds = |tick: &i64| (i128::from(*tick) - i128::from(first)) as f64 * unit / per_second;
    ticks.iter().map(|tick| if none(tick) { f64::NAN } else { seconds(tick) }).collect()
}
