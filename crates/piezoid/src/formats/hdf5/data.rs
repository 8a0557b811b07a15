//! Data sets: their type, shape and position, and the filters of their chunks.

use super::Hdf5File;
use super::object::{FILTERS, LAYOUT, Object, SPACE, TYPE, attribute};
use crate::Error;
use crate::formats::bytes::{self, NumberFormat, NumberKind, damaged, length, part};

/// The classes of MATLAB that are numbers.
const NUMBERS: [&str; 11] =
    ["double", "single", "logical", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"];

/// Samples, or a description if the data set is not a vector of real numbers.
type Samples = Result<Vec<f64>, String>;

impl<'a> Hdf5File<'a> {
    /// The samples of a data set; `None` for a line of text or similar information on the record.
    pub(super) fn samples(&mut self, data: &Object<'a>) -> Result<Option<Samples>, Error> {
        let left = |what: &str| Ok(Some(Err(what.to_string())));
        let (Some(space), Some(kind), Some(layout)) = (data.first(SPACE), data.first(TYPE), data.first(LAYOUT)) else {
            return left("no data set of a supported type");
        };
        let dims = dims(space)?;
        // The last dimension is the first one of MATLAB: a line of text has one row.
        let rows = dims.last().copied().unwrap_or(1);
        let class = attribute(data, "MATLAB_class")?.map(bytes::text);
        match class.as_deref() {
            _ if attribute(data, "MATLAB_empty")?.is_some_and(|v| v.iter().any(|byte| *byte > 0)) => {
                return left("empty");
            }
            Some("char") if rows == 1 => return Ok(None),
            Some(class) if !NUMBERS.contains(&class) => return left(&format!("of class {class}")),
            _ => {}
        }
        let numbers = match numbers(kind)? {
            Ok(numbers) => numbers,
            // A single text or similar value is information on the record.
            Err(_) if bytes::size(&dims)? == 1 => return Ok(None),
            Err(what) => return left(what),
        };
        let n = match bytes::vector(&dims)? {
            Ok(n) => n,
            Err(what) => return Ok(Some(Err(what))),
        };
        self.placed(data, layout, &dims, numbers, n).map(Some)
    }

    /// The `n` numbers of a vector of this shape, from their position.
    fn placed(
        &mut self,
        data: &Object<'a>,
        layout: &[u8],
        dims: &[usize],
        numbers: NumberFormat,
        n: usize,
    ) -> Result<Samples, Error> {
        let len = n.checked_mul(numbers.size).ok_or_else(|| damaged(format!("a data set of {n} samples")))?;
        self.unpacking.count(len.max(8 * n.min(usize::MAX / 8)))?;
        let read = |bytes: &[u8]| Ok(numbers.read(bytes, numbers.size).ok_or_else(|| "of an unknown type".into()));
        let number = |at, size| length(layout, at, size, false);
        // The class (compact, contiguous, chunked), and the positions of the address and the shape of chunks.
        let version = number(0, 1)?;
        let (class, place, shape) = match (version, number(1, 1)?) {
            (1 | 2, rank) if number(2, 1)? == 0 => (0, 12 + 4 * rank, 0),
            (1 | 2, _) => (number(2, 1)?, 8, 16),
            (3 | 4, 0) => (0, 4, 0),
            (3 | 4, 1) => (1, 2, 0),
            (3, 2) => (2, 3, 11),
            _ => return Ok(Err("in chunks of a newer form".into())),
        };
        if class == 0 {
            return read(part(layout, place, len)?);
        }
        if part(layout, place, 8)? == [0xff; 8] {
            return Ok(Err("never written".into()));
        }
        let address = number(place, 8)?;
        if class == 1 {
            return read(part(self.bytes, address, len)?);
        }
        let chunk = (0..dims.len()).map(|k| number(shape + 4 * k, 4)).collect::<Result<Vec<_>, _>>()?;
        self.chunks(address, data.first(FILTERS), (dims, &chunk), numbers, n)
    }

    /// The numbers of a vector in chunks.
    fn chunks(
        &mut self,
        tree: usize,
        filters: Option<&[u8]>,
        (dims, chunk): (&[usize], &[usize]),
        numbers: NumberFormat,
        n: usize,
    ) -> Result<Samples, Error> {
        let filters = match filters.map_or(Ok(Ok(Vec::new())), pipeline)? {
            Ok(filters) => filters,
            Err(what) => return Ok(Err(what)),
        };
        // All samples lie along one dimension, at the first index of the others.
        let along = dims.iter().position(|dim| *dim == n).unwrap_or(0);
        let (Some(&step), Some(behind)) = (chunk.get(along), chunk.get(along + 1..)) else {
            return Err(damaged("chunks of a single number"));
        };
        let stride = bytes::size(behind)?.checked_mul(numbers.size);
        let whole = bytes::size(chunk)?.checked_mul(numbers.size);
        let (Some(stride), Some(whole)) = (stride, whole) else {
            return Err(damaged(format!("chunks of {}", bytes::shape(chunk))));
        };
        let mut samples = vec![f64::NAN; n];
        let mut filled = 0;
        for leaf in self.leaves(tree, 8 + 8 * (dims.len() + 1))? {
            let (packed, mask) = (length(leaf.key, 0, 4, false)?, length(leaf.key, 4, 4, false)?);
            let from = length(leaf.key, 8 + 8 * along, 8, false)?;
            let packed = part(self.bytes, leaf.child, packed)?;
            self.unpacking.count(packed.len())?;
            let bytes = self.unfiltered(packed, &filters, mask)?;
            if bytes.len() != whole {
                return Err(damaged(format!("a chunk of {} bytes, not {whole}", bytes.len())));
            }
            let Some(place) = samples.get_mut(from..) else { continue };
            let count = step.min(place.len());
            let read = numbers.read(bytes.get(..count * stride).unwrap_or_default(), stride);
            for (sample, number) in place.iter_mut().zip(read.unwrap_or_default()) {
                *sample = number;
            }
            filled += count;
        }
        Ok(if filled == n { Ok(samples) } else { Err(format!("of {filled} samples written, not {n}")) })
    }

    /// Reverses the filters of a chunk.
    fn unfiltered(&mut self, packed: &[u8], filters: &[Filter], mask: usize) -> Result<Vec<u8>, Error> {
        let mut bytes = packed.to_vec();
        for (k, filter) in filters.iter().enumerate().rev() {
            if mask >> k & 1 == 1 {
                continue;
            }
            bytes = match filter {
                Filter::Deflate => self.unpacking.zlib(&bytes)?,
                Filter::Shuffle(size) => unshuffled(&bytes, *size),
                Filter::Checksum => part(&bytes, 0, bytes.len().saturating_sub(4))?.to_vec(),
            };
        }
        Ok(bytes)
    }
}

/// A filter that is applied to a chunk when it is written.
enum Filter {
    Deflate,
    /// For elements of this length: the first bytes of all elements, then the second bytes, and so on.
    Shuffle(usize),
    /// Fletcher's checksum, which is not checked.
    Checksum,
}

/// The filters of a data set, or a description of an unknown one.
fn pipeline(message: &[u8]) -> Result<Result<Vec<Filter>, String>, Error> {
    let number = |at, size| length(message, at, size, false);
    let first = number(0, 1)? == 1;
    let mut at = if first { 8 } else { 2 };
    let mut filters = Vec::new();
    for _ in 0..number(1, 1)? {
        let id = number(at, 2)?;
        let named = first || id >= 256;
        let name = if named { number(at + 2, 2)? } else { 0 };
        let values = number(at + if named { 6 } else { 4 }, 2)?;
        at += if named { 8 } else { 6 };
        at += if first { name.next_multiple_of(8) } else { name };
        filters.push(match id {
            1 => Filter::Deflate,
            2 => Filter::Shuffle(number(at, 4)?),
            3 => Filter::Checksum,
            _ => return Ok(Err(format!("compressed by filter {id}"))),
        });
        at += 4 * if first { values.next_multiple_of(2) } else { values };
    }
    Ok(Ok(filters))
}

fn unshuffled(bytes: &[u8], size: usize) -> Vec<u8> {
    let count = bytes.len() / size.max(1);
    let (shuffled, rest) = bytes.split_at(count * size);
    let element = |k: usize| shuffled.iter().skip(k).step_by(count.max(1));
    (0..count).flat_map(element).chain(rest).copied().collect()
}

/// The shape of a data set.
fn dims(space: &[u8]) -> Result<Vec<usize>, Error> {
    let number = |at, size| length(space, at, size, false);
    let (version, rank) = (number(0, 1)?, number(1, 1)?);
    if version == 2 && number(3, 1)? == 2 {
        return Ok(vec![0]);
    }
    let start = if version == 1 { 8 } else { 4 };
    (0..rank).map(|k| number(start + 8 * k, 8)).collect()
}

/// The format of numbers, or a description of a type that is not real numbers.
fn numbers(kind: &[u8]) -> Result<Result<NumberFormat, &'static str>, Error> {
    let number = |at, size| length(kind, at, size, false);
    let (bits, size) = (number(1, 1)?, number(4, 4)?);
    let numbers = |kind| NumberFormat { kind, size, big: bits & 1 == 1 };
    Ok(match number(0, 1)? & 15 {
        0 if matches!(size, 1 | 2 | 4 | 8) && number(10, 2)? == 8 * size => {
            Ok(numbers(if bits & 8 > 0 { NumberKind::Signed } else { NumberKind::Unsigned }))
        }
        1 if matches!(size, 2 | 4 | 8) && number(10, 2)? == 8 * size && bits & 0x40 == 0 => {
            Ok(numbers(NumberKind::Float))
        }
        0 | 1 => Err("numbers of an unusual type"),
        3 => Err("text"),
        6 => Err("complex numbers, or several in one"),
        7 => Err("references, as of cells and arrays of structures"),
        // Booleans of h5py: an enumeration of integers, whose type follows.
        8 => self::enumeration(kind)?,
        9 if bits & 15 == 1 => Err("text"),
        9 => Err("series of several lengths"),
        _ => Err("no numbers"),
    })
}

fn enumeration(kind: &[u8]) -> Result<Result<NumberFormat, &'static str>, Error> {
    match kind.get(8..) {
        Some(base) if length(base, 0, 1, false)? & 15 == 0 => numbers(base),
        _ => Ok(Err("names")),
    }
}
