//! Bytes of a binary file; reading beyond the end is an error. A length stated in a file is limited by the size of the
//! file, and the size of unpacked data by the maximum density of deflate.

use miniz_oxide::inflate::{decompress_to_vec_with_limit, decompress_to_vec_zlib_with_limit};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::power;
use std::fmt::Display;

/// Maximum depth of nested structures, groups and types.
pub(super) const DEEPEST: usize = 32;
/// Maximum number of bytes that are unpacked from one file.
const LARGEST: usize = 1 << 31;
/// Maximum number of unpacked bytes per packed byte, 1032, times the number of times that each is counted.
const DENSEST: usize = 4 * 1032;

/// The error for a file whose content is inconsistent.
pub(super) fn damaged(what: impl Display) -> Error {
    Error::Content(format!("the file is damaged (was its writing or copying interrupted?): {what}"))
}

/// `len` bytes from `at` on.
pub(super) fn part(bytes: &[u8], at: usize, len: usize) -> Result<&[u8], Error> {
    at.checked_add(len).and_then(|end| bytes.get(at..end)).ok_or_else(|| {
        damaged(format!("{len} bytes are expected at byte {at}, but the file has only {} bytes", bytes.len()))
    })
}

/// The unsigned integer of `size` bytes, at most 8, at `at`.
pub(super) fn whole(bytes: &[u8], at: usize, size: usize, big: bool) -> Result<u64, Error> {
    let part = part(bytes, at, size.min(8))?;
    let fold = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
    Ok(if big { part.iter().fold(0, fold) } else { part.iter().rev().fold(0, fold) })
}

/// The same for a length or a position.
pub(super) fn length(bytes: &[u8], at: usize, size: usize, big: bool) -> Result<usize, Error> {
    let number = whole(bytes, at, size, big)?;
    // At most half of the maximum, so that two can be added.
    let fits = usize::try_from(number).ok().filter(|length| *length <= usize::MAX / 2);
    fits.ok_or_else(|| damaged(format!("a length of {number} at byte {at}")))
}

/// A length or a position as four bytes, for a file that is written: it can be read if it has at most 2 GiB.
pub(super) fn stored(len: usize) -> Result<[u8; 4], Error> {
    let advice = "the file would have more than 2 GiB: write CSV, or a part of the samples";
    i32::try_from(len).map(i32::to_le_bytes).map_err(|_| Error::Content(advice.into()))
}

/// The text up to the first NUL.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// A shape as text: `2 x 3`.
pub(super) fn shape(dims: &[usize]) -> String {
    dims.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}

/// Number of elements of a shape.
pub(super) fn size(dims: &[usize]) -> Result<usize, Error> {
    let size = dims.iter().try_fold(1, |n: usize, dim| n.checked_mul(*dim));
    size.ok_or_else(|| damaged(format!("an array of {} elements", shape(dims))))
}

/// Number of samples of an array of this shape. If it is not a vector, that is, one dimension does not have all of
/// them, a description.
pub(super) fn vector(dims: &[usize]) -> Result<Result<usize, String>, Error> {
    let n = size(dims)?;
    Ok(match dims.iter().max() {
        _ if n == 0 => Err("empty".into()),
        Some(longest) if *longest < n => Err(format!("of shape {}", shape(dims))),
        _ => Ok(n),
    })
}

/// Interpretation of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NumberKind {
    Signed,
    Unsigned,
    Float,
}

/// Numbers of one type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberFormat {
    pub(super) kind: NumberKind,
    /// Bytes per number.
    pub(super) size: usize,
    /// True if the most significant byte is first.
    pub(super) big: bool,
}

impl NumberFormat {
    /// The numbers, one every `stride` bytes; `None` if there is no such type.
    pub(super) fn read(self, bytes: &[u8], stride: usize) -> Option<Vec<f64>> {
        let NumberFormat { kind, size, big } = self;
        let one: fn(u64) -> f64 = match (kind, size) {
            (NumberKind::Float, 8) => f64::from_bits,
            (NumberKind::Float, 4) => |bits| f32::from_bits(bits as u32).into(),
            (NumberKind::Float, 2) => half,
            (NumberKind::Signed, 1) => |bits| f64::from(bits as i8),
            (NumberKind::Signed, 2) => |bits| f64::from(bits as i16),
            (NumberKind::Signed, 4) => |bits| f64::from(bits as i32),
            (NumberKind::Signed, 8) => |bits| bits as i64 as f64,
            (NumberKind::Unsigned, 1 | 2 | 4 | 8) => |bits| bits as f64,
            _ => return None,
        };
        bytes.chunks(stride.max(1)).map(|part| whole(part, 0, size, big).ok().map(one)).collect()
    }
}

