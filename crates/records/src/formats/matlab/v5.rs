//! Versions 5 and 7: nested elements, each after a tag with its type and length. Version 7 deflates every variable.
//!
//! Numbers are stored in the smallest sufficient type, whatever the class of their array. A single cell is read as its
//! content, and cells of single numbers as a vector.

use crate::formats::Channel;
use crate::formats::bytes::{
    DEEPEST, NumberFormat, NumberKind, Unpacking, damaged, length, part, shape, size, text, vector,
};
use crate::formats::tree::Node;
use piezoid_numerics::error::Error;

/// Bytes of the text at the start of a file, with version and byte order.
const HEAD: usize = 128;
/// Types of elements.
const MATRIX: usize = 14;
const COMPRESSED: usize = 15;
/// The flag of an array of complex numbers.
const COMPLEX: usize = 0x800;

/// True if a file has the signature of these versions.
pub(super) fn begins(file: &[u8]) -> bool {
    matches!(file.get(HEAD - 4..HEAD), Some([_, 1, b'I', b'M'] | [1, _, b'M', b'I']))
}

/// The variables.
pub(super) fn variables(file: &[u8]) -> Result<Vec<(String, Node)>, Error> {
    let big = file.get(HEAD - 2) == Some(&b'M');
    let mut unpacking = Unpacking::of(file);
    let mut variables = Vec::new();
    let mut elements = Elements { bytes: file, at: HEAD, big };
    while elements.at < file.len() {
        let element = elements.next()?;
        let (name, value) = if let (COMPRESSED, packed) = element {
            let bytes = unpacking.zlib(packed)?;
            array(Elements { bytes: &bytes, at: 0, big }.next()?, big, 0)?
        } else {
            array(element, big, 0)?
        };
        // Variables without a name are MATLAB's own.
        if !name.is_empty() {
            variables.push((name, value));
        }
    }
    Ok(variables)
}

/// The name and the value of an array.
fn array((kind, bytes): (usize, &[u8]), big: bool, depth: usize) -> Result<(String, Node), Error> {
    if kind != MATRIX || depth > DEEPEST {
        return Err(damaged(format!("an element of type {kind}, {depth} deep, where an array should stand")));
    }
    if bytes.is_empty() {
        return Ok((String::new(), Node::other("empty")));
    }
    let mut parts = Elements { bytes, at: 0, big };
    let (_, flags) = parts.next()?;
    let flags = length(flags, 0, 4, big)?;
    // An opaque object states its name in place of its dimensions.
    let dims = if flags & 0xff == 17 { Vec::new() } else { parts.lengths()? };
    let name = text(parts.next()?.1);
    let value = match flags & 0xff {
        1 => cells(&mut parts, &dims, depth)?,
        2 => structures(&mut parts, size(&dims)?, depth)?,
        4 if size(&dims)? == 0 || dims.first() == Some(&1) => Node::Text(parts.letters()?),
        4 => Node::other("text"),
        5 => Node::other("a sparse matrix"),
        6..=15 if flags & COMPLEX > 0 => Node::other("complex numbers"),
        6..=15 => {
            let samples = match vector(&dims)? {
                Ok(n) => Ok(parts.numbers(n)?),
                Err(what) => Err(what),
            };
            Node::series(samples, None)
        }
        class => Node::other(format!("an object of class {class}")),
    };
    Ok((name, value))
}

/// Cells, one array each.
fn cells(parts: &mut Elements<'_>, dims: &[usize], depth: usize) -> Result<Node, Error> {
    let count = size(dims)?;
    let mut samples = Vec::new();
    let mut items = Vec::new();
    for _ in 0..count {
        let (_, value) = array(parts.next()?, parts.big, depth + 1)?;
        match value {
            value if count == 1 => return Ok(value),
            Node::Series(Channel { samples: Ok(single), .. }) if single.len() == 1 && items.is_empty() => {
                samples.extend(single);
            }
            Node::Fields(fields) if samples.is_empty() => items.push(Node::Fields(fields)),
            _ => return Ok(Node::other(format!("cells, {}", shape(dims)))),
        }
    }
    if !items.is_empty() {
        return Ok(Node::Items(items));
    }
    Ok(Node::series(vector(dims)?.map(|_| samples), None))
}

