//! Objects: the messages in their headers, of versions 1 and 2.

use super::{Hdf5File, newer};
use crate::Error;
use crate::formats::bytes::{damaged, length, part, text};

/// A group or a data set: the content of its header.
pub(super) struct Object<'a> {
    messages: Vec<Message<'a>>,
}

struct Message<'a> {
    kind: usize,
    /// True if the message is stored elsewhere.
    shared: bool,
    bytes: &'a [u8],
}

pub(super) const SPACE: usize = 1;
const LINK_INFO: usize = 2;
pub(super) const TYPE: usize = 3;
pub(super) const LINK: usize = 6;
pub(super) const LAYOUT: usize = 8;
pub(super) const FILTERS: usize = 11;
const ATTRIBUTE: usize = 12;
const CONTINUATION: usize = 16;
pub(super) const SYMBOLS: usize = 17;

impl<'a> Object<'a> {
    /// The messages of a kind that are stored here.
    pub(super) fn all(&self, kind: usize) -> impl Iterator<Item = &'a [u8]> {
        self.messages.iter().filter(move |m| m.kind == kind && !m.shared).map(|m| m.bytes)
    }

    /// The first message of a kind.
    pub(super) fn first(&self, kind: usize) -> Option<&'a [u8]> {
        self.all(kind).next()
    }

    pub(super) fn is_group(&self) -> bool {
        self.messages.iter().any(|message| [SYMBOLS, LINK_INFO, LINK].contains(&message.kind))
    }

    /// True if the links of a group are stored in a separate heap, because there are many.
    pub(super) fn is_large(&self) -> Result<bool, Error> {
        let Some(info) = self.first(LINK_INFO) else { return Ok(false) };
        // After the largest creation order, if it is stored.
        let at = if length(info, 1, 1, false)? & 1 > 0 { 10 } else { 2 };
        Ok(part(info, at, 8)? != [0xff; 8])
    }
}

impl<'a> Hdf5File<'a> {
    /// The object whose header is at an address.
    pub(super) fn object(&mut self, at: usize) -> Result<Object<'a>, Error> {
        let second = part(self.bytes, at, 4)? == b"OHDR";
        let (first, extra) = if second {
            let flags = self.number(at + 5, 1)?;
            let times = if flags & 0x20 > 0 { 16 } else { 0 };
            let limits = if flags & 0x10 > 0 { 4 } else { 0 };
            let (start, width) = (at + 6 + times + limits, 1 << (flags & 3));
            ((start + width, self.number(start, width)?), if flags & 4 > 0 { 2 } else { 0 })
        } else {
            if self.number(at, 1)? != 1 {
                return Err(damaged(format!("no object stands at address {at}")));
            }
            ((at + 16, self.number(at + 8, 4)?), 0)
        };
        let mut blocks = vec![first];
        let mut messages = Vec::new();
        while let Some((at, len)) = blocks.pop() {
            self.visit()?;
            let block = part(self.bytes, at, len)?;
            let head = if second { 4 + extra } else { 8 };
            let mut at = 0;
            while at + head <= block.len() {
                let number = |offset, size| length(block, at + offset, size, false);
                let (kind, len, flags) = if second {
                    (number(0, 1)?, number(1, 2)?, number(3, 1)?)
                } else {
                    (number(0, 2)?, number(2, 2)?, number(4, 1)?)
                };
                let bytes = part(block, at + head, len)?;
                if kind == CONTINUATION {
                    let (at, len) = (length(bytes, 0, 8, false)?, length(bytes, 8, 8, false)?);
                    // Blocks of version 2 begin with a signature and end with a checksum.
                    blocks.push(if second { (at + 4, len.saturating_sub(8)) } else { (at, len) });
                } else {
                    messages.push(Message { kind, shared: flags & 2 > 0, bytes });
                }
                at += head + len;
            }
        }
        Ok(Object { messages })
    }
}

/// The value of an attribute, if it is a number or a text that is stored here.
pub(super) fn attribute<'a>(object: &Object<'a>, wanted: &str) -> Result<Option<&'a [u8]>, Error> {
    for bytes in object.all(ATTRIBUTE) {
        let number = |at| length(bytes, at, 2, false);
        // Version 1 pads its parts to eight bytes; version 3 states the encoding of names.
        let (start, fill) = match length(bytes, 0, 1, false)? {
            1 => (8, 8),
            2 => (8, 1),
            3 => (9, 1),
            version => return Err(newer(format!("attributes of version {version}"))),
        };
        let name = part(bytes, start, number(2)?)?;
        if text(name) == wanted {
            let [name, kind, space] = [number(2)?, number(4)?, number(6)?].map(|len| len.next_multiple_of(fill));
            let here = matches!(length(bytes, start + name, 1, false)? & 15, 0 | 3);
            return Ok(bytes.get(start + name + kind + space..).filter(|_| here));
        }
    }
    Ok(None)
}