/// The number of half precision with these bits.
fn half(bits: u64) -> f64 {
    let (exponent, fraction) = ((bits >> 10 & 0x1f) as i32, (bits & 0x3ff) as f64);
    let size = match exponent {
        0 => fraction * power(2.0, -24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        _ => (1024.0 + fraction) * power(2.0, exponent - 25),
    };
    if bits >> 15 & 1 == 1 { -size } else { size }
}

/// Number of bytes that may still be unpacked from a file.
#[derive(Debug)]
pub(super) struct Unpacking {
    left: usize,
}

impl Unpacking {
    pub(super) fn of(file: &[u8]) -> Self {
        Unpacking { left: LARGEST.min(file.len().saturating_mul(DENSEST)) }
    }

    /// Number of bytes that may still be unpacked.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// Counts unpacked bytes; the same bytes may be counted several times.
    pub(super) fn count(&mut self, bytes: usize) -> Result<(), Error> {
        self.left = self.left.checked_sub(bytes).ok_or_else(too_large)?;
        Ok(())
    }

    /// Unpacks deflate data.
    pub(super) fn deflated(&mut self, packed: &[u8]) -> Result<Vec<u8>, Error> {
        self.unpack(decompress_to_vec_with_limit(packed, self.left))
    }

    /// Unpacks deflate data with zlib's header and checksum.
    pub(super) fn zlib(&mut self, packed: &[u8]) -> Result<Vec<u8>, Error> {
        self.unpack(decompress_to_vec_zlib_with_limit(packed, self.left))
    }

    fn unpack(&mut self, unpacked: Result<Vec<u8>, miniz_oxide::inflate::DecompressError>) -> Result<Vec<u8>, Error> {
        use miniz_oxide::inflate::TINFLStatus::HasMoreOutput;
        let unpacked = unpacked.map_err(|error| match error.status {
            HasMoreOutput => too_large(),
            _ => damaged("its compressed data cannot be unpacked"),
        })?;
        self.count(unpacked.len())?;
        Ok(unpacked)
    }
}

fn too_large() -> Error {
    Error::Content("the file holds more than 2 GiB, or is damaged: save the channels of one record alone".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_type_are_read_in_both_orders() {
        let read = |kind, bytes: &[u8]| {
            let [little, big] = [false, true].map(|big| NumberFormat { kind, size: bytes.len(), big });
            let turned: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(little.read(bytes, bytes.len()), big.read(&turned, bytes.len()));
            little.read(bytes, bytes.len()).map(|numbers| numbers[0])
        };
        assert_eq!(read(NumberKind::Float, &(-1.5f64).to_le_bytes()), Some(-1.5));
        assert_eq!(read(NumberKind::Float, &0.1f32.to_le_bytes()), Some(f64::from(0.1f32)));
        // Half precision: -2, the largest, the smallest, infinity.
        for (bits, expected) in
            [(0xc000u16, -2.0), (0x7bff, 65504.0), (1, 5.960464477539063e-8), (0x7c00, f64::INFINITY)]
        {
            assert_eq!(read(NumberKind::Float, &bits.to_le_bytes()), Some(expected));
        }
        assert_eq!(read(NumberKind::Signed, &(-3i16).to_le_bytes()), Some(-3.0));
        assert_eq!(read(NumberKind::Signed, &(-3i64).to_le_bytes()), Some(-3.0));
        assert_eq!(read(NumberKind::Unsigned, &u64::MAX.to_le_bytes()), Some(18446744073709551616.0));
        assert_eq!(read(NumberKind::Float, &[0; 3]), None);
        assert_eq!(
            NumberFormat { kind: NumberKind::Signed, size: 1, big: false }.read(&[1, 2, 255, 4], 2),
            Some(vec![1.0, -1.0])
        );
    }

    #[test]
    fn what_would_unpack_to_more_than_is_allowed_is_refused_before_it_is_unpacked() {
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&[0; 100_000], 9);
        assert_eq!(Unpacking::of(&packed).zlib(&packed).unwrap().len(), 100_000);
        let mut little = Unpacking { left: 99_999 };
        assert!(little.zlib(&packed).unwrap_err().to_string().contains("more than 2 GiB"));
        let mut twice = Unpacking { left: 150_000 };
        assert!(twice.zlib(&packed).is_ok() && twice.zlib(&packed).is_err());
    }

    #[test]
    fn lengths_shapes_and_texts_have_limits() {
        let number = |number: u64| length(&number.to_le_bytes(), 0, 8, false).ok();
        assert_eq!((number(u64::MAX / 2), number(u64::MAX / 2 + 1)), (usize::try_from(u64::MAX / 2).ok(), None));
        assert_eq!((stored(0x7fff_ff01).ok(), stored(1 << 31).ok()), (Some([1, 0xff, 0xff, 0x7f]), None));
        let count = |dims: &[usize]| vector(dims).unwrap();
        assert_eq!([count(&[]), count(&[1, 4, 1])], [Ok(1), Ok(4)]);
        assert_eq!([count(&[0, 3]), count(&[2, 3])], [Err("empty".into()), Err("of shape 2 x 3".into())]);
        assert!(size(&[usize::MAX, 2]).is_err());
        assert_eq!([text(b"a\0b"), text(b"ab")], ["a", "ab"]);
        assert_eq!(part(&[1, 2, 3], 1, 2).ok(), Some(&[2, 3][..]));
        let beyond = part(&[1, 2, 3], 2, 2).unwrap_err().to_string();
        assert!(beyond.ends_with("2 bytes are expected at byte 2, but the file has only 3 bytes"), "{beyond}");
        // Infinity, and what is no number.
        assert_eq!((half(0x7c00), half(0xfc00)), (f64::INFINITY, f64::NEG_INFINITY));
        assert!(half(0x7c01).is_nan());
        let whole = NumberFormat { kind: NumberKind::Signed, size: 4, big: false };
        assert_eq!(whole.read(&(-3i32).to_le_bytes(), 4), Some(vec![-3.0]));
    }

    #[test]
    fn a_file_is_unpacked_to_four_times_what_deflate_can_hold_or_two_gibibytes() {
        assert_eq!([1000, 1 << 20].map(|len| Unpacking::of(&vec![0; len]).left()), [4_128_000, 1 << 31]);
        let mut all = Unpacking { left: 10 };
        assert!(all.count(10).is_ok() && all.count(1).is_err());
    }
}
