//! Zip archives as `numpy.savez` and `savez_compressed` write them: the directory at the end, members stored or
//! deflated; those that are written are stored. Not supported: more than 4 GiB, encryption, several disks.
//!
//! Reference: PKWARE, .ZIP File Format Specification 6.3,
//! <https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT>.

use crate::formats::bytes::{Unpacking, damaged, length, part, stored, whole};
use piezoid_numerics::error::Error;
use std::borrow::Cow;

const MEMBER: &[u8] = b"PK\x03\x04";
const ENTRY: &[u8] = b"PK\x01\x02";
const END: &[u8] = b"PK\x05\x06";

/// A member of an archive.
#[derive(Debug)]
pub(super) struct Member {
    pub(super) name: String,
    method: usize,
    checksum: u64,
    packed: usize,
    at: usize,
}

/// The name of the first member, if the archive begins with one.
pub(super) fn first(bytes: &[u8]) -> Option<&[u8]> {
    let len = length(bytes.strip_prefix(MEMBER)?, 22, 2, false).ok()?;
    part(bytes, 30, len).ok()
}

/// The entries of the directory.
pub(super) fn members(file: &[u8]) -> Result<Vec<Member>, Error> {
    let end = file.windows(END.len()).rposition(|window| window == END);
    let end = end.ok_or_else(|| damaged("the directory at its end is missing"))?;
    let (count, mut at) = (length(file, end + 10, 2, false)?, length(file, end + 16, 4, false)?);
    let mut members = Vec::new();
    for _ in 0..count {
        if part(file, at, ENTRY.len())? != ENTRY {
            return Err(damaged(format!("no entry of its directory stands at byte {at}")));
        }
        let number = |offset, size| length(file, at + offset, size, false);
        let name = part(file, at + 46, number(28, 2)?)?;
        members.push(Member {
            name: String::from_utf8_lossy(name).into_owned(),
            method: number(10, 2)?,
            // Not a length: on machines of 32 bits those end at 2^31.
            checksum: whole(file, at + 16, 4, false)?,
            packed: number(20, 4)?,
            at: number(42, 4)?,
        });
        at += 46 + name.len() + number(30, 2)? + number(32, 2)?;
    }
    Ok(members)
}

impl Member {
    /// Its unpacked bytes, whose checksum is checked.
    pub(super) fn bytes<'a>(&self, file: &'a [u8], unpacking: &mut Unpacking) -> Result<Cow<'a, [u8]>, Error> {
        let (name, at) = (&self.name, self.at);
        if part(file, at, MEMBER.len())? != MEMBER {
            return Err(damaged(format!("{name:?} does not stand at byte {at}")));
        }
        let head = 30 + length(file, at + 26, 2, false)? + length(file, at + 28, 2, false)?;
        let packed = part(file, at + head, self.packed)?;
        let bytes = match self.method {
            0 => Cow::Borrowed(packed),
            8 => Cow::Owned(unpacking.deflated(packed)?),
            other => {
                let what = format!("an unsupported compression (method {other}): save it with numpy.savez");
                return Err(Error::Content(format!("{name:?} has {what}")));
            }
        };
        if u64::from(crc32fast::hash(&bytes)) != self.checksum {
            return Err(damaged(format!("the checksum of {name:?} is wrong")));
        }
        Ok(bytes)
    }
}

/// The members of an archive with their bytes, in the order of its directory. Checksums are checked.
///
/// # Errors
/// Returns an error for a damaged archive, an unsupported compression, and more bytes than such an archive can have.
pub fn unpacked(file: &[u8]) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut unpacking = Unpacking::of(file);
    let read = |member: Member| {
        let bytes = member.bytes(file, &mut unpacking)?;
        if let Cow::Borrowed(stored) = &bytes {
            unpacking.count(stored.len())?;
        }
        let bytes = bytes.into_owned();
        Ok((member.name, bytes))
    };
    members(file)?.into_iter().map(read).collect()
}

/// An archive of these members. It has no dates: the same members give the same bytes.
pub fn archive(members: impl Iterator<Item = (String, Vec<u8>)>) -> Result<Vec<u8>, Error> {
    let short = |len: usize| {
        let advice = "more than 65535 columns, or a name of more than 65535 letters: choose fewer, or write CSV";
        u16::try_from(len).map(u16::to_le_bytes).map_err(|_| Error::Content(advice.into()))
    };
    let (mut file, mut directory, mut count) = (Vec::new(), Vec::new(), 0);
    for (name, bytes) in members {
        let (at, size, sum) = (stored(file.len())?, stored(bytes.len())?, crc32fast::hash(&bytes).to_le_bytes());
        // Version 2.0, names in UTF-8, stored, at the start of 1980, which is the first date there is.
        let fixed: &[u8] = &[20, 0, 0, 8, 0, 0, 0, 0, 0x21, 0];
        let head = [fixed, &sum, &size, &size, &short(name.len())?, &[0; 2]].concat();
        directory.extend([ENTRY, &[20, 0], &head, &[0; 10], &at, name.as_bytes()].concat());
        file.extend([MEMBER, &head, name.as_bytes()].concat());
        file.extend(bytes);
        count += 1;
    }
    let (count, size, at) = (short(count)?, stored(directory.len())?, stored(file.len())?);
    file.extend(directory);
    file.extend([END, &[0; 4], &count, &count, &size, &at, &[0; 2]].concat());
    Ok(file)
}