/// A structure, or several with the same fields.
fn structures(parts: &mut Elements<'_>, count: usize, depth: usize) -> Result<Node, Error> {
    let width = parts.lengths()?.first().copied().unwrap_or(0).max(1);
    let (_, names) = parts.next()?;
    let mut items = Vec::new();
    for _ in 0..count {
        // Structures without fields take no bytes.
        if names.is_empty() {
            break;
        }
        let mut fields = Vec::new();
        for name in names.chunks(width) {
            let (_, value) = array(parts.next()?, parts.big, depth + 1)?;
            fields.push((text(name), value));
        }
        items.push(Node::Fields(fields));
    }
    Ok(match items.pop() {
        Some(only) if items.is_empty() => only,
        last => Node::Items(items.into_iter().chain(last).collect()),
    })
}

/// A sequence of elements.
struct Elements<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Elements<'a> {
    /// The next element: its type and its bytes.
    fn next(&mut self) -> Result<(usize, &'a [u8]), Error> {
        let &mut Elements { bytes, at, big } = self;
        let tag = length(bytes, at, 4, big)?;
        // Up to four bytes are stored within the tag.
        if tag >> 16 > 0 {
            self.at += 8;
            return Ok((tag & 0xffff, part(bytes, at + 4, (tag >> 16).min(4))?));
        }
        let element = part(bytes, at + 8, length(bytes, at + 4, 4, big)?)?;
        // All elements except compressed ones are padded to eight bytes; the padding of the last one may be missing.
        let end = at + 8 + element.len();
        self.at = if tag == COMPRESSED { end } else { end.next_multiple_of(8).min(bytes.len()) };
        Ok((tag, element))
    }

    /// The next element as integers of four bytes, which are lengths.
    fn lengths(&mut self) -> Result<Vec<usize>, Error> {
        let (_, bytes) = self.next()?;
        (0..bytes.len() / 4).map(|k| length(bytes, 4 * k, 4, self.big)).collect()
    }

    /// The next element as a line of text: UTF-8, or code units of 16 bits.
    fn letters(&mut self) -> Result<String, Error> {
        let (kind, bytes) = self.next()?;
        if kind != 4 && kind != 17 {
            return Ok(String::from_utf8_lossy(bytes).into_owned());
        }
        let unit = if self.big { u16::from_be_bytes } else { u16::from_le_bytes };
        Ok(String::from_utf16_lossy(&bytes.as_chunks().0.iter().copied().map(unit).collect::<Vec<_>>()))
    }

    /// The next element as `count` numbers.
    fn numbers(&mut self, count: usize) -> Result<Vec<f64>, Error> {
        let (kind, bytes) = self.next()?;
        let (number, size) = match kind {
            1 => (NumberKind::Signed, 1),
            2 => (NumberKind::Unsigned, 1),
            3 => (NumberKind::Signed, 2),
            4 => (NumberKind::Unsigned, 2),
            5 => (NumberKind::Signed, 4),
            6 => (NumberKind::Unsigned, 4),
            7 => (NumberKind::Float, 4),
            9 => (NumberKind::Float, 8),
            12 => (NumberKind::Signed, 8),
            13 => (NumberKind::Unsigned, 8),
            other => return Err(damaged(format!("numbers of the unknown type {other}"))),
        };
        if count.checked_mul(size) != Some(bytes.len()) {
            return Err(damaged(format!("{} bytes for {count} numbers of {size} bytes", bytes.len())));
        }
        Ok(NumberFormat { kind: number, size, big: self.big }.read(bytes, size).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn words(numbers: [u32; 2]) -> Vec<u8> {
        numbers.map(u32::to_le_bytes).concat()
    }

    /// An array of a class, and what stands in it.
    fn matrix(class: u32, dims: [u32; 2], content: &[u8]) -> Vec<u8> {
        let head = [element(6, &words([class, 0])), element(5, &words(dims)), element(1, b"named")].concat();
        element(14, &[&head[..], content].concat())
    }

    fn numbers(values: &[f64]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        matrix(6, [1, values.len() as u32], &element(9, &bytes))
    }

    fn structure(value: &[u8]) -> Vec<u8> {
        let names = [element(5, &8u32.to_le_bytes()), element(1, b"u\0\0\0\0\0\0\0")].concat();
        matrix(2, [1, 1], &[&names[..], value].concat())
    }

    fn read(bytes: &[u8], depth: usize) -> Result<Node, Error> {
        array(Elements { bytes, at: 0, big: false }.next()?, false, depth).map(|(name, value)| {
            assert_eq!(name, "named");
            value
        })
    }

    fn series(values: &[f64]) -> Node {
        Node::series(Ok(values.to_vec()), None)
    }

    #[test]
    fn cells_are_their_content_or_numbers_or_structures_and_not_a_mixture() {
        let fields = |value: f64| Node::Fields(vec![("u".into(), series(&[value]))]);
        let cells = |content: &[Vec<u8>]| read(&matrix(1, [1, content.len() as u32], &content.concat()), 0).unwrap();
        let [one, two] = [1.0, 2.0].map(|value| numbers(&[value]));
        let [first, second] = [&one, &two].map(|value| structure(value));
        assert_eq!(cells(&[numbers(&[1.0, 2.0, 3.0])]), series(&[1.0, 2.0, 3.0]));
        assert_eq!(cells(&[one.clone(), two.clone()]), series(&[1.0, 2.0]));
        assert_eq!(cells(&[first.clone(), second.clone()]), Node::Items(vec![fields(1.0), fields(2.0)]));
        for mixed in [[first, two.clone()], [one, second], [two, numbers(&[1.0, 2.0])]] {
            assert_eq!(cells(&mixed), Node::other("cells, 1 x 2"));
        }
    }

    #[test]
    fn arrays_are_nested_only_so_deep() {
        let one = numbers(&[1.0]);
        assert!(read(&one, DEEPEST).is_ok() && read(&one, DEEPEST + 1).is_err());
        for outer in [matrix(1, [1, 1], &one), structure(&one)] {
            assert!(read(&outer, DEEPEST - 1).is_ok() && read(&outer, DEEPEST).is_err());
        }
        let error = read(&element(9, &[0; 8]), 0).unwrap_err().to_string();
        assert!(error.ends_with("an element of type 9, 0 deep, where an array should stand"), "{error}");
    }

    #[test]
    fn objects_are_left_out_and_text_is_read_in_each_encoding() {
        // It has no dimensions.
        let opaque = element(14, &[element(6, &words([17, 0])), element(1, b"named")].concat());
        assert_eq!(read(&opaque, 0), Ok(Node::other("an object of class 17")));
        assert_eq!(read(&matrix(4, [0, 0], &element(16, b"")), 0), Ok(Node::Text(String::new())));
        let letters = |bytes: &[u8], big| Elements { bytes, at: 0, big }.letters().unwrap();
        assert_eq!(letters(&element(16, "bender, \u{b5}m".as_bytes()), false), "bender, \u{b5}m");
        for kind in [4u8, 17] {
            let little = [&[kind, 0, 0, 0, 4, 0, 0, 0][..], &[0xb5, 0, b'm', 0]].concat();
            let big = [&[0, 0, 0, kind, 0, 0, 0, 4][..], &[0, 0xb5, 0, b'm']].concat();
            assert_eq!([letters(&little, false), letters(&big, true)], ["\u{b5}m", "\u{b5}m"], "{kind}");
        }
    }
}
